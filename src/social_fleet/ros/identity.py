"""Which robot a node belongs to."""

import rospy

from social_fleet.errors import InvalidParameter
from social_fleet.ros import parameters


def robot_name(given: str) -> str:
    """`given`, or the last part of the node's namespace; raises InvalidParameter when there is neither."""
    name = given or str(rospy.get_namespace()).strip("/").split("/")[-1]
    if not name:
        raise InvalidParameter("is empty and the node has no namespace; give the robot's name",
                               field=f"{parameters.private_prefix()}robot")
    return name
