"""Maps drawn from descriptions: shapes by hand, and the maps that the project ships."""

import os

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidInput, InvalidMap
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.drawing import draw, draw_file, read_drawing
from social_fleet.mapping.files import load_map
from social_fleet.mapping.images import read_image

scipy_ndimage = pytest.importorskip("scipy.ndimage")

MAPS = os.path.join(os.path.dirname(__file__), "../../maps")
DRAWINGS = os.path.join(MAPS, "drawings")
NAMES = sorted(name[:-len(".yaml")] for name in os.listdir(DRAWINGS))


def drawn(size, *shapes, resolution=1.0, **options):
    return draw({"size": list(size), "resolution": resolution, "shapes": list(shapes), **options})


def test_shapes_are_laid_down_in_order():
    grid = drawn((5, 4), {"fill": "wall", "x": [1, 4], "y": [1, 3]}, {"fill": "free", "x": [2, 3], "y": [0, 4]},
                 {"fill": "unknown", "x": [4, 9], "y": [-1, 1]})
    assert grid == grid_from_text("""
        .....
        .#.#.
        .#.#.
        ....?
    """)


def test_a_border_is_counted_in_cells():
    assert drawn((2, 1.5), resolution=0.5, border=1) == grid_from_text("####\n#..#\n####", 0.5)
    assert not drawn((2, 2)).blocked.any()


def test_ranges_are_half_open_whatever_the_rounding():
    """Edges through the middle of cells: the cell whose centre is the edge belongs to the range that starts there."""
    for tenths in range(1, 400):
        edge = tenths / 10.0
        grid = drawn((40, 0.2), {"fill": "wall", "x": [0, edge], "y": [0, 1]}, resolution=0.2)
        assert np.flatnonzero(~grid.blocked[0])[0] == tenths // 2


def test_polygons_discs_and_turned_groups():
    triangle = drawn((4, 3), {"fill": "wall", "polygon": [[0, 0], [4, 0], [0, 4]]})
    assert triangle == grid_from_text("""
        #...
        ##..
        ###.
    """)
    disc = drawn((4, 4), {"fill": "wall", "centre": [2, 2], "radius": 1.6})
    assert disc == grid_from_text(".##.\n####\n####\n.##.")
    bar = {"fill": "wall", "x": [0, 3], "y": [0, 1]}
    assert drawn((3, 3), {"turn": 90, "about": [1.5, 1.5], "shapes": [bar]}) == grid_from_text("..#\n..#\n..#")


@pytest.mark.parametrize("change, field", [
    ({"size": [1]}, "size"), ({"size": [0, 3]}, "size"), ({"size": "big"}, "size"),
    ({"resolution": 0}, "resolution"), ({"resolution": "fine"}, "resolution"), ({"border": -1}, "border"),
    ({"shapes": {}}, "shapes"), ({"shapes": [3]}, "shapes[0]"),
    ({"shapes": [{"fill": "lava", "x": [0, 1], "y": [0, 1]}]}, "shapes[0].fill"),
    ({"shapes": [{"fill": "wall", "x": [0, 1]}]}, "shapes[0].y"),
    ({"shapes": [{"fill": "wall", "x": [0, float("nan")], "y": [0, 1]}]}, "shapes[0].x"),
    ({"shapes": [{"fill": "wall", "x": [0, 1], "y": [0, 1], "z": 3}]}, "shapes[0].z"),
    ({"shapes": [{"fill": "wall", "polygon": [[0, 0], [1, 1]]}]}, "shapes[0].polygon"),
    ({"shapes": [{"turn": 3, "about": [0, 0], "shapes": [{"fill": "free", "x": 3, "y": [0, 1]}]}]},
     "shapes[0].shapes[0].x"),
    ({"slam": {"speckles": 3}}, "slam.speckles"), ({"slam": {"gaps": 2.0}}, "slam.gaps"),
])
def test_a_description_that_makes_no_sense_is_refused_by_field(change, field):
    with pytest.raises(InvalidInput) as caught:
        draw({"size": [2, 2], "resolution": 1, "shapes": [], **change})
    assert caught.value.field == field


