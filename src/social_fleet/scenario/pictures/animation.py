"""The run of a fleet as an animated GIF: discs to scale with trails, the clock, and who waits for whom."""

import math
from typing import List, Optional, Sequence, Tuple

import numpy as np
from PIL import Image, ImageDraw

from social_fleet.coordination.schedule import FleetSchedule, Schedule
from social_fleet.files import PathLike, atomic_write
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.pictures.canvas import Canvas, flatten, font, text_width, write
from social_fleet.scenario.pictures.colours import FAINT, INK, rgb, robot_colours
from social_fleet.scenario.pictures.fleet_layer import path_points
from social_fleet.scenario.pictures.map_layer import content_box
from social_fleet.scenario.pictures.timeline import driven_arcs
from social_fleet.scenario.recording import Recording
from social_fleet.simulation.faults import CircleObstacle

MOST_FRAMES = 120
SHORTEST_STEP = 0.2  # [s] of simulated time between frames
FRAME_TIME = 0.1  # [s] that each frame is shown
LAST_FRAME_TIME = 2.5  # [s]
LONGEST_SIDE = 760  # [pixel] of the map
SMOOTHING = 2  # drawn so many times larger, then shrunk
SMALLEST_RADIUS = 7.0  # [pixel] of a disc that can still be seen
HEADER = 34  # [pixel] above the map
STANDING = 0.05  # [m] in a frame's time: less is standing
AT_GOAL = 0.15  # [m]


