"""catkin's and roslaunch's own checks of the package, and what Noetic's libraries do not know yet."""

import ast
import importlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, Dict, Iterator, List, Set, Tuple
from xml.etree import ElementTree

import pytest

from repository import ROOT, name_of, python_files

LAUNCH = sorted(ROOT.glob("launch/*.launch"))
# What a launch file needs to be told.
ARGUMENTS = {"robot": "gold", "robots": "{}", "scenario": "$(find social_fleet)/config/scenarios/crossing.yaml",
             "map": "$(find social_fleet)/maps/crossing.yaml"}
NOETIC = {"numpy": (1, 17), "scipy": (1, 3), "networkx": (2, 4)}  # of Ubuntu 20.04
# Used only where it is there.
OPTIONAL = {"scipy.optimize.milp", "scipy.optimize.Bounds", "scipy.optimize.LinearConstraint"}
ADDED = re.compile(r"\.\. versionadded::\s*v?(\d+)\.(\d+)")


def is_there(package: str) -> bool:
    """Whether rospack finds it."""
    return subprocess.run(("rospack", "find", package), capture_output=True).returncode == 0


@pytest.mark.skipif(shutil.which("catkin_lint") is None, reason="catkin_lint is not installed")
def test_catkin_lint() -> None:
    environment = {**os.environ, "PYTHONPATH": ""}
    result = subprocess.run(("catkin_lint", "-W1", "--strict", str(ROOT)), capture_output=True, text=True, timeout=120,
                            env=environment)
    assert result.returncode == 0, result.stdout + result.stderr


@pytest.mark.skipif(shutil.which("roslaunch") is None or "ROS_MASTER_URI" not in os.environ, reason="needs ROS")
@pytest.mark.parametrize("path", LAUNCH, ids=lambda path: path.stem)
def test_roslaunch_check(path: Path, tmp_path: Path) -> None:
    from roslaunch.rlutil import check_roslaunch
    missing = [package for package in sorted(packages(path)) if "$(" not in package and not is_there(package)]
    if missing:
        pytest.skip(f"{path.name}: rospack does not find {', '.join(missing)}")
    folder = ROOT / "build" / "test_results"  # the check looks for the package that a file is in
    folder.mkdir(parents=True, exist_ok=True)
    wrapper = folder / f"check_{path.name}"
    wrapper.write_text(wrapped(path), encoding="utf-8")
    assert not check_roslaunch(str(wrapper))
    files = subprocess.run(("roslaunch", "--files", str(wrapper)), capture_output=True, text=True, timeout=60)
    assert files.returncode == 0 and str(path) in files.stdout, files.stderr


def packages(path: Path) -> Set[str]:
    """The packages whose nodes a launch file starts, by itself or through the package's others that it includes."""
    root = ElementTree.parse(path)
    names = {node.get("pkg", "") for node in root.iter("node")}
    for include in root.iter("include"):
        file = include.get("file", "")
        if file.startswith("$(find social_fleet)"):
            names |= packages(ROOT / "launch" / os.path.basename(file))
    return names


def wrapped(path: Path) -> str:
    """A launch file that gives `path` the arguments without which it cannot be."""
    required = [argument.get("name", "") for argument in ElementTree.parse(path).getroot().findall("arg")
                if argument.get("default") is None and argument.get("value") is None]
    given = "".join(f'<arg name="{name}" value="{ARGUMENTS[name]}" />' for name in required)
    return f'<launch><include file="{path}">{given}</include></launch>'


def test_nothing_is_newer_than_noetics_libraries() -> None:
    wrong = []
    for path in python_files("src", "scripts"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = library_names(tree)
        for node in ast.walk(tree):
            for used, keywords, line in uses(node, names):
                wrong += [f"{name_of(path)}:{line}: {problem}" for problem in newer_than_noetic(used, keywords)]
    assert not wrong


def library_names(tree: ast.AST) -> Dict[str, str]:
    """What the names of a file stand for in these libraries."""
    names: Dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] in NOETIC:
                    names[alias.asname or alias.name.split(".")[0]] = alias.name if alias.asname else \
                        alias.name.split(".")[0]
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in NOETIC:
            names.update((alias.asname or alias.name, f"{node.module}.{alias.name}") for alias in node.names)
    return names


