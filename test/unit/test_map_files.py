"""map_server's files: every mode and image format, and a clear answer to every kind of broken one."""

import io
import math
import os

import numpy as np
import pytest
from PIL import Image
from worlds import grid_from_text

from social_fleet.errors import InvalidInput, InvalidMap
from social_fleet.geometry import Pose
from social_fleet.mapping.files import load_map, save_map
from social_fleet.mapping.grid import OccupancyGrid

WILLOW = os.path.join(os.path.dirname(__file__), "../../../shared/maps/willow-full-0.05.yaml")
GOOD = {"image": "floor.pgm", "resolution": "0.05", "origin": "[-1.0, 2.0, 0.5]", "negate": "0",
        "occupied_thresh": "0.65", "free_thresh": "0.196"}
# black, dark, the grey of unknown, white
P2 = b"P2\n# made by hand\n2 2 # columns, rows\n255\n0 100\n205 255\n"


def write_map(folder, content=P2, **changes):
    """A map whose image holds `content` and whose YAML is GOOD with `changes`; None leaves a key out."""
    keys = {key: value for key, value in {**GOOD, **changes}.items() if value is not None}
    if content is not None:
        (folder / GOOD["image"]).write_bytes(content)
    path = folder / "floor.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in keys.items()))
    return path


def png(pixels):
    buffer = io.BytesIO()
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(buffer, format="PNG")
    return buffer.getvalue()


def test_the_top_of_the_image_is_the_highest_row(tmp_path):
    grid = load_map(write_map(tmp_path))
    assert grid.values.tolist() == [[-1, 0], [100, -1]]
    assert grid.resolution == 0.05
    assert grid.origin == Pose(-1.0, 2.0, 0.5)


