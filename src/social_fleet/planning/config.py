"""The planner's parameters: one frozen value that checks itself. `config/planner.yaml` is their manual."""

import math
from dataclasses import dataclass, fields
from typing import Any, Dict, Mapping, Optional, Tuple

from social_fleet.errors import InvalidParameter

SIDES = ("right", "left", "none")


@dataclass(frozen=True)
class PlannerConfig:
    """Parameters of the social planner; `config/planner.yaml` says when to change which.

    Attributes
    ----------
    robot_radius : float
        Radius of the robot's disc [m].
    side : str
        The side to keep: ``right``, ``left`` or ``none``.
    w_right, w_const, w_buf : float
        Weights of Eq. 3: per metre of travel and metre of distance, per metre of drift, per metre and metre.
    buffer_distance : float
        Room to leave to the far wall in open areas, d_buf [m].
    standoff : float, optional
        Distance of the lane's centre line from its wall [m]; None: `robot_radius` + 0.1.
    open_area : float
        Beyond this distance a wall no longer guides [m].
    wall_stretch : float
        Openings of a wall up to this width [m], such as doors, do not interrupt it.
    single_lane_width, two_lane_width : float, optional
        Corridors up to the first are driven in the middle, from the second on in lanes, and the preference fades
        in between [m]; None: 4 radii + 0.1 and 4 radii + 0.35.
    exemption_radius : float
        No social cost within this distance of start and goal [m].
    epsilon : float
        What a step off the social graph costs extra, Eq. 4 [m].
    smoothing_bound : float
        A straight piece may cost at most this share more than the searched piece that it replaces.
    corner_radius : float
        Largest radius of a rounded corner [m]; 0 leaves corners sharp.
    heatmap_threshold, min_component : int
        An edge enters the social graph when more than so many paths used it; components with fewer nodes don't.

    Raises
    ------
    InvalidParameter
        When a value has the wrong type or is out of its range; `field` names it.
    """

    robot_radius: float = 0.25
    side: str = "right"
    w_right: float = 1.0
    w_const: float = 2.0
    w_buf: float = 5.0
    buffer_distance: float = 4.0
    standoff: Optional[float] = None
    open_area: float = 7.0
    wall_stretch: float = 1.0
    single_lane_width: Optional[float] = None
    two_lane_width: Optional[float] = None
    exemption_radius: float = 2.0
    epsilon: float = 0.01
    smoothing_bound: float = 0.5
    corner_radius: float = 0.8
    heatmap_threshold: int = 2
    min_component: int = 15

    def __post_init__(self) -> None:
        for item in fields(self):
            self._check_type(item.name, str(item.type))
        if self.side not in SIDES:
            raise InvalidParameter(f"must be one of {', '.join(SIDES)}, not {self.side!r}", field="side")
        for name in ("robot_radius", "open_area"):
            self._check(name, getattr(self, name) > 0.0, "must be positive")
        for name in ("w_right", "w_const", "w_buf", "wall_stretch", "buffer_distance", "exemption_radius", "epsilon",
                     "smoothing_bound", "corner_radius", "heatmap_threshold", "min_component"):
            self._check(name, getattr(self, name) >= 0, "must not be negative")
        for name in ("standoff", "single_lane_width", "two_lane_width"):
            self._check(name, (getattr(self, name) or 0.0) >= 0.0, "must not be negative")
        if self.fade_widths[1] < self.fade_widths[0]:
            raise InvalidParameter(f"must be at least single_lane_width ({self.fade_widths[0]:.3g} m), not "
                                   f"{self.fade_widths[1]:.3g}", field="two_lane_width")

    def _check_type(self, name: str, annotation: str) -> None:
        value = getattr(self, name)
        if "str" in annotation:
            self._check(name, isinstance(value, str), "must be a word")
            return
        if value is None and "Optional" in annotation:
            return
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if "int" in annotation:
            self._check(name, number and float(value).is_integer(), "must be a whole number")
        else:
            self._check(name, number and math.isfinite(value), "must be a finite number")

    def _check(self, name: str, holds: bool, sentence: str) -> None:
        if not holds:
            raise InvalidParameter(f"{sentence}, not {getattr(self, name)!r}", field=name)

    @property
    def lane_standoff(self) -> float:
        """Distance of the lane's centre line from its wall [m]."""
        return self.robot_radius + 0.1 if self.standoff is None else self.standoff

    @property
    def fade_widths(self) -> Tuple[float, float]:
        """Corridor widths [m] up to which there is no lane and from which there are two."""
        single, two = self.single_lane_width, self.two_lane_width
        return (4.0 * self.robot_radius + 0.1 if single is None else single,
                4.0 * self.robot_radius + 0.35 if two is None else two)

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any], *, source: str = "") -> "PlannerConfig":
        """The configuration with the values of `mapping`, defaults elsewhere.

        Raises
        ------
        InvalidParameter
            When a key is unknown or a value is wrong; `source` says where the mapping came from.
        """
        known = [item.name for item in fields(cls)]
        for key in mapping:
            if key not in known:
                raise InvalidParameter(f"is no parameter of the planner; known are {', '.join(known)}",
                                       source=source, field=str(key))
        values: Dict[str, Any] = dict(mapping)
        try:
            return cls(**values)
        except InvalidParameter as error:
            raise InvalidParameter(error.message, source=source, field=error.field) from error
