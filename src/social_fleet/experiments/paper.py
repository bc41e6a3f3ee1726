"""The figures that Sato and Law print, to be shown beside ours."""

from typing import Dict, Tuple

# Table 2, by map and planner: mean and standard deviation of path length [m], right distance [m], time [s].
# Environment 3 is a floor that is not to be had; the office floor stands in for it, so these are for scale only.
TABLE_2: Dict[str, Dict[str, Tuple[Tuple[float, float], ...]]] = {
    "environment_1": {"shortest": ((64.3, 33.33), (8.31, 8.49), (0.348, 0.697)),
                      "rrt_star": ((68.1, 37.0), (27.3, 38.1), (0.764, 1.126)),
                      "social": ((74.0, 37.4), (2.64, 5.95), (20.7, 18.0))},
    "environment_2": {"shortest": ((77.5, 36.6), (12.6, 14.5), (6.40, 8.39)),
                      "rrt_star": ((89.4, 48.2), (24.7, 26.2), (31.0, 35.7)),
                      "social": ((94.1, 44.4), (9.69, 15.2), (56.8, 51.7))},
    "office_floor": {"shortest": ((46.6, 26.0), (2.43, 2.21), (3.78, 5.19)),
                     "rrt_star": ((49.7, 28.1), (10.1, 20.0), (6.36, 12.18)),
                     "social": ((52.9, 29.8), (1.17, 1.12), (30.6, 22.6))},
}

# Table 3, by number of robots: mean and standard deviation of the share of the time that distributing the search for
# encounter windows saves, on their robots' hardware.
TABLE_3: Dict[int, Tuple[float, float]] = {3: (0.551, 0.132), 4: (0.672, 0.069), 5: (0.784, 0.018)}
