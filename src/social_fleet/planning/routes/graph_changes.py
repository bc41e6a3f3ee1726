"""Social graphs of several robots made one, and graphs brought over to another map."""

import math
from typing import NamedTuple, Sequence, Tuple

import numpy as np

from social_fleet.errors import InvalidGraph
from social_fleet.geometry import wrap_angle
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.mapping.walls import HEADINGS
from social_fleet.planning.routes.heatmaps import EdgeCounts
from social_fleet.planning.routes.social_graph import SocialGraph


def merged(graphs: Sequence[SocialGraph], threshold: int, min_component: int) -> SocialGraph:
    """What several robots learnt on one map, as if one had counted all their paths.

    The order of the graphs does not matter, nor whether some of them were merged before.

    Parameters
    ----------
    graphs : sequence of SocialGraph
        At least one, all of the same map and with counts.
    threshold, min_component : int
        As for `SocialGraph.extract`.

    Raises
    ------
    InvalidGraph
        When there is none, or one is of another map or has no counts.
    """
    if not graphs:
        raise InvalidGraph("there is nothing to merge", field="graphs")
    first = graphs[0]
    for number, graph in enumerate(graphs):
        if graph.digest != first.digest or graph.edges.shape != first.edges.shape:
            raise InvalidGraph("was learnt on another map than the first; bring it over before",
                               field=f"graphs[{number}]")
        if graph.counts is None:
            raise InvalidGraph("does not say how many paths used its edges; learn it again", field=f"graphs[{number}]")
    counts = EdgeCounts.total((first.edges.shape[0], first.edges.shape[1]),
                              [graph.counts for graph in graphs if graph.counts is not None])
    return SocialGraph.from_counts(counts, threshold, min_component, digest=first.digest, resolution=first.resolution,
                                   origin=first.origin)


class Adapted(NamedTuple):
    """A graph on another map, and how many of its edges were `kept` and `dropped`."""

    graph: SocialGraph
    kept: int
    dropped: int


def adapted(graph: SocialGraph, grid: OccupancyGrid) -> Adapted:
    """What still holds of a graph on another map in the same frame.

    An edge stays when both its cells, found by where they lie, are on the map and not blocked there. Where the cells
    of the two maps do not coincide, an edge moves by up to half a cell along each axis.

    Parameters
    ----------
    graph : SocialGraph
        Learnt on the old map.
    grid : OccupancyGrid
        The new map.

    Raises
    ------
    InvalidGraph
        When it does not say where its map lay, or the new map's cells are of another size or turned.
    """
    down, right = _offset(graph, grid)
    numbers = graph.edge_numbers
    kept = _moved(EdgeCounts((graph.edges.shape[0], graph.edges.shape[1]), numbers,
                             np.ones(len(numbers), dtype=np.uint16)), down, right, grid)
    edges = np.zeros(grid.shape, dtype=np.uint8)
    heading, row, column = kept.places
    np.bitwise_or.at(edges, (row, column), (1 << heading).astype(np.uint8))
    counts = None if graph.counts is None else _moved(graph.counts, down, right, grid)
    return Adapted(SocialGraph(edges, grid.digest, grid.resolution, origin=grid.origin, counts=counts),
                   len(kept.edges), len(numbers) - len(kept.edges))


def _offset(graph: SocialGraph, grid: OccupancyGrid) -> Tuple[int, int]:
    """Rows and columns by which the old map's cells lie farther along the new map's axes."""
    if graph.origin is None:
        raise InvalidGraph("does not say where its map lay; learn it again on this one", field="origin")
    if not math.isclose(graph.resolution, grid.resolution, rel_tol=1e-6):
        raise InvalidGraph(f"was learnt on cells of {graph.resolution:g} m, and the map has cells of "
                           f"{grid.resolution:g} m; learn it again on this one", field="resolution")
    turn = wrap_angle(graph.origin.yaw - grid.origin.yaw)
    # Turned by so little, the far corner of a map is less than half a cell off.
    if abs(turn) * max(*graph.edges.shape, *grid.shape) > 0.5:
        raise InvalidGraph(f"was learnt on a map turned by {math.degrees(turn):.1f} degrees against this one; learn it "
                           "again", field="yaw")
    columns, rows = np.round(grid.to_local([graph.origin[:2]])[0] / grid.resolution)
    return int(rows), int(columns)


def _moved(counts: EdgeCounts, down: int, right: int, grid: OccupancyGrid) -> EdgeCounts:
    """Counts at the same places on `grid`, without those whose edges leave its free cells."""
    heading, row, column = counts.places
    tails = np.stack([row + down, column + right], axis=1)
    heads = tails + HEADINGS[heading][:, ::-1]
    holds = np.ones(len(tails), dtype=bool)
    for ends in (tails, heads):
        inside = ((ends >= 0) & (ends < grid.shape)).all(axis=1)
        holds &= inside
        holds[inside] &= ~grid.blocked[tuple(ends[inside].T)]
    numbers = (heading[holds] * grid.shape[0] + tails[holds, 0]) * grid.shape[1] + tails[holds, 1]
    return EdgeCounts(grid.shape, numbers, counts.counts[holds])