def uses(node: ast.AST, names: Dict[str, str]) -> Iterator[Tuple[str, List[str], int]]:
    """Full name, keywords and line of a library's object that is named or called here."""
    if isinstance(node, ast.Call):
        full = full_name(node.func, names)
        if full:
            yield full, [keyword.arg for keyword in node.keywords if keyword.arg], node.lineno
    elif isinstance(node, (ast.Attribute, ast.Name)):
        full = full_name(node, names)
        if full:
            yield full, [], node.lineno


def full_name(node: ast.AST, names: Dict[str, str]) -> str:
    if isinstance(node, ast.Name):
        return names.get(node.id, "")
    if isinstance(node, ast.Attribute):
        base = full_name(node.value, names)
        return f"{base}.{node.attr}" if base else ""
    return ""


def newer_than_noetic(name: str, keywords: List[str]) -> Iterator[str]:
    """What of an object and its keywords came later, as its documentation says."""
    if name in OPTIONAL:
        return
    text = documentation(name)
    newest = NOETIC[name.split(".")[0]]
    head, _, rest = text.partition("Parameters\n")
    if any(added > newest for added in versions(head)):
        yield name
    for keyword in keywords:
        found = re.search(rf"^ *{keyword} ?:.*\n((?:(?! *\w+ ?: ).*\n)*)", rest, re.MULTILINE)
        if found and any(added > newest for added in versions(found.group(1))):
            yield f"{name}({keyword}=)"


def versions(text: str) -> List[Tuple[int, int]]:
    return [(int(major), int(minor)) for major, minor in ADDED.findall(text)]


def documentation(name: str) -> str:
    """The docstring of a dotted name; empty for a method of a value, which has no such name."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found: Any = importlib.import_module(".".join(parts[:count]))
        except ImportError:
            continue
        for part in parts[count:]:
            found = getattr(found, part, None)
        return (getattr(found, "__doc__", "") or "") if callable(found) else ""
    return ""


def test_the_check_notices_what_is_newer() -> None:
    if tuple(map(int, importlib.import_module("scipy").__version__.split(".")[:2])) < (1, 9):
        pytest.skip("this SciPy is as old as Noetic's")
    tree = ast.parse("import numpy as np\nfrom scipy.spatial import KDTree\n"
                     "np.lib.stride_tricks.sliding_window_view(a, 3)\n"
                     "KDTree.query(t, x, workers=2)\nnp.sum(a, axis=0)\n")
    names = library_names(tree)
    found = {problem for node in ast.walk(tree) for used, keywords, _ in uses(node, names)
             for problem in newer_than_noetic(used, keywords)}
    assert found == {"numpy.lib.stride_tricks.sliding_window_view", "scipy.spatial.KDTree.query(workers=)"}


WITHOUT_MILP = """
import scipy.optimize
for name in ("milp", "Bounds", "LinearConstraint"):
    delattr(scipy.optimize, name)
import social_fleet as sf
from social_fleet.coordination import solvers
assert solvers.milp is None
robots = [sf.Robot("gold", [(0.0, 5.0), (10.0, 5.0)]), sf.Robot("blue", [(5.0, 0.0), (5.0, 10.0)])]
print(solvers.find_solver(None, 5.0).name, sf.verify(sf.coordinate(robots)).min_clearance >= 0.0)
"""


@pytest.mark.skipif(shutil.which("cbc") is None, reason="CBC is not installed")
def test_a_scipy_without_milp_leaves_it_to_cbc() -> None:
    result = subprocess.run((sys.executable, "-c", WITHOUT_MILP), capture_output=True, text=True, timeout=120,
                            env={**os.environ, "PYTHONPATH": str(ROOT / "src")})
    assert result.returncode == 0, result.stderr
    name, safe = result.stdout.split()
    assert "C" in name and "HiGHS" not in name and safe == "True"