def animate(grid: OccupancyGrid, fleet: FleetSchedule, path: PathLike, *, recording: Optional[Recording] = None,
            obstacles: Sequence[CircleObstacle] = (), title: str = "") -> None:
    """Write an animated GIF of what was driven, or of what is scheduled when nothing was driven yet.

    Parameters
    ----------
    grid
        The map.
    fleet
        Paths, radii, and whom a standing robot waits for.
    recording
        True poses of the robots.
    obstacles
        Drawn while they are there.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    frames = _Animator(grid, fleet, recording or sample(fleet), obstacles, title).frames()
    flat = flatten(frames)
    durations = [int(1000 * FRAME_TIME)] * (len(flat) - 1) + [int(1000 * LAST_FRAME_TIME)]
    with atomic_write(path, "wb") as stream:
        flat[0].save(stream, format="GIF", save_all=True, append_images=flat[1:], duration=durations, loop=0,
                     optimize=False)


def sample(fleet: FleetSchedule, step: float = 0.5) -> Recording:
    """The motion that `fleet` schedules, as if it had been driven exactly."""
    times = np.arange(0.0, fleet.makespan + step, step)
    poses = np.zeros((len(times), len(fleet.schedules), 3))
    for index, schedule in enumerate(fleet.schedules):
        arcs = schedule.arc_length(times)
        poses[:, index, :2] = schedule.robot.path.position(arcs)
        poses[:, index, 2] = [schedule.robot.path.heading(float(arc)) for arc in np.atleast_1d(arcs)]
    return Recording(tuple(schedule.name for schedule in fleet.schedules), times, poses)


class _Animator:
    """Draws one frame after the other."""

    def __init__(self, grid: OccupancyGrid, fleet: FleetSchedule, recording: Recording,
                 obstacles: Sequence[CircleObstacle], title: str) -> None:
        self.fleet = fleet
        self.obstacles = obstacles
        self.title = title
        box = content_box(grid, path_points(fleet))
        self.canvas = Canvas(grid, box, LONGEST_SIDE * SMOOTHING)
        self.colours = {name: rgb(colour) for name, colour in robot_colours(recording.names).items()}
        duration = recording.times[-1] - recording.times[0]
        count = int(np.clip(duration / SHORTEST_STEP, 2, MOST_FRAMES))
        self.times = np.linspace(recording.times[0], recording.times[-1], count)
        chosen = np.searchsorted(recording.times, self.times).clip(0, len(recording.times) - 1)
        self.poses = recording.poses[chosen]
        self.speed_up = (self.times[1] - self.times[0]) / FRAME_TIME if count > 1 else 1.0
        self.names = recording.names
        self.progress = {name: np.interp(self.times, *driven) for name, driven in driven_arcs(fleet, recording).items()}
        self.base = self._base()

    def frames(self) -> List[Image.Image]:
        """All frames, in colour and at their final size."""
        return [self._frame(index) for index in range(len(self.times))]

    def _base(self) -> Image.Image:
        """What all frames share: map, paths as thin lines, goals as rings."""
        image = self.canvas.image.copy()
        draw = ImageDraw.Draw(image, "RGBA")
        for schedule in self.fleet.schedules:
            colour = self.colours[schedule.name]
            draw.line(_flat(self.canvas.pixels(schedule.robot.path.points)), fill=colour + (110,), width=2 * SMOOTHING,
                      joint="curve")
        for schedule in self.fleet.schedules:
            x, y = self.canvas.pixel(*schedule.robot.path.points[-1])
            radius = self._radius(schedule)
            draw.ellipse(_around(x, y, radius), fill=(255, 255, 255, 255), outline=self.colours[schedule.name],
                         width=2 * SMOOTHING)
        return image

    def _radius(self, schedule: Schedule) -> float:
        return max(schedule.robot.body_radius * self.canvas.scale, SMALLEST_RADIUS * SMOOTHING)

    def _frame(self, frame: int) -> Image.Image:
        self._extend_trails(frame)
        image = self.base.copy()
        draw = ImageDraw.Draw(image, "RGBA")
        for obstacle in self.obstacles:
            if obstacle.present(self.times[frame]):
                x, y = self.canvas.pixel(obstacle.x, obstacle.y)
                draw.ellipse(_around(x, y, max(obstacle.radius * self.canvas.scale, 5.0 * SMOOTHING)),
                             fill=(120, 60, 40, 255))
        notes = [self._disc(draw, frame, index) for index in range(len(self.names))]
        for index, note in enumerate(notes):
            self._label(draw, frame, index, note)
        return self._with_header(image.reduce(SMOOTHING), frame)

    def _extend_trails(self, frame: int) -> None:
        """Trails only grow, so they are kept on the picture that all later frames start from."""
        draw = ImageDraw.Draw(self.base)
        for index, name in enumerate(self.names):
            trail = self.canvas.pixels(self.poses[max(frame - 2, 0):frame + 1, index, :2])
            if frame > 0:
                draw.line(_flat(trail), fill=self.colours[name], width=3 * SMOOTHING, joint="curve")

    def _disc(self, draw: ImageDraw.ImageDraw, frame: int, index: int) -> str:
        """Draw one robot, with a dark ring while it waits, and say what it does."""
        name = self.names[index]
        schedule, colour = self.fleet[name], self.colours[name]
        x, y = self.canvas.pixel(*self.poses[frame, index, :2])
        radius = self._radius(schedule)
        state = self._state(frame, index)
        if state == "waits":
            draw.ellipse(_around(x, y, radius + 4 * SMOOTHING), fill=(255, 255, 255, 200), outline=(34, 34, 34),
                         width=2 * SMOOTHING)
        draw.ellipse(_around(x, y, radius), fill=colour, outline=(255, 255, 255), width=SMOOTHING)
        yaw = float(self.poses[frame, index, 2])
        draw.line([x, y, x + 0.85 * radius * math.cos(yaw), y - 0.85 * radius * math.sin(yaw)], fill=(255, 255, 255),
                  width=2 * SMOOTHING)
        if state == "waits":
            other = self._waits_for(frame, name)
            return f"waits for {other}" if other else "waits"
        return state

    def _state(self, frame: int, index: int) -> str:
        """``arrived``, ``waits`` or nothing, while it drives."""
        here = self.poses[frame, index, :2]
        schedule = self.fleet[self.names[index]]
        if np.hypot(*(here - schedule.robot.path.points[-1])) < AT_GOAL:
            return "arrived"
        ahead = self.poses[min(frame + 1, len(self.times) - 1), index]
        standing = np.hypot(*(ahead[:2] - here)) < min(STANDING, 0.1 * schedule.robot.max_speed * self.speed_up
                                                       * FRAME_TIME)
        turning = abs(ahead[2] - self.poses[frame, index, 2]) > 0.05
        return "waits" if standing and not turning and frame + 1 < len(self.times) else ""

    def _waits_for(self, frame: int, name: str) -> str:
        """The robot that has still to pass a place before `name` may go on."""
        progress = self.progress[name][frame]
        for rule in sorted(self.fleet[name].precedences, key=lambda rule: rule.at):
            if progress - 0.1 <= rule.at <= progress + 1.5 and rule.other in self.progress:
                if self.progress[rule.other][frame] < rule.other_at:
                    return rule.other
        return ""

    def _label(self, draw: ImageDraw.ImageDraw, frame: int, index: int, note: str) -> None:
        """Name and note beside the disc, on the side with more room."""
        name = self.names[index]
        x, y = self.canvas.pixel(*self.poses[frame, index, :2])
        reach = self._radius(self.fleet[name]) + 6 * SMOOTHING
        text = name if not note else f"{name} {note}"
        typeface = font(12 * SMOOTHING, bold=True)
        to_left = x + reach + text_width(text, typeface) > self.canvas.width
        write(draw, (x - reach if to_left else x + reach, y), text, typeface, self.colours[name], to_left=to_left,
              rim=2 * SMOOTHING)

    def _with_header(self, image: Image.Image, frame: int) -> Image.Image:
        """`image` below a line with title, clock and progress."""
        sheet = Image.new("RGB", (image.width, image.height + HEADER), "white")
        sheet.paste(image, (0, HEADER))
        draw = ImageDraw.Draw(sheet)
        middle = HEADER // 2 - 2
        write(draw, (6, middle), self.title, font(14, bold=True), INK)
        write(draw, (image.width - 6, middle), f"{self.times[frame]:.0f} s   ({self.speed_up:.0f} x real time)",
              font(13), INK, to_left=True)
        share = (frame + 1) / len(self.times)
        draw.rectangle([0, HEADER - 4, image.width, HEADER - 2], fill="#E4E4E4")
        draw.rectangle([0, HEADER - 4, int(share * image.width), HEADER - 2], fill=FAINT)
        return sheet


def _flat(points: np.ndarray) -> List[Tuple[float, float]]:
    return [(float(x), float(y)) for x, y in points]


def _around(x: float, y: float, radius: float) -> List[float]:
    return [x - radius, y - radius, x + radius, y + radius]
