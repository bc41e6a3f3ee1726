"""Rows of both orders: what they ask for of the first robot while the second stands at a place to wait."""

import numpy as np
import pytest
from fleets import random_path

from social_fleet.coordination.conflict_regions import LINK, cut_into_links
from social_fleet.coordination.window_rows import WindowRows, window_rows
from social_fleet.geometry import Polyline

DISTANCE = 0.7
FINE = tuple(np.arange(0.0, 60.0, 0.5 * LINK))


def asked(rows: WindowRows, side: int, upto: float) -> np.ndarray:
    """How far the first robot has to be past in each window before the second leaves `upto` [m]; -1 for anywhere."""
    found = []
    for low, high in zip(rows.starts[side:-1:2], rows.starts[side + 1::2]):
        passed = rows.clear[low:high][rows.at[low:high] < upto - 1e-6]
        found.append(passed.max() if len(passed) else -1.0)
    return np.array(found)


@pytest.mark.parametrize("seed", range(25))
def test_up_to_a_stop_only_what_is_needed_is_asked_for(seed: int) -> None:
    rng = np.random.RandomState(seed)
    r, s = (cut_into_links(Polyline(random_path(rng, 6, 8.0))) for _ in range(2))
    stops = tuple(rng.choice(s.starts, min(len(s.starts), 3)).tolist())
    few, fine = (window_rows(r, s, DISTANCE, stops=((), given)) for given in (stops, FINE))
    for stop in stops:
        np.testing.assert_allclose(asked(few, 0, stop), asked(fine, 0, stop))
    assert len(few.at) <= len(fine.at)


def test_stops_cost_a_row_each_at_most() -> None:
    lane = cut_into_links(Polyline(np.array([(0.0, 0.0), (30.0, 0.0)])))
    without = window_rows(lane, lane, DISTANCE)
    assert len(window_rows(lane, lane, DISTANCE, stops=((5.0, 9.0), ())).at) <= len(without.at) + 2
    assert len(window_rows(lane, lane, DISTANCE, stops=(FINE, ())).at) > 1.5 * len(without.at)
