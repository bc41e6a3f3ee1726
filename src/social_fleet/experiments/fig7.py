"""Figure 7: the social graph as it grows, and with temporary paths round an obstacle."""

from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from social_fleet.errors import InvalidPose, NoPath
from social_fleet.experiments.cells import Progress, Work
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.experiments.maps import draw_edges, map_panels
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.overlay_set import OverlaySet
from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import Position, random_pose_pairs
from social_fleet.planning.routes.fleet_routes import FleetRoutes
from social_fleet.planning.routes.heatmaps import EdgeCounts
from social_fleet.planning.routes.social_graph import SocialGraph
from social_fleet.scenario.pictures.colours import INK
from social_fleet.scenario.pictures.map_layer import content_box, draw_map
from social_fleet.scenario.pictures.style import halo

EARLY = 0.6  # share of the paths after which the first panel is drawn: 150 of 250
OBSTACLE_RADIUS = 0.8  # [m]
OBSTACLE = "temporary obstacle"
CLOSE = 5.0  # [m] about the obstacle that is shown enlarged
LANE, DETOUR = "#0072B2", "#D55E00"


class Stage(NamedTuple):
    """A panel: the graph, the detours beside it, and what the row says."""

    title: str
    graph: SocialGraph
    detours: Optional[EdgeCounts]
    row: Row


class Figure7(Experiment):
    """Random paths are aggregated; then something stands in the busiest lane. Each builds on those before: no cells."""

    name = "fig7"
    trials = 250
    maps = ("environment_1",)
    adds_maps = False

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        world = worlds[0]
        planner = SocialPlanner(world.grid, PlannerConfig(promotion_threshold=0))  # detours stay detours
        planner.prepare()
        overlays = OverlaySet(world.grid)
        routes = FleetRoutes(planner, overlays)
        early = max(int(round(EARLY * trials)), 1)
        pairs = random_pose_pairs(planner, 2 * trials, seed=seed)
        stages: List[Stage] = []
        for done, pair in enumerate(pairs[:trials], start=1):
            routes.add(planner.plan(*pair))
            work.progress(done, 2 * trials)
            stages += [_stage(routes, "", done, 0, 0) for panel in (early, trials) if panel == done]
        place = busiest_place(planner, routes)
        overlays.add(OBSTACLE, DiscObstacle(place[0], place[1], OBSTACLE_RADIUS))
        stages.append(self._with_obstacle(planner, routes, pairs[trials:], work.progress))
        caption = (
            f"The social graph of {world.name} from paths between random poses, seed {seed}; an edge that more paths "
            "use is darker. (a), (b): lanes along the walls emerge and fill. (c): a disc of radius "
            f"{OBSTACLE_RADIUS} m stands in the busiest lane while {trials} more paths are planned on the graph. Those "
            "that come near it are temporary (orange): they are kept apart, and the graph (blue) learns "
            "from the others only.")
        settings = {"maps": [world.name], "trials": trials, "seed": seed, "obstacle": [*place, OBSTACLE_RADIUS]}
        return Result(self.name, caption, [stage.row for stage in stages], settings,
                      _draw(world, stages, place, caption))

    def _with_obstacle(self, planner: SocialPlanner, routes: FleetRoutes, pairs: Sequence[Tuple[Position, Position]],
                       progress: Progress) -> Stage:
        """Plan on the graph, round the obstacle."""
        planner.graph = routes.graph
        temporary = refused = 0
        for done, pair in enumerate(pairs, start=1):
            try:
                plan = planner.plan(*pair, overlays=routes.overlays)
            except (InvalidPose, NoPath):
                refused += 1  # an end lies under the obstacle, or the obstacle closes the way
            else:
                temporary += plan.temporary
                routes.add(plan)
            progress(len(pairs) + done, 2 * len(pairs))
        return _stage(routes, OBSTACLE, routes.counted, temporary, refused)


def _stage(routes: FleetRoutes, obstacle: str, paths: int, temporary: int, refused: int) -> Stage:
    detours = routes.temporary_heatmaps(obstacle) if obstacle else None
    routes.learn()
    graph = routes.graph
    assert graph is not None
    title = f"after {paths} paths" + (f", and {temporary} temporary ones" if obstacle else "")
    row = {"paths": paths, "obstacle": bool(obstacle), "nodes": graph.node_count, "edges": graph.edge_count,
           "temporary_paths": temporary, "temporary_edges": 0 if detours is None else len(detours.edges),
           "refused": refused}
    return Stage(title, graph, detours, row)


def busiest_place(planner: SocialPlanner, routes: FleetRoutes) -> Position:
    """Centre of the cell that most paths of the graph go through [m]."""
    counts = routes.graph.counts if routes.graph is not None else None
    if counts is None or not len(counts.edges):
        return planner.grid.centre(*planner.lattice.cells(planner.lattice.largest_component[:1])[0])
    _, row, column = counts.places
    best = int(np.argmax(counts.counts))
    return planner.grid.centre(int(row[best]), int(column[best]))


def _draw(world: World, stages: Sequence[Stage], place: Position, caption: str) -> Figure:
    figure, panels = map_panels(world.grid, len(stages), caption=caption,
                                title=f"Figure 7: the social graph of {world.name.replace('_', ' ')}")
    for letter, axes, stage in zip("abc", panels, stages):
        draw_edges(axes, world.grid, member_counts(stage.graph), LANE)
        if stage.detours is not None:
            draw_edges(axes, world.grid, stage.detours, DETOUR, level=5.0)
            axes.add_patch(Circle(place, OBSTACLE_RADIUS, color=INK, zorder=8))
            _draw_closely(axes, world, stage.graph, stage.detours, place)
        axes.set_title(f"({letter}) {stage.title}", fontsize=10, color=INK, loc="left")
    return figure


def _draw_closely(axes: Axes, world: World, graph: SocialGraph, detours: EdgeCounts, place: Position) -> None:
    """The obstacle and its surroundings, enlarged in the corner that is farthest from it."""
    box = content_box(world.grid)
    across, up = (0.05 if place[axis] > 0.5 * (box[axis] + box[axis + 2]) else 0.55 for axis in (0, 1))
    near = (place[0] - CLOSE, place[1] - CLOSE, place[0] + CLOSE, place[1] + CLOSE)
    inset = axes.inset_axes([across, up, 0.4, 0.4], zorder=10)
    draw_map(inset, world.grid, near)
    draw_edges(inset, world.grid, member_counts(graph), LANE, width=1.6)
    draw_edges(inset, world.grid, detours, DETOUR, width=1.6, level=5.0)
    inset.add_patch(Circle(place, OBSTACLE_RADIUS, color=INK, zorder=8))
    inset.set(xlabel="", ylabel="", xticks=[], yticks=[])
    inset.text(0.5, 0.04, f"about the obstacle, {2.0 * CLOSE:g} m wide", transform=inset.transAxes, fontsize=7.5,
               color=INK, ha="center", va="bottom", zorder=12, path_effects=halo())
    for spine in inset.spines.values():
        spine.set(color=INK, linewidth=1.2)
    axes.indicate_inset_zoom(inset, edgecolor=INK, alpha=1.0)


def member_counts(graph: SocialGraph) -> EdgeCounts:
    """How many paths used each edge of the graph."""
    counts = graph.counts
    if counts is None:
        rows, columns = graph.edges.shape
        return EdgeCounts((rows, columns), graph.edge_numbers, np.ones(graph.edge_count, dtype=np.uint16))
    return counts.only(np.isin(counts.edges, graph.edge_numbers, assume_unique=True))
