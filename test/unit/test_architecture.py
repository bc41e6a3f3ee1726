"""The house keeps its order: who may import whom, where ROS may be known, and how large a room is."""

import ast
import os
import re
from pathlib import Path
from typing import Iterator
from xml.etree import ElementTree

from repository import ROOT, SOURCE, imports, name_of, python_files

# A folder imports from itself and from those to its left; the modules at the top of the package come before all.
LAYERS = ("mapping", "planning", "coordination", "execution", "simulation", "scenario", "experiments", "fleet", "cli",
          "ros")
ROS = re.compile(r"(rospy|roslib|ros(graph|launch|test|param|pkg|bag|service|topic|node|unit)|genpy|genmsg|actionlib"
                 r"|tf|tf2_\w+|\w+_(msgs|srvs)|dynamic_reconfigure|diagnostic_updater|message_filters"
                 r"|social_fleet\.(msg|srv))(\.|$)")
MACHINE_PATH = re.compile(r"(?<![\w.}$])/(?:home|root|Users|work|mnt)/\w")
OWN_FILE = re.compile(r"\$\(find social_fleet\)/([\w./-]+\.\w+)")
BUILTIN = {"list", "dict", "tuple", "set", "frozenset", "type", "deque", "defaultdict"}
NEWER_ATTRIBUTES = {"removeprefix", "removesuffix", "pairwise", "bit_count", "is_relative_to", "with_stem", "lcm"}
NEWER_KEYWORDS = {("zip", "strict"), ("dataclass", "slots"), ("dataclass", "kw_only")}
BINARY = (".pgm", ".png", ".gif", ".npz")

PYTHON = python_files("src", "scripts", "test", "tools") + [ROOT / "setup.py"]
LAUNCH = sorted([*ROOT.glob("launch/**/*.launch"), *ROOT.glob("test/**/*.test")])
EXECUTABLES = sorted(path for path in ROOT.glob("scripts/*") if path.is_file())


def layer(path: Path) -> str:
    """The folder of a module of the package; empty for those at its top."""
    parts = path.relative_to(SOURCE).parts
    return parts[0] if len(parts) > 1 else ""


def test_every_folder_has_its_place() -> None:
    folders = {layer(path) for path in python_files("src")} - {""}
    assert folders <= set(LAYERS)


def test_imports_point_one_way() -> None:
    wrong = []
    for path in python_files("src"):
        if path == SOURCE / "__init__.py":
            continue  # names the public ones of every folder, and imports each when it is first used
        own = layer(path)
        allowed = LAYERS[:LAYERS.index(own) + 1] if own else ()
        for module, line in imports(path):
            parts = module.split(".")
            if parts[0] == "social_fleet" and len(parts) > 1 and parts[1] in LAYERS and parts[1] not in allowed:
                wrong.append(f"{name_of(path)}:{line}: {module}")
    assert not wrong


def test_ros_is_known_in_one_folder_only() -> None:
    assert not [f"{name_of(path)}:{line}: {module}" for path in python_files("src") if layer(path) != "ros"
                for module, line in imports(path) if ROS.match(module)]


def test_python_38_can_read_every_file() -> None:
    wrong = []
    for path in PYTHON:
        try:
            tree = ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 8))
        except SyntaxError as error:
            wrong.append(f"{name_of(path)}:{error.lineno}: {error.msg}")
        else:
            wrong += [f"{name_of(path)}:{use}" for use in newer_than_38(tree)]
    assert not wrong


def newer_than_38(tree: ast.AST) -> Iterator[str]:
    """Uses of what came after Python 3.8 but parses as 3.8."""
    for node in ast.walk(tree):
        for annotation in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            for part in ast.walk(annotation) if isinstance(annotation, ast.expr) else ():
                if isinstance(part, ast.BinOp) and isinstance(part.op, ast.BitOr):
                    yield f"{part.lineno}: X | Y as a type"
                if isinstance(part, ast.Subscript) and isinstance(part.value, ast.Name) and part.value.id in BUILTIN:
                    yield f"{part.lineno}: {part.value.id}[...] as a type"
        if isinstance(node, ast.Attribute) and node.attr in NEWER_ATTRIBUTES:
            yield f"{node.lineno}: {node.attr}"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            for keyword in node.keywords:
                if (node.func.id, keyword.arg) in NEWER_KEYWORDS:
                    yield f"{node.lineno}: {node.func.id}({keyword.arg}=)"


def test_a_module_is_one_room() -> None:
    assert not [name_of(path) for path in PYTHON if len(path.read_text(encoding="utf-8").splitlines()) > 400]


def test_executables_run_and_are_short() -> None:
    assert EXECUTABLES
    for path in EXECUTABLES:
        # The command line's has none in the sources: rosrun would find it beside tools/social_fleet, and ask.
        assert os.access(path, os.X_OK) == (path.name != "social_fleet"), f"{name_of(path)}: run bit"
        lines = path.read_text(encoding="utf-8").splitlines()
        # Not env's python3: another interpreter that comes first on PATH has no rospy.
        assert lines[0] == "#!/usr/bin/python3", name_of(path)
        assert len(lines) <= 50, name_of(path)


def test_no_path_of_a_machine() -> None:
    folders = ("src", "test", "tools", "scripts", "config", "launch", "maps", "rviz", "msg", "srv", "doc", ".ci")
    files = [path for path in ROOT.iterdir() if path.is_file() and path.name != ".git"]  # one in a worktree
    files += [path for folder in folders for path in (ROOT / folder).rglob("*") if path.is_file()]
    wrong = []
    for path in sorted(files):
        if path.suffix not in BINARY and "__pycache__" not in path.parts:
            text = path.read_text(encoding="utf-8")
            wrong += [f"{name_of(path)}: {found.group()}" for found in MACHINE_PATH.finditer(text)]
    assert not wrong


def test_launch_files_refer_to_what_is_there() -> None:
    missing = []
    for path in LAUNCH:
        for element in ElementTree.parse(path).iter():
            type_ = element.get("type", "")
            if element.get("pkg") == "social_fleet" and element.tag in ("node", "test") and "$(" not in type_:
                places = [ROOT / "scripts" / type_, *ROOT.glob(f"test/**/{type_}")]
                if not any(os.access(place, os.X_OK) for place in places):
                    missing.append(f"{name_of(path)}: executable {type_}")
            for value in element.attrib.values():
                missing += [f"{name_of(path)}: {file}" for file in OWN_FILE.findall(value)
                            if not (ROOT / file).is_file()]
    assert not missing


def test_launch_files_explain_their_arguments() -> None:
    assert not [f"{name_of(path)}: {argument.get('name')}" for path in ROOT.glob("launch/**/*.launch")
                for argument in ElementTree.parse(path).getroot().findall("arg")
                if not argument.get("doc") and argument.get("value") is None]
