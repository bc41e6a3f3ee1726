"""Social costs from the cache on disk, where all that they depend on can be told."""

import dataclasses
import inspect
from typing import Any, Optional, Sequence

import numpy as np

from social_fleet.mapping import clearance, distances, walls
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning import lattice as lattices
from social_fleet.planning.cache import cached, digest_of, source_of
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.social_cost import costs, norms, zones as zone_files
from social_fleet.planning.social_cost.costs import edge_costs
from social_fleet.planning.social_cost.norms import Norm, norm_of
from social_fleet.planning.social_cost.zones import Zone, zoned_norms

# What costs are computed with: when one of these files changes, what is cached does not hold any more.
_SOURCES = (clearance, distances, walls, costs, lattices, norms, zone_files)


def social_costs(lattice: Lattice, grid: OccupancyGrid, config: PlannerConfig, norm: Optional[Norm],
                 zones: Sequence[Zone] = ()) -> np.ndarray:
    """The social cost of every edge, (N, 8) float32 [m]: see `edge_costs`.

    Parameters
    ----------
    lattice : Lattice
        The graph.
    grid : OccupancyGrid
        The map that it was made from.
    config : PlannerConfig
        Parameters.
    norm : Norm, optional
        What to charge; by default what the configuration says. What another one depends on cannot be told, so it is
        asked anew every time.
    zones : sequence of Zone
        Where other norms hold.
    """
    chosen = norm or norm_of(config)
    zoned = zoned_norms(grid, lattice.cells(np.arange(len(lattice))), config, zones)

    def compute() -> np.ndarray:
        return edge_costs(lattice, grid.blocked, chosen, stretch=config.wall_stretch, zoned=zoned)

    sources = [_source(type(each)) for each in (chosen, *(other for _, other in zoned))]
    if norm is not None or None in sources:
        return compute()
    parts = [[zone.name, zone.polygon, dict(zone.overrides)] for zone in zones]
    digest = digest_of(grid.digest, dataclasses.asdict(config), parts, sources, source_of(*_SOURCES))
    return cached("costs", digest, lambda: {"social": compute()})["social"]


def _source(thing: Any) -> Optional[str]:
    """The text of a class or module; None where it cannot be had."""
    try:
        return inspect.getsource(inspect.getmodule(thing) or thing)
    except (OSError, TypeError):
        return None
