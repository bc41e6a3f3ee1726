"""The planner's parameters. `config/planner.yaml` is their manual."""

from dataclasses import dataclass
from typing import Any, Optional, Tuple

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import Parameters, parameter

SIDES = ("right", "left", "none")
LONGEST = 1000.0  # [m] of any length, far beyond what makes a difference
HEAVIEST = 10000.0  # of any weight: enough to outweigh any way round, while sums of costs are still exact


def _length(default: Optional[float], *, above: Optional[float] = None) -> Any:
    """A length [m] from 0 on, or more than `above`."""
    return parameter(default, above=above, minimum=0.0, maximum=LONGEST)


def _weight(default: float) -> Any:
    return parameter(default, minimum=0.0, maximum=HEAVIEST)


@dataclass(frozen=True)
class PlannerConfig(Parameters):
    """Parameters of the social planner; config/planner.yaml says when to change which.

    Raises
    ------
    InvalidParameter
        When a value is of a wrong type or out of range; `field` names it.
    """

    robot_radius: float = _length(0.25, above=0.0)  # of the robot's disc [m]
    wall_margin: float = _length(0.03)  # kept beyond the radius on the way, for tracking errors [m]
    side: str = parameter("right", choices=SIDES)  # the side to keep
    norm: Optional[str] = None  # package.module.Class of a norm of one's own; None: keep `side`
    w_right: float = _weight(1.0)  # Eq. 3, per metre of travel and metre from the lane
    w_const: float = _weight(2.0)  # Eq. 3, per metre of drift from the wall
    w_buf: float = _weight(5.0)  # Eq. 3, per metre of travel and metre of missing buffer
    buffer_distance: float = _length(4.0)  # room for others beside a far wall, d_buf [m]
    standoff: Optional[float] = _length(None)  # of the lane from its wall [m]; None: radius + 0.1
    open_area: float = _length(7.0, above=0.0)  # beyond this distance a wall does not guide [m]
    lane_pull: float = _length(2.0, above=0.0)  # distance from the lane beyond which the cost grows no further [m]
    wall_stretch: float = _length(1.0)  # openings up to this width do not interrupt a wall [m]
    single_lane_width: Optional[float] = _length(None)  # up to here the middle [m]; None: 4 radii + 0.1
    two_lane_width: Optional[float] = _length(None)  # from here on lanes [m]; None: 4 radii + 0.3
    exemption_radius: float = _length(2.0)  # no social cost so near to start and goal [m]
    epsilon: float = _length(0.01)  # Eq. 4, extra cost of a step off the social graph [m]
    smoothing_bound: float = _weight(0.2)  # share of a path's cost that one chord may cost more
    corner_radius: float = _length(0.8)  # largest radius of a rounded corner [m]; 0: sharp corners
    heatmap_threshold: int = parameter(1, minimum=0, maximum=65534)  # paths that an edge of the graph must exceed
    min_component: int = parameter(15, minimum=1)  # smallest number of nodes of a part of the social graph
    temporary_distance: float = _length(2.5)  # plans this near to an obstacle are temporary [m]
    promotion_threshold: int = parameter(50, minimum=0)  # detours after which an obstacle is permanent; 0: never

    def __post_init__(self) -> None:
        super().__post_init__()
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
