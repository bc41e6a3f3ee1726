"""Maps as pixels: right way up, in their place, with walls that stay visible."""

import math

import numpy as np
from PIL import Image
from worlds import grid_from_text

from social_fleet.scenario.pictures.canvas import Canvas, flatten
from social_fleet.scenario.pictures.colours import FREE, UNKNOWN, WALL, robot_colours
from social_fleet.scenario.pictures.map_layer import content_box, round_length

WORLD = """
    ??????
    ?#..#?
    ?....?
    ??????
"""


def test_each_cell_has_its_colour() -> None:
    grid = grid_from_text(WORLD)
    pixels = np.asarray(Canvas(grid, (0.0, 0.0, 6.0, 4.0), 60).image)
    assert pixels.shape == (40, 60, 3)
    colours = {"?": UNKNOWN, "#": WALL, ".": FREE}
    for row, line in enumerate(WORLD.split()):
        for column, cell in enumerate(line):
            assert tuple(pixels[row * 10 + 5, column * 10 + 5]) == colours[cell]


def test_places_have_pixels() -> None:
    canvas = Canvas(grid_from_text(WORLD, origin=(10.0, 20.0, 0.0)), (10.0, 20.0, 16.0, 24.0), 60)
    assert canvas.pixel(10.0, 24.0) == (0.0, 0.0)
    assert np.allclose(canvas.pixels(np.array([[16.0, 20.0]])), [[60.0, 40.0]])


def test_a_turned_map_is_shown_turned() -> None:
    grid = grid_from_text("#.\n..", origin=(0.0, 0.0, math.pi / 2.0))
    pixels = np.asarray(Canvas(grid, (-2.0, 0.0, 0.0, 2.0), 20).image)
    assert tuple(pixels[15, 5]) == WALL and tuple(pixels[5, 5]) == FREE


def test_a_thin_wall_survives_shrinking() -> None:
    values = "\n".join("." * 50 + "#" + "." * 49 for _ in range(100))
    pixels = np.asarray(Canvas(grid_from_text(values), (0.0, 0.0, 100.0, 100.0), 20).image)
    assert (pixels[:, 10] == WALL).all() and (pixels[:, 5] == FREE).all()


def test_the_unknown_margin_is_cut_off() -> None:
    low_x, low_y, high_x, high_y = content_box(grid_from_text(WORLD))
    assert 0.9 < low_x < 1.0 and 0.9 < low_y < 1.0 and 5.0 < high_x < 5.1 and 3.0 < high_y < 3.1
    assert content_box(grid_from_text(WORLD), np.array([[-3.0, 2.0]]))[0] < -3.0
    assert content_box(grid_from_text("??\n??"))[2] > 2.0


def test_frames_share_a_palette_and_keep_their_colours() -> None:
    frames = [Image.new("RGB", (8, 8), colour) for colour in ((255, 255, 255), (0, 114, 178), (70, 72, 78))]
    for frame, flat in zip(frames, flatten(frames)):
        difference = np.asarray(frame, dtype=int) - np.asarray(flat.convert("RGB"), dtype=int)
        assert np.abs(difference).max() <= 8


def test_round_lengths() -> None:
    assert [round_length(span) for span in (0.7, 1.0, 4.9, 20.0, 99.0)] == [0.5, 1.0, 2.0, 20.0, 50.0]


def test_robots_are_coloured_by_name_or_apart() -> None:
    colours = robot_colours(["gold", "r1", "r2", "Blue"])
    assert len(set(colours.values())) == 4
    assert colours["gold"] == "#E6A400" and colours["Blue"] == "#0072B2"
    assert len(robot_colours([f"r{index}" for index in range(40)])) == 40
