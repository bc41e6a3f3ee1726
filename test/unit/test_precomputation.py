"""Social costs from the cache: the same as worked out, and never those of something else."""

import ast
import dataclasses
import inspect

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning import cache
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.social_cost import precomputation
from social_fleet.planning.social_cost.norms import NoNorm
from social_fleet.planning.social_cost.zones import Zone

GRID = grid_from_text("\n".join(["#" * 40, *["#" + "." * 38 + "#"] * 18, "#" * 40]), 0.2)
LATTICE = Lattice(ConfigurationSpace(GRID, 0.28))
CONFIG = PlannerConfig()


@pytest.fixture
def computed(tmp_path, monkeypatch):
    """An empty cache, and a list that grows whenever costs are worked out."""
    monkeypatch.setenv(cache.FOLDER, str(tmp_path))
    calls = []
    honest = precomputation.edge_costs

    def counted(*args, **options):
        calls.append(args)
        return honest(*args, **options)

    monkeypatch.setattr(precomputation, "edge_costs", counted)
    return calls


def test_the_second_planner_of_a_map_takes_the_first_ones_costs(computed):
    first, second = (precomputation.social_costs(LATTICE, GRID, CONFIG, None) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert len(computed) == 1


@pytest.mark.parametrize("change", [{"side": "left"}, {"w_right": 2.0}, {"wall_stretch": 2.0}, {"robot_radius": 0.2}])
def test_other_parameters_have_other_costs(computed, change):
    precomputation.social_costs(LATTICE, GRID, CONFIG, None)
    other = dataclasses.replace(CONFIG, **change)
    np.testing.assert_array_equal(precomputation.social_costs(LATTICE, GRID, other, None),
                                  precomputation.edge_costs(LATTICE, GRID.blocked, precomputation.norm_of(other),
                                                            stretch=other.wall_stretch))
    assert len(computed) == 3


def test_a_norm_that_was_made_elsewhere_is_asked_every_time(computed):
    for _ in range(2):
        assert not precomputation.social_costs(LATTICE, GRID, CONFIG, NoNorm())[np.isfinite(
            precomputation.social_costs(LATTICE, GRID, CONFIG, NoNorm()))].any()
    assert len(computed) == 4


@pytest.mark.parametrize("config, zones", [
    (dataclasses.replace(CONFIG, norm="own_norms.KeepOff"), ()),
    (CONFIG, [Zone("east", [(4.0, 0.0), (8.0, 0.0), (8.0, 4.0)], {"norm": "own_norms.KeepOff"})])])
def test_a_norm_of_ones_own_is_asked_every_time_for_what_it_may_read(computed, config, zones):
    for _ in range(2):
        precomputation.social_costs(LATTICE, GRID, config, None, zones)
    assert len(computed) == 2


def test_zones_with_numbers_of_numpy_are_cached(computed):
    zones = [Zone("east", [(4.0, 0.0), (8.0, 0.0), (8.0, 4.0)], {"w_right": np.float32(2.0)})]
    for _ in range(2):
        precomputation.social_costs(LATTICE, GRID, CONFIG, None, zones)
    assert len(computed) == 1


def test_costs_are_keyed_by_all_the_code_that_makes_them():
    """Whatever they import, too; but for modules that hold no arithmetic of theirs."""
    known = {module.__name__ for module in precomputation._SOURCES}
    harmless = {f"social_fleet.{name}" for name in ("errors", "files", "geometry", "parameters")}
    for module in precomputation._SOURCES:
        imported = [node for node in ast.walk(ast.parse(inspect.getsource(module)))
                    if isinstance(node, ast.ImportFrom) and str(node.module).startswith("social_fleet")]
        assert {node.module for node in imported} <= known | harmless, module.__name__
