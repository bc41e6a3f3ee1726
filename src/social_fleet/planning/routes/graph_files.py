"""Files of social graphs: one versioned archive with what planning, merging and another map need."""

import json
import os
import struct
import zipfile
import zlib
from typing import Any, Dict, Tuple

import numpy as np

from social_fleet.errors import InvalidGraph
from social_fleet.files import PathLike, atomic_write
from social_fleet.geometry import Pose
from social_fleet.planning.routes.heatmaps import EdgeCounts
from social_fleet.planning.routes.social_graph import SocialGraph

FORMAT = "social_fleet graph"
VERSION = 2
MOST_CELLS = 1 << 30  # of a map; a header that claims more was damaged

# What reading an archive raises that is none, was damaged, or holds something else (AttributeError: a bare array, on
# CPython 3.8; RuntimeError: encrypted, compressed in an unknown way, or JSON without end).
_DAMAGED = (ValueError, KeyError, TypeError, IndexError, AttributeError, OverflowError, RuntimeError, EOFError,
            zipfile.BadZipFile, zlib.error, struct.error)


def write_graph(graph: SocialGraph, path: PathLike) -> None:
    """Write a graph to one file, which appears whole or not at all.

    The archive holds a JSON header, and of every edge that was used its number (as the step from the one before), its
    count, 0 where that is not known, and whether it belongs to the graph.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    member = graph.edge_numbers
    counts = graph.counts or EdgeCounts.none(_shape(graph))
    numbers = np.union1d(counts.edges, member)
    paths = np.zeros(len(numbers), dtype=np.uint16)
    paths[np.searchsorted(numbers, counts.edges)] = counts.counts
    header = {"format": FORMAT, "version": VERSION, "map": graph.digest, "resolution": graph.resolution,
              "origin": None if graph.origin is None else list(graph.origin), "shape": list(_shape(graph)),
              "counted": graph.counts is not None}
    with atomic_write(path, "wb") as stream:
        np.savez_compressed(stream, header=np.array(json.dumps(header)), counts=paths,
                            steps=np.diff(numbers, prepend=0).astype(np.uint32),
                            member=np.isin(numbers, member, assume_unique=True))


def read_graph(path: PathLike) -> SocialGraph:
    """Read a graph.

    Raises
    ------
    InvalidGraph
        When the file is missing, cut short, none of these, or of another version; `source` is the file.
    """
    source = os.fspath(path)
    try:
        with np.load(source, allow_pickle=False) as archive:
            header = json.loads(str(archive["header"]))
            known = header["format"], header["version"]
            if known != (FORMAT, VERSION):
                raise InvalidGraph(f"is {known[0]!r} of version {known[1]}, not {FORMAT!r} of version {VERSION}; "
                                   "learn it again", source=source, field="version")
            return _graph(header, archive["steps"], archive["counts"], archive["member"])
    except InvalidGraph:
        raise
    except OSError as error:
        raise InvalidGraph(f"cannot be read: {error.strerror or error}", source=source) from error
    except _DAMAGED as error:
        raise InvalidGraph("is no social graph, or was cut short; learn it again", source=source) from error


def _graph(header: Dict[str, Any], steps: np.ndarray, counts: np.ndarray, member: np.ndarray) -> SocialGraph:
    """The graph of an archive's content; raises ValueError (or its InvalidGraph) where that contradicts itself."""
    rows, columns = (int(extent) for extent in header["shape"])
    numbers = np.cumsum(steps, dtype=np.int64)
    if (min(rows, columns) < 1 or rows * columns > MOST_CELLS or counts.dtype != np.uint16
            or len({len(numbers), len(counts), len(member)}) != 1 or (steps[1:] == 0).any()
            or (len(numbers) and numbers[-1] >= 8 * rows * columns)):
        raise ValueError("the arrays do not fit together")
    heading, row, column = np.unravel_index(numbers[member.astype(bool)], (8, rows, columns))
    edges = np.zeros((rows, columns), dtype=np.uint8)
    np.bitwise_or.at(edges, (row, column), (1 << heading).astype(np.uint8))
    origin = None
    if header["origin"] is not None:
        x, y, yaw = map(float, header["origin"])
        origin = Pose(x, y, yaw)
    used = EdgeCounts((rows, columns), numbers, counts) if header["counted"] else None
    return SocialGraph(edges, str(header["map"]), float(header["resolution"]), origin=origin,
                       counts=None if used is None else used.only(counts > 0))


def write_graphml(graph: SocialGraph, path: PathLike) -> None:
    """Write a graph as GraphML, which appears whole or not at all.

    Nodes are called ``ROW,COLUMN`` and have `row` and `column`, and `x`, `y` [m, map frame] where the map's origin is
    known. Edges have `heading`, `weight` [m] and `paths`.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    import networkx

    routes = graph.to_networkx()
    for (row, column), values in routes.nodes(data=True):
        values.update(row=row, column=column)
    if graph.origin is not None and len(routes):
        nodes = list(routes)
        for node, (x, y) in zip(nodes, _centres(graph, np.array(nodes)).tolist()):
            routes.nodes[node].update(x=x, y=y)
    named = networkx.relabel_nodes(routes, {node: f"{node[0]},{node[1]}" for node in routes})
    with atomic_write(path) as stream:
        stream.writelines(line + "\n" for line in networkx.generate_graphml(named))


def _shape(graph: SocialGraph) -> Tuple[int, int]:
    return graph.edges.shape[0], graph.edges.shape[1]


def _centres(graph: SocialGraph, cells: np.ndarray) -> np.ndarray:
    """Centres (M, 2) [m, map frame] of cells (row, column)."""
    assert graph.origin is not None
    x, y, yaw = graph.origin
    along = (cells[:, ::-1] + 0.5) * graph.resolution
    cos, sin = np.cos(yaw), np.sin(yaw)
    return along @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
