"""The planner's parameters. `config/planner.yaml` is their manual."""

from dataclasses import dataclass
from typing import Any, Mapping, Optional, Tuple

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import check_parameters, from_mapping, parameter

SIDES = ("right", "left", "none")


@dataclass(frozen=True)
class PlannerConfig:
    """Parameters of the social planner; config/planner.yaml says when to change which.

    Raises
    ------
    InvalidParameter
        When a value is of a wrong type or out of range; `field` names it.
    """

    robot_radius: float = parameter(0.25, above=0.0)  # of the robot's disc [m]
    wall_margin: float = parameter(0.03, minimum=0.0)  # kept beyond the radius on the way, for tracking errors [m]
    side: str = parameter("right", choices=SIDES)  # the side to keep
    norm: Optional[str] = None  # package.module.Class of a norm of one's own; None: keep `side`
    w_right: float = parameter(1.0, minimum=0.0)  # Eq. 3, per metre of travel and metre from the lane
    w_const: float = parameter(2.0, minimum=0.0)  # Eq. 3, per metre of drift from the wall
    w_buf: float = parameter(5.0, minimum=0.0)  # Eq. 3, per metre of travel and metre of missing buffer
    buffer_distance: float = parameter(4.0, minimum=0.0)  # room for others beside a far wall, d_buf [m]
    standoff: Optional[float] = parameter(None, minimum=0.0)  # of the lane from its wall [m]; None: radius + 0.1
    open_area: float = parameter(7.0, above=0.0)  # beyond this distance a wall does not guide [m]
    lane_pull: float = parameter(2.0, above=0.0)  # distance from the lane beyond which the cost grows no further [m]
    wall_stretch: float = parameter(1.0, minimum=0.0)  # openings up to this width do not interrupt a wall [m]
    single_lane_width: Optional[float] = parameter(None, minimum=0.0)  # up to here the middle [m]; None: 4 radii + 0.1
    two_lane_width: Optional[float] = parameter(None, minimum=0.0)  # from here on lanes [m]; None: 4 radii + 0.3
    exemption_radius: float = parameter(2.0, minimum=0.0)  # no social cost so near to start and goal [m]
    epsilon: float = parameter(0.01, minimum=0.0)  # Eq. 4, extra cost of a step off the social graph [m]
    smoothing_bound: float = parameter(0.2, minimum=0.0)  # share of a path's cost that one chord may cost more
    corner_radius: float = parameter(0.8, minimum=0.0)  # largest radius of a rounded corner [m]; 0: sharp corners
    heatmap_threshold: int = parameter(1, minimum=0)  # paths that an edge of the social graph has to exceed
    min_component: int = parameter(15, minimum=1)  # smallest number of nodes of a part of the social graph
    temporary_distance: float = parameter(2.5, minimum=0.0)  # plans this near to an obstacle are temporary [m]
    promotion_threshold: int = parameter(50, minimum=0)  # detours after which an obstacle is permanent; 0: never

    def __post_init__(self) -> None:
        check_parameters(self)
        single, two = self.fade_widths
        if two < single:
            raise InvalidParameter(f"must be at least single_lane_width ({single:g}), not {two:g}",
                                   field="two_lane_width")

    @property
    def lane_standoff(self) -> float:
        """Distance of the lane's centre line from its wall [m]."""
        return self.robot_radius + 0.1 if self.standoff is None else self.standoff

    @property
    def fade_widths(self) -> Tuple[float, float]:
        """Corridor widths [m] up to which there is no lane, and from which on there are two."""
        single, two = self.single_lane_width, self.two_lane_width
        return (4.0 * self.robot_radius + 0.1 if single is None else single,
                4.0 * self.robot_radius + 0.3 if two is None else two)

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any], *, source: str = "", prefix: str = "") -> "PlannerConfig":
        """Read from a YAML file's or parameter server's mapping; refuses unknown keys and wrong types."""
        return from_mapping(cls, mapping, source=source, prefix=prefix)
