"""Files of social graphs, and GraphML."""

import json
import os

import networkx
import numpy as np
import pytest

from social_fleet.errors import InvalidGraph
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.routes.graph_files import VERSION, write_graphml
from social_fleet.planning.routes.heatmaps import Heatmaps
from social_fleet.planning.routes.social_graph import SocialGraph

GRID = OccupancyGrid(np.zeros((6, 20), dtype=np.int8), 0.5, Pose(3.0, -1.0, 0.5))


def routes():
    heatmaps = Heatmaps(GRID.shape)
    for path, times in (([(2, column) for column in range(20)], 3), ([(4, column) for column in range(12, 3, -1)], 2),
                        ([(0, 0), (1, 1)], 1)):
        for _ in range(times):
            heatmaps.add(np.array(path))
    return SocialGraph.extract(heatmaps, 1, 2, grid=GRID)


def test_what_is_saved_comes_back(tmp_path):
    graph = routes()
    graph.save(tmp_path / "routes.graph")
    again = SocialGraph.load(tmp_path / "routes.graph", grid=GRID)
    np.testing.assert_array_equal(again.edges, graph.edges)
    assert (again.digest, again.resolution, again.origin) == (GRID.digest, 0.5, GRID.origin)
    assert again.counts == graph.counts and len(again.counts.edges) == 19 + 8 + 1
    assert os.listdir(tmp_path) == ["routes.graph"]


def test_a_graph_without_counts_and_origin(tmp_path):
    graph = SocialGraph(routes().edges, "abc", 0.5)
    graph.save(tmp_path / "g")
    again = SocialGraph.load(tmp_path / "g")
    np.testing.assert_array_equal(again.edges, graph.edges)
    assert (again.digest, again.origin, again.counts) == ("abc", None, None)


def test_an_empty_graph(tmp_path):
    SocialGraph.extract(Heatmaps(GRID.shape), 0, 1, grid=GRID).save(tmp_path / "g")
    again = SocialGraph.load(tmp_path / "g", grid=GRID)
    assert again.edge_count == 0 and not len(again.counts.edges)


def test_a_graph_of_another_map_is_refused(tmp_path):
    routes().save(tmp_path / "g")
    with pytest.raises(InvalidGraph, match="another map") as caught:
        SocialGraph.load(tmp_path / "g", grid=OccupancyGrid(np.zeros((6, 20), dtype=np.int8), 0.25))
    assert caught.value.source == str(tmp_path / "g")


def test_files_that_are_no_graph_are_refused(tmp_path):
    good = tmp_path / "good"
    routes().save(good)
    content = good.read_bytes()
    for name, text in (("cut", content[:len(content) // 2]), ("shorter", content[:-1]), ("empty", b""),
                       ("text", b"routes"), ("flipped", content[:60] + bytes([content[60] ^ 255]) + content[61:])):
        (tmp_path / name).write_bytes(text)
        with pytest.raises(InvalidGraph) as caught:
            SocialGraph.load(tmp_path / name)
        assert caught.value.source.endswith(name)
    with pytest.raises(InvalidGraph, match="No such file"):
        SocialGraph.load(tmp_path / "missing")
    with pytest.raises(InvalidGraph, match="directory"):
        SocialGraph.load(tmp_path)


def written(path, **changes):
    """A file like one of ours, but for what is changed in its header or arrays."""
    header = {"format": "social_fleet graph", "version": VERSION, "map": "x", "resolution": 0.5, "origin": None,
              "shape": [2, 2], "counted": True}
    arrays = {"steps": np.array([0, 4], dtype=np.uint32), "counts": np.array([3, 2], dtype=np.uint16),
              "member": np.array([True, False])}
    for key, value in changes.items():
        (arrays if key in arrays else header)[key] = value
    with open(path, "wb") as stream:
        np.savez_compressed(stream, header=np.array(json.dumps(header)), **arrays)
    return path


def test_another_version_is_refused(tmp_path):
    assert SocialGraph.load(written(tmp_path / "g")).edge_count == 1
    for version in (1, VERSION + 1):
        with pytest.raises(InvalidGraph, match=f"version {version}, not .* of version {VERSION}; learn it again"):
            SocialGraph.load(written(tmp_path / "g", version=version))


@pytest.mark.parametrize("changes", [
    {"shape": [1, 1]}, {"shape": [0, 2]}, {"shape": [10 ** 9, 10 ** 9]}, {"shape": [2]}, {"shape": "ab"},
    {"steps": np.array([0], dtype=np.uint32)},
    {"steps": np.array([4, 0], dtype=np.uint32)}, {"steps": np.array([1, 4], dtype=np.uint32)},
    {"counts": np.array([3.0, 2.0])}, {"member": np.array([True])}, {"origin": [1.0, 2.0]}, {"origin": ["a", 1, 2]},
    {"resolution": None}, {"resolution": 10 ** 400}, {"format": "else"},
])
def test_a_file_that_contradicts_itself_is_refused(tmp_path, changes):
    with pytest.raises(InvalidGraph):
        SocialGraph.load(written(tmp_path / "g", **changes))


def test_graphml(tmp_path):
    graph = routes()
    write_graphml(graph, tmp_path / "routes.graphml")
    again = networkx.read_graphml(str(tmp_path / "routes.graphml"))
    assert again.number_of_edges() == graph.edge_count and again.number_of_nodes() == graph.node_count
    assert again.edges["2,3", "2,4"] == {"heading": 0, "weight": 0.5, "paths": 3}
    node = again.nodes["2,3"]
    assert (node["row"], node["column"]) == (2, 3)
    assert (node["x"], node["y"]) == pytest.approx(GRID.centre(2, 3))
    assert os.listdir(tmp_path) == ["routes.graphml"]
    write_graphml(SocialGraph.extract(Heatmaps(GRID.shape), 0, 1, grid=GRID), tmp_path / "empty.graphml")
    assert not len(networkx.read_graphml(str(tmp_path / "empty.graphml")))