def test_the_image_is_looked_up_beside_the_yaml_or_absolutely(tmp_path, monkeypatch):
    path = write_map(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert load_map("floor.yaml") == load_map(path)
    (tmp_path / "other").mkdir()
    away = write_map(tmp_path / "other", None, image=tmp_path / "floor.pgm")
    assert load_map(away) == load_map(path)


@pytest.mark.parametrize("changes, expected", [
    ({}, [100, -1, -1, 0]),
    ({"mode": "trinary"}, [100, -1, -1, 0]),
    ({"mode": "scale"}, [100, 1 + int(98 * (155 / 255 - 0.196) / (0.65 - 0.196)), 1, 0]),
    ({"mode": "raw"}, [0, 100, 100, -1]),
    ({"negate": "1"}, [0, -1, 100, 100]),
    ({"negate": "1", "mode": "raw"}, [-1, 100, 50, 0]),
    ({"free_thresh": "0.5", "occupied_thresh": "0.6"}, [100, 100, 0, 0]),
    ({"free_thresh": "0.0", "occupied_thresh": "1.0"}, [-1, -1, -1, -1]),
])
def test_modes_negate_and_thresholds_of_grey(tmp_path, changes, expected):
    image = b"P2 4 1 255 0 100 205 255"
    assert load_map(write_map(tmp_path, image, **changes)).values.tolist() == [expected]


def test_thresholds_are_exclusive(tmp_path):
    """occ of 204 is exactly 0.2, of 51 exactly 0.8: neither below free_thresh nor above occupied_thresh."""
    image = b"P2 4 1 255 205 204 51 50"
    changes = {"free_thresh": "0.2", "occupied_thresh": "0.8"}
    assert load_map(write_map(tmp_path, image, **changes)).values.tolist() == [[0, -1, -1, 100]]
    assert load_map(write_map(tmp_path, image, mode="scale", **changes)).values.tolist() == [[0, 1, 99, 100]]


@pytest.mark.parametrize("mode, expected", [
    # opaque white, opaque mid grey, transparent mid grey, opaque black; trinary averages alpha in
    ("trinary", [0, -1, -1, 100]),
    ("scale", [0, 66, -1, 100]),
    ("raw", [-1, 100, 100, 0]),
])
def test_alpha(tmp_path, mode, expected):
    pixels = [[(255, 255, 255, 255), (128, 128, 128, 255), (128, 128, 128, 0), (0, 0, 0, 255)]]
    assert load_map(write_map(tmp_path, png(pixels), mode=mode)).values.tolist() == [expected]


def test_colours_are_averaged(tmp_path):
    pixels = [[(255, 255, 0), (30, 60, 90), (255, 255, 255)]]
    assert load_map(write_map(tmp_path, png(pixels))).values.tolist() == [[-1, 100, 0]]


@pytest.mark.parametrize("mode", ["1", "L", "P", "LA", "RGB", "RGBA"])
def test_kinds_of_png(tmp_path, mode):
    image = Image.fromarray(np.array([[0, 255]], dtype=np.uint8)).convert(mode)
    image.save(tmp_path / "floor.pgm", format="PNG")
    values = load_map(write_map(tmp_path, None, mode="scale")).values
    assert values.tolist() == [[100, 0]]


def test_sixteen_bits_of_png(tmp_path):
    Image.fromarray(np.array([[0, 0xCDFF, 0xFFFF]], dtype=np.uint16)).save(tmp_path / "floor.pgm", format="PNG")
    assert load_map(write_map(tmp_path, None)).values.tolist() == [[100, -1, 0]]


@pytest.mark.parametrize("image", [
    b"P5 3 1 255 \x00\xcd\xff",
    b"P5\n# CREATOR: map_saver\n3 1\n255\n\x00\xcd\xff",
    b"P5\n3 # columns\n1\n255\n\x00\xcd\xff and what follows is another image",
    b"P5 3 1 15\n\x00\x0c\x0f",
    b"P5 3 1 65535\n\x00\x00\xcd\x00\xff\xff",
    b"P2 3 1 1000 0 800 1000",
    b"P2\n3 1\n255\n0\n# between\n205 # and after\n255\n",
])
def test_kinds_of_pgm(tmp_path, image):
    assert load_map(write_map(tmp_path, image)).values.tolist() == [[100, -1, 0]]


@pytest.mark.parametrize("image, message", [
    (None, "floor.pgm there is no such file"),
    (b"", "not an image"),
    (b"not an image at all", "not an image"),
    (b"P5 3 1", "header lacks"),
    (b"P5 0 3 255\n", "size is 0 x 3"),
    (b"P2 3 0 255\n", "size is 3 x 0"),
    (b"P5 -3 1 255\n\x00\x00\x00", "header lacks"),
    (b"P5 3 1 0\n\x00\x00\x00", "largest value is 0"),
    (b"P5 3 1 70000\n\x00\x00\x00", "largest value is 70000"),
    (b"P5 3 1 255\n\x00\x00", "cut short: 3 pixels announced, 2 there"),
    (b"P5 3 1 65535\n\x00\x00\x00\x00\x00", "cut short: 3 pixels announced, 2 there"),
    (b"P5 99999999 99999999 255\n\x00", "cut short"),
    (b"P2 3 1 255\n0 0", "cut short: 3 pixels announced, 2 there"),
    (b"P2 3 1 255\n0 0 x", "damaged"),
    (b"P2 3 1 255\n0 0 -1", "negative"),
    (b"P2 3 1 100\n0 0 101", "101 exceeds the largest, 100"),
])
def test_a_broken_image_is_refused(tmp_path, image, message):
    with pytest.raises(InvalidMap, match=message) as caught:
        load_map(write_map(tmp_path, image))
    assert caught.value.field == "image"
    assert caught.value.source == str(tmp_path / "floor.yaml")


def test_a_png_cut_anywhere_is_refused(tmp_path):
    whole = png(np.random.RandomState(0).randint(0, 256, (20, 20)))
    for length in range(0, len(whole) - 1, 7):
        with pytest.raises(InvalidMap):
            load_map(write_map(tmp_path, whole[:length]))


@pytest.mark.parametrize("key", sorted(GOOD))
def test_a_missing_key_is_named(tmp_path, key):
    with pytest.raises(InvalidMap, match="is missing") as caught:
        load_map(write_map(tmp_path, **{key: None}))
    assert caught.value.field == key


@pytest.mark.parametrize("key, value", [
    ("image", "3"), ("image", "[a]"), ("image", ""), ("image", "."),
    ("resolution", "0"), ("resolution", "-0.05"), ("resolution", ".nan"), ("resolution", ".inf"),
    ("resolution", "small"), ("resolution", "true"), ("resolution", "[0.05]"),
    ("origin", "0"), ("origin", "[0, 0]"), ("origin", "[0, 0, x]"), ("origin", "[0, .nan, 0]"),
    ("origin", "[0, 0, 0, 0]"),
    ("negate", "2"), ("negate", "maybe"), ("negate", "[]"),
    ("occupied_thresh", "1.5"), ("occupied_thresh", "high"), ("free_thresh", "-0.1"), ("free_thresh", "0.7"),
    ("mode", "quaternary"), ("mode", "[scale]"),
])
def test_a_wrong_value_is_named(tmp_path, key, value):
    with pytest.raises(InvalidMap) as caught:
        load_map(write_map(tmp_path, **{key: value}))
    assert caught.value.field == key
    assert caught.value.source == str(tmp_path / "floor.yaml")


def test_a_number_may_be_written_as_yaml_cpp_reads_it(tmp_path):
    assert load_map(write_map(tmp_path, resolution="5e-2", negate="false")).resolution == 0.05


@pytest.mark.parametrize("content", ["", "just text\n", "- a\n- list\n", "image: [\n"])
def test_what_is_no_map_file_is_refused(tmp_path, content):
    (tmp_path / "floor.yaml").write_text(content)
    with pytest.raises(InvalidMap) as caught:
        load_map(tmp_path / "floor.yaml")
    assert caught.value.source == str(tmp_path / "floor.yaml")
    with pytest.raises(InvalidMap, match="no such file"):
        load_map(tmp_path / "none.yaml")


@pytest.mark.parametrize("image", ["pgm", "png"])
@pytest.mark.parametrize("values", [[[0, 100, -1], [100, 0, 0]], [[0, 1, 50], [99, 100, -1]]])
def test_what_is_saved_is_read_back(tmp_path, image, values):
    grid = OccupancyGrid(values, 0.1 + 0.2, Pose(-1.0 / 3.0, 1e-7, -math.pi))
    save_map(grid, tmp_path / "a.yaml", image=image)
    assert sorted(os.listdir(tmp_path)) == [f"a.{image}", "a.yaml"]
    assert load_map(tmp_path / "a.yaml") == grid


def test_a_saved_map_has_the_greys_of_map_saver(tmp_path):
    save_map(grid_from_text("#.?", 0.5), tmp_path / "a.yaml")
    assert (tmp_path / "a.pgm").read_bytes() == b"P5\n3 1\n255\n\x00\xfe\xcd"


def test_nothing_is_written_where_nothing_can_be(tmp_path):
    grid = grid_from_text("...")
    with pytest.raises(InvalidInput, match="does not exist"):
        save_map(grid, tmp_path / "none" / "a.yaml")
    with pytest.raises(InvalidMap, match="pgm"):
        save_map(grid, tmp_path / "a.yaml", image="bmp")
    (tmp_path / "folder.yaml").mkdir()
    with pytest.raises(InvalidInput, match="is a folder"):
        save_map(grid, tmp_path / "folder.yaml")
    assert os.listdir(tmp_path) == ["folder.yaml"]


@pytest.mark.skipif(not os.path.exists(WILLOW), reason="the Willow Garage map is not beside the repository")
def test_a_real_map():
    grid = load_map(WILLOW)
    assert grid.shape == (945, 1165)
    assert grid.resolution == 0.05
    assert set(np.unique(grid.values)) == {-1, 0, 100}
