"""The social graph: routes that the fleet has established (3.2.2)."""

from typing import TYPE_CHECKING, Any, Callable, Optional, Tuple

import numpy as np

from social_fleet.errors import InvalidGraph, InvalidInput
from social_fleet.files import PathLike
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.mapping.walls import HEADINGS
from social_fleet.planning.routes.heatmaps import EdgeCounts, Heatmaps

if TYPE_CHECKING:
    from social_fleet.planning.planner import SocialPlanner


class SocialGraph:
    """Directed edges between neighbouring cells that cost their length only (Eq. 4).

    Parameters
    ----------
    edges : (rows, cols) uint8 array
        Bit k of a cell is set where its edge in heading k (counter-clockwise from the columns) belongs to the graph.
    digest : str
        `OccupancyGrid.digest` of the map that it was learnt on.
    resolution : float
        Of that map [m].
    origin : Pose, optional
        Of that map [m, rad]; without it the graph cannot be adapted to another map.
    counts : EdgeCounts, optional
        What it was extracted from; without them it cannot be merged.

    Raises
    ------
    InvalidGraph
        When an array has another shape or type, or an edge leaves the map.
    """

    def __init__(self, edges: np.ndarray, digest: str, resolution: float, *, origin: Optional[Pose] = None,
                 counts: Optional[EdgeCounts] = None) -> None:
        edges = np.array(edges)
        if edges.ndim != 2 or edges.dtype != np.uint8:
            raise InvalidGraph(f"needs rows and columns of uint8, not shape {edges.shape} of {edges.dtype}",
                               field="edges")
        beyond = [edges[:, -1] & 0b10000011, edges[:, 0] & 0b00111000, edges[-1] & 0b00001110, edges[0] & 0b11100000]
        if any(border.any() for border in beyond):
            raise InvalidGraph("an edge leaves the map", field="edges")
        if counts is not None and counts.shape != edges.shape:
            raise InvalidGraph(f"counts of {counts.shape} cells do not fit edges of {edges.shape}", field="counts")
        edges.setflags(write=False)
        self.edges = edges
        self.digest = digest
        self.resolution = resolution
        self.origin = origin
        self.counts = counts

    @classmethod
    def extract(cls, heatmaps: Heatmaps, threshold: int, min_component: int, *, grid: OccupancyGrid) -> "SocialGraph":
        """Edges that more than `threshold` paths used, without components of fewer than `min_component` nodes.

        Parameters
        ----------
        heatmaps : Heatmaps
            What the fleet's paths have left.
        threshold : int
            Number of paths that an edge has to exceed.
        min_component : int
            Smallest number of nodes of a weakly connected component that stays.
        grid : OccupancyGrid
            The map.
        """
        if heatmaps.shape != grid.shape:
            raise InvalidGraph(f"heatmaps of {heatmaps.shape} cells do not fit a map of {grid.shape}", field="heatmaps")
        return cls.from_counts(heatmaps.edge_counts(), threshold, min_component, digest=grid.digest,
                               resolution=grid.resolution, origin=grid.origin)

    @classmethod
    def from_counts(cls, counts: EdgeCounts, threshold: int, min_component: int, *, digest: str, resolution: float,
                    origin: Optional[Pose]) -> "SocialGraph":
        """As `extract`, from counts; the same counts always give the same graph."""
        heading, row, col = counts.only(counts.counts > threshold).places
        edges = np.zeros(counts.shape, dtype=np.uint8)
        keep = _in_large_components(heading, row, col, counts.shape[1], min_component)
        np.bitwise_or.at(edges, (row[keep], col[keep]), (1 << heading[keep]).astype(np.uint8))
        return cls(edges, digest, resolution, origin=origin, counts=counts)

    @property
    def edge_numbers(self) -> np.ndarray:
        """Numbers of its edges as in `EdgeCounts`, ascending."""
        return np.flatnonzero(np.unpackbits(self.edges[None], axis=0, bitorder="little"))

    @property
    def edge_count(self) -> int:
        """Number of directed edges."""
        return int(np.unpackbits(self.edges).sum())

    @property
    def node_count(self) -> int:
        """Number of cells that an edge leaves or enters."""
        _, tail, head = self._ends()
        return len(np.unique(np.concatenate([tail, head])))

    def _ends(self) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Heading and flat index of tail and head of every edge."""
        bits = np.unpackbits(self.edges[None], axis=0, bitorder="little")
        heading, row, col = np.nonzero(bits)
        tail = row * self.edges.shape[1] + col
        return heading, tail, tail + HEADINGS[heading, 1] * self.edges.shape[1] + HEADINGS[heading, 0]

    def check_map(self, grid: OccupancyGrid) -> None:
        """Raise InvalidGraph unless the graph was learnt on `grid`."""
        if self.digest != grid.digest or self.edges.shape != grid.shape:
            raise InvalidGraph("was learnt on another map; learn it again on this one, or bring over what still holds "
                               "(learn --merge)", field="map")

    def to_networkx(self) -> Any:
        """The graph as a networkx.DiGraph: nodes (row, column), edges with `weight` [m] and `heading`.

        Edges whose paths were counted have their number as `paths`.
        """
        import networkx

        graph = networkx.DiGraph()
        columns = self.edges.shape[1]
        for heading, tail, head in zip(*(part.tolist() for part in self._ends())):
            graph.add_edge(divmod(tail, columns), divmod(head, columns), heading=heading,
                           weight=self.resolution * (1.0 if heading % 2 == 0 else 2.0 ** 0.5))
        if self.counts is not None:
            member = self.counts.only(np.isin(self.counts.edges, self.edge_numbers, assume_unique=True))
            tails = np.stack(member.places[1:], axis=1)
            heads = tails + HEADINGS[member.places[0]][:, ::-1]
            for tail, head, paths in zip(tails.tolist(), heads.tolist(), member.counts.tolist()):
                graph.edges[tuple(tail), tuple(head)]["paths"] = paths
        return graph

    def save(self, path: PathLike) -> None:
        """Write the graph to one file, which appears whole or not at all.

        Raises
        ------
        InvalidInput
            When the file cannot be created.
        """
        from social_fleet.planning.routes.graph_files import write_graph
        write_graph(self, path)

    @classmethod
    def load(cls, path: PathLike, *, grid: Optional[OccupancyGrid] = None) -> "SocialGraph":
        """Read a graph.

        Raises
        ------
        InvalidGraph
            When the file is missing, cut short, none of these, of another version, or (with `grid`) of another map.
        """
        from social_fleet.planning.routes.graph_files import read_graph
        graph = read_graph(path)
        if grid is not None:
            try:
                graph.check_map(grid)
            except InvalidGraph as error:
                raise InvalidGraph(error.message, source=str(path), field=error.field) from error
        return graph


def _in_large_components(heading: np.ndarray, row: np.ndarray, col: np.ndarray, columns: int,
                         smallest: int) -> np.ndarray:
    """Which of the edges belong to weakly connected components of at least `smallest` nodes."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    if not len(heading):
        return np.zeros(0, dtype=bool)
    tail = row * columns + col
    head = tail + HEADINGS[heading, 1] * columns + HEADINGS[heading, 0]
    nodes, numbered = np.unique(np.concatenate([tail, head]), return_inverse=True)
    tail, head = numbered[:len(tail)], numbered[len(tail):]
    links = coo_matrix((np.ones(len(tail), dtype=np.int8), (tail, head)), shape=(len(nodes), len(nodes)))
    _, component = connected_components(links, directed=False)
    return np.bincount(component)[component[tail]] >= smallest


def learn(planner: "SocialPlanner", *, paths: int, seed: int,
          progress: Optional[Callable[[int, int], None]] = None) -> SocialGraph:
    """A social graph from plans between random poses.

    Parameters
    ----------
    planner : SocialPlanner
        Plans; a graph that it holds biases what is learnt. It is left as it is.
    paths : int
        Number of plans.
    seed : int
        Of the poses.
    progress : callable, optional
        Called with (plans done, plans in all) after each.

    Raises
    ------
    InvalidInput
        When `paths` is not positive.
    """
    from social_fleet.planning.planner import PREPARED_FROM
    from social_fleet.planning.random_poses import random_pose_pairs

    if paths < 1:
        raise InvalidInput(f"must be at least 1, not {paths}", field="paths")
    if paths >= PREPARED_FROM:
        planner.prepare()
    heatmaps = Heatmaps(planner.grid.shape)
    for done, (start, goal) in enumerate(random_pose_pairs(planner, paths, seed=seed), start=1):
        heatmaps.add(planner.plan(start, goal).cells)
        if progress is not None:
            progress(done, paths)
    return SocialGraph.extract(heatmaps, planner.config.heatmap_threshold, planner.config.min_component,
                               grid=planner.grid)
