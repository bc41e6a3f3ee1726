"""File names in parameters."""

import os

from social_fleet.scenario.locations import resolve


def resolve_path(name: str) -> str:
    """`name` as an absolute path: package://social_fleet/… or relative to where roslaunch or rosrun was called.

    roslaunch moves its nodes to another folder, but leaves PWD in their environment.
    """
    return resolve(name, os.environ.get("PWD") or os.getcwd())