@pytest.mark.parametrize("content, field", [
    ("size: [1, 1]\nshapes: []\n", "resolution"), ("size: [1, 1]\nshape: []\n", "shape"), ("[]\n", ""),
    ("size: [1, 1]\nresolution: -1\nshapes: []\n", "resolution"),
])
def test_a_description_file_is_refused_by_name(tmp_path, content, field):
    (tmp_path / "a.yaml").write_text(content)
    with pytest.raises(InvalidMap) as caught:
        draw_file(tmp_path / "a.yaml", tmp_path)
    assert (caught.value.source, caught.value.field) == (str(tmp_path / "a.yaml"), field)


@pytest.mark.parametrize("name", NAMES)
def test_the_maps_are_what_their_descriptions_show(tmp_path, name):
    draw_file(os.path.join(DRAWINGS, name + ".yaml"), tmp_path)
    kind = read_drawing(os.path.join(DRAWINGS, name + ".yaml")).get("image", "pgm")
    for suffix in ("yaml", "pgm") if kind == "pgm" else ("yaml",):
        fresh = (tmp_path / f"{name}.{suffix}").read_bytes()
        with open(os.path.join(MAPS, f"{name}.{suffix}"), "rb") as kept:
            assert kept.read() == fresh, f"{name}.{suffix} is stale: run tools/draw_maps"
    if kind == "png":
        # how tightly a PNG is packed depends on the version of zlib; its pixels do not
        kept = read_image(os.path.join(MAPS, f"{name}.png"))
        np.testing.assert_array_equal(kept, read_image(tmp_path / f"{name}.png"))


@pytest.mark.parametrize("name, shape, resolution", [
    ("environment_1", (500, 500), 0.2), ("environment_2", (500, 500), 0.2), ("office_floor", (820, 1240), 0.05),
])
def test_sizes(name, shape, resolution):
    grid = load_map(os.path.join(MAPS, name + ".yaml"))
    assert (grid.shape, grid.resolution) == (shape, resolution)


def test_environment_1_has_corridors_of_ten_and_of_four_metres():
    grid = load_map(os.path.join(MAPS, "environment_1.yaml"))
    assert grid.blocked.sum() == 500 * 500 - 494 * 494 + 4 * 200 * 200
    row, column = grid.cell(50.0, 20.0)
    free = np.flatnonzero(~grid.blocked[row])
    runs = np.split(free, np.flatnonzero(np.diff(free) > 1) + 1)
    assert [(run[0], run[-1] + 1) for run in runs] == [(3, 25), (225, 275), (475, 497)]


@pytest.mark.parametrize("x, y, blocked", [
    (0.5, 50.0, True), (0.7, 50.0, False), (5.1, 30.0, True), (5.5, 30.0, False), (5.3, 22.5, False),
    (29.3, 30.0, False), (29.5, 30.0, True), (29.7, 41.5, False), (15.0, 46.5, True), (5.5, 5.5, False),
    (55.3, 10.0, True), (55.5, 10.0, False), (60.0, 25.3, True), (37.5, 44.7, False), (36.5, 44.7, True),
    (75.1, 80.0, True), (60.0, 74.3, True), (91.5, 94.9, False), (91.5, 55.3, False), (94.7, 60.0, True),
])
def test_environment_2_at_places_checked_by_hand(x, y, blocked):
    grid = load_map(os.path.join(MAPS, "environment_2.yaml"))
    assert grid.blocked[grid.cell(x, y)] == blocked


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_gets_into_every_room(name):
    """What it cannot reach is smaller than any room: a nook behind a desk, a cell between two speckles."""
    space = ConfigurationSpace(load_map(os.path.join(MAPS, name + ".yaml")), 0.25)
    labels, _ = scipy_ndimage.label(space.free)
    areas = np.sort(np.bincount(labels.ravel())[1:] * space.grid.resolution ** 2)
    assert areas[:-1].sum() < 0.5


@pytest.mark.parametrize("radius, fits", [(0.25, True), (0.46, False)])
def test_the_small_worlds_have_room_for_one_robot_at_a_time(radius, fits):
    for name, narrow in (("doorway", (7.1, 3.95)), ("alcove", (8.0, 2.05))):
        space = ConfigurationSpace(load_map(os.path.join(MAPS, name + ".yaml")), radius)
        assert space.is_free_path([narrow]) == fits, name
