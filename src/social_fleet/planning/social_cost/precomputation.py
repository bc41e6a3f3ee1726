"""Social costs from the cache on disk, where all that they depend on can be told."""

import dataclasses
from typing import Optional, Sequence

import numpy as np

from social_fleet.mapping import clearance, distances, grid as grids, polygons, walls
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning import config as planner_config, lattice as lattices
from social_fleet.planning.cache import cached, digest_of, source_of
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.social_cost import costs, norms, zones as zone_files
from social_fleet.planning.social_cost.costs import edge_costs
from social_fleet.planning.social_cost.norms import Norm, norm_of
from social_fleet.planning.social_cost.zones import Zone, zoned_norms

# What costs are computed with: when one of these files changes, what is cached does not hold any more.
_SOURCES = (clearance, distances, grids, polygons, walls, planner_config, costs, lattices, norms, zone_files)


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
        What to charge; by default what the configuration says. What a norm of somebody else's depends on, named in the
        configuration or not, cannot be told, so it is asked anew every time.
    zones : sequence of Zone
        Where other norms hold.
    """
    chosen = norm or norm_of(config)
    zoned = zoned_norms(grid, lattice.cells(np.arange(len(lattice))), config, zones)

    def compute() -> np.ndarray:
        return edge_costs(lattice, grid.blocked, chosen, stretch=config.wall_stretch, zoned=zoned)

    every = (chosen, *(other for _, other in zoned))
    if norm is not None or any(type(each).__module__ != norms.__name__ for each in every):
        return compute()
    parts = [[zone.name, zone.polygon, dict(zone.overrides)] for zone in zones]
    digest = digest_of(grid.digest, dataclasses.asdict(config), parts, source_of(*_SOURCES))
    return cached("costs", digest, lambda: {"social": compute()})["social"]
