"""The learning fleet: routes from the plans of all robots, insulated from what is only passing (3.4.1).

Adding a plan and extracting the graph may happen in different threads; neither waits for the other, and planning
waits for neither.
"""

import threading
from collections import deque
from typing import Deque, Dict, Optional, Sequence, Tuple

import numpy as np

from social_fleet.planning.overlays.overlay_set import OverlaySet
from social_fleet.planning.plan import Plan
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.routes.detours import Detours
from social_fleet.planning.routes.heatmaps import EdgeCounts, Heatmaps, edges_of
from social_fleet.planning.routes.social_graph import SocialGraph

_AT_ONCE = 8  # waiting paths that one call of `add` puts into the heatmaps at most


class FleetRoutes:
    """What a fleet learns on one map.

    Plans that are not temporary enter the primary heatmaps, of which the social graph is extracted. Detours round an
    obstacle enter its temporary heatmaps. When the obstacle goes, these are dropped, and the graph is as it was. When
    there are more than `promotion_threshold` of them, the obstacle counts as permanent: its detours enter the primary
    heatmaps, and the edges that it blocks leave them.

    Parameters
    ----------
    planner : SocialPlanner
        Map, parameters, and which cells an obstacle closes to the robot. Its graph is not touched.
    overlays : OverlaySet
        The obstacles. Their coming and going is noticed whenever a plan is added or the graph is extracted.
    graph : SocialGraph, optional
        What was learnt before on this map.
    """

    def __init__(self, planner: SocialPlanner, overlays: OverlaySet, *, graph: Optional[SocialGraph] = None) -> None:
        self.overlays = overlays
        self._planner = planner
        self._shape = planner.grid.shape
        self._heatmaps = Heatmaps(self._shape)
        self._waiting: Deque[np.ndarray] = deque()
        self._detours = Detours(self._shape)
        self._seen = overlays.version
        self._counted = 0
        self._graph: Optional[SocialGraph] = None
        self._lock = threading.Lock()  # of the detours; held for no longer than it takes to sum them up
        self._queueing = threading.Lock()  # of the queue and its count; held for a moment only
        self._counting = threading.Lock()  # of the heatmaps; nobody who adds a plan waits for it
        self._learning = threading.Lock()  # one extraction at a time
        if graph is not None:
            self.take_over(graph)

    @property
    def graph(self) -> Optional[SocialGraph]:
        """The current graph; reading it takes no lock."""
        return self._graph

    @property
    def counted(self) -> int:
        """How many plans were added, detours not among them."""
        return self._counted

    def use(self, planner: SocialPlanner) -> None:
        """Go by the parameters of another planner on the same map from now on; what was counted stays."""
        self._planner = planner

    def add(self, plan: Plan) -> None:
        """Count one plan of the fleet; takes less than a millisecond."""
        self.add_path(plan.cells, temporary=plan.temporary, obstacles=plan.obstacles)

    def add_path(self, cells: np.ndarray, *, temporary: bool = False, obstacles: Sequence[str] = ()) -> None:
        """Count one path.

        Parameters
        ----------
        cells : (M, 2) int array
            Its (row, column) cells, each beside the next.
        temporary : bool
            It is a detour.
        obstacles : sequence of str
            The obstacles that a detour came near; a detour round none that is there teaches nothing.

        Raises
        ------
        InvalidInput
            When the cells are no chain of neighbours, or leave the map; nothing is counted then.
        """
        edges = edges_of(cells, self._shape)
        if temporary:
            with self._lock:
                self._notice_changes()
                known = [self.overlays.get(name) for name in obstacles]
                passing = {overlay.name: overlay.shape for overlay in known if overlay and not overlay.permanent}
                if passing:
                    self._detours.add(passing, edges)
                if passing or not any(known):
                    return
        with self._queueing:
            self._waiting.append(edges)
            self._counted += 1
        if self._counting.acquire(blocking=False):
            try:
                self._count_waiting(_AT_ONCE)
            finally:
                self._counting.release()

    def detours(self) -> Dict[str, int]:
        """Number of detours by obstacle."""
        with self._lock:
            self._notice_changes()
            return {name: self._detours.paths(name) for name in self._detours.obstacles}

    def temporary_heatmaps(self, name: str) -> EdgeCounts:
        """How many detours round the obstacle used which edges."""
        with self._lock:
            self._notice_changes()
            return self._detours.counts(name)

    def due(self) -> Tuple[str, ...]:
        """The obstacles that more detours went round than the threshold allows; `learn` promotes them."""
        threshold = self._planner.config.promotion_threshold
        return tuple(name for name, paths in self.detours().items() if 0 < threshold < paths)

    def learn(self) -> Tuple[str, ...]:
        """Promote the obstacles that are due, and extract the graph anew; for a thread in the background.

        Returns
        -------
        tuple of str
            The obstacles that were found to be permanent.
        """
        with self._learning:
            promoted = self.due()
            for name in promoted:
                self.overlays.make_permanent(name)
            with self._lock:
                self._notice_changes()
                permanent = [name for name in self._detours.obstacles if self._is_permanent(name)]
                released = [self._detours.release(name) for name in permanent]
            self._graph = self._extracted(released)
        return promoted

    def take_over(self, graph: SocialGraph) -> None:
        """Add what was learnt elsewhere on this map: its counts to the heatmaps, its edges to the graph.

        Raises
        ------
        InvalidGraph
            When it was learnt on another map.
        """
        graph.check_map(self._planner.grid)
        counts = graph.counts
        if counts is None:
            numbers = graph.edge_numbers
            just_enough = np.full(len(numbers), self._planner.config.heatmap_threshold + 1, dtype=np.uint16)
            counts = EdgeCounts(self._shape, numbers, just_enough)
        with self._learning:
            if self._graph is None:
                with self._counting:
                    self._heatmaps.add_counts(counts)
                self._graph = graph
            else:
                self._graph = self._extracted([counts])

    def _notice_changes(self) -> None:
        """Forget the detours round what is gone, or is another obstacle by now; call with the lock."""
        version = self.overlays.version
        if version == self._seen:
            return
        gone = []
        for name, shape in self._detours.obstacles.items():
            overlay = self.overlays.get(name)
            if overlay is None or overlay.shape != shape:
                gone.append(name)
        self._detours.forget(gone)
        self._seen = version

    def _is_permanent(self, name: str) -> bool:
        overlay = self.overlays.get(name)
        return overlay is not None and overlay.permanent

    def _extracted(self, more: Sequence[EdgeCounts]) -> SocialGraph:
        """The graph of all that was counted and `more`, without what permanent obstacles block."""
        permanent = {overlay.name: overlay.shape for overlay in self.overlays.all if overlay.permanent}
        closed = self._planner.closed_cells(permanent)
        with self._counting:
            self._count_waiting(len(self._waiting))
            for counts in more:
                self._heatmaps.add_counts(counts)
            if len(closed):
                self._heatmaps.forget(closed)
            counts = self._heatmaps.edge_counts()
        grid, config = self._planner.grid, self._planner.config
        return SocialGraph.from_counts(counts, config.heatmap_threshold, config.min_component, digest=grid.digest,
                                       resolution=grid.resolution, origin=grid.origin)

    def _count_waiting(self, most: int) -> None:
        """Put up to `most` waiting paths into the heatmaps; call with the counting lock."""
        for _ in range(min(most, len(self._waiting))):
            self._heatmaps.add_edges(self._waiting.popleft())
