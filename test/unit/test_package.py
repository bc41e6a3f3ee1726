"""What the package says of itself agrees: dependencies, the list that tools/setup installs, messages, version."""

import os
import re
import sysconfig
from importlib.util import find_spec
from typing import Dict, List, NamedTuple, Set
from xml.etree import ElementTree

import pytest

import social_fleet
from repository import ROOT, SOURCE, imports, name_of, python_files
from social_fleet.coordination.schedule import KINDS
from social_fleet.execution.state import ProgressState
from social_fleet.files import read_yaml

PACKAGE = ElementTree.parse(ROOT / "package.xml").getroot()
# Modules whose package has another name; the rest go by their own, as ROS packages do, or python3-NAME.
KEY_OF = {"PIL": "python3-pil", "yaml": "python3-yaml", "catkin_pkg": "catkin", "setuptools": "python3-setuptools"}
# What Debian does not have, and what only the plugin for it is built with.
NAVIGATION = {"amcl", "costmap_2d", "gmapping", "map_server", "move_base", "nav_core", "pluginlib", "roscpp"}
OWN = {"social_fleet"} | {path.stem for path in python_files("test", "tools")}


class Interface(NamedTuple):
    """One part of a .msg or .srv file."""

    fields: Dict[str, str]
    constants: Dict[str, int]


def declared(*kinds: str) -> Set[str]:
    """Keys that package.xml names, of the given kinds of dependency or of all."""
    return {element.text or "" for element in PACKAGE
            if element.tag.endswith("depend") and (not kinds or element.tag in kinds)}


def debian_list() -> Dict[str, List[str]]:
    """tools/packages.txt: Debian's packages by key."""
    packages: Dict[str, List[str]] = {}
    for line in (ROOT / "tools" / "packages.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            key, *names = line.split()
            packages.setdefault(key, []).extend(names)
    return packages


def interface(text: str) -> Interface:
    """Fields (type by name) and constants of a message, a request or a response."""
    fields, constants = {}, {}
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if words and "=" in words[-1]:
            name, value = "".join(words[1:]).split("=")
            constants[name] = int(value)
        elif words:
            fields[words[1]] = words[0]
    return Interface(fields, constants)


def message(name: str) -> Interface:
    """A message of the package."""
    return interface((ROOT / "msg" / f"{name}.msg").read_text(encoding="utf-8"))


def response(name: str) -> Interface:
    """The response of a service of the package."""
    return interface((ROOT / "srv" / f"{name}.srv").read_text(encoding="utf-8").split("\n---\n")[1])


def request(name: str) -> Interface:
    """The request of a service of the package."""
    return interface((ROOT / "srv" / f"{name}.srv").read_text(encoding="utf-8").split("\n---\n")[0])


def is_standard(module: str) -> bool:
    """Whether a module comes with Python itself."""
    spec = find_spec(module)
    origin = (spec.origin if spec else "") or ""
    home = sysconfig.get_paths()["stdlib"] + os.sep
    return origin in ("built-in", "frozen") or (origin.startswith(home) and "-packages" not in origin)


def test_the_list_of_debian_packages_holds_what_package_xml_names_and_no_more() -> None:
    assert set(debian_list()) - {"-"} == declared() - NAVIGATION


def test_every_key_of_the_list_has_packages_and_none_comes_twice() -> None:
    names = [name for group in debian_list().values() for name in group]
    assert all(debian_list().values())
    assert len(names) == len(set(names))
    assert all(re.fullmatch(r"[a-z0-9][a-z0-9.+-]+", name) for name in names)


@pytest.mark.parametrize("folders, kinds", [
    (("src", "scripts"), ("depend", "exec_depend")),
    (("test", "tools"), ()),
], ids=["run", "test"])
def test_whatever_is_imported_is_declared(folders: List[str], kinds: List[str]) -> None:
    keys = declared(*kinds)
    wrong = set()
    for path in python_files(*folders):
        for module, line in imports(path):
            top = module.split(".")[0]
            if top in OWN or is_standard(top):
                continue
            if not {KEY_OF.get(top, top), f"python3-{top}"} & keys:
                wrong.add(f"{name_of(path)}:{line}: {top}")
    assert not sorted(wrong)


def test_messages_are_built_from_declared_packages() -> None:
    used = {match.group(1) for path in [*ROOT.glob("msg/*"), *ROOT.glob("srv/*")]
            for match in re.finditer(r"^(\w+)/\w+", path.read_text(encoding="utf-8"), re.MULTILINE)}
    assert used <= declared("depend") - NAVIGATION
    built = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    assert all(package in built for package in used)


def test_cmake_builds_every_message_and_service() -> None:
    built = set(re.findall(r"^\s+(\w+\.(?:msg|srv))$", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.M))
    assert built == {path.name for path in [*ROOT.glob("msg/*"), *ROOT.glob("srv/*")]}


def test_cmake_installs_every_executable() -> None:
    built = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    assert set(re.findall(r"^ +(scripts/\w+)$", built, re.MULTILINE)) == {
        f"scripts/{path.name}" for path in (ROOT / "scripts").iterdir() if path.is_file()}


def test_the_plugins_parameters_are_those_of_its_manual() -> None:
    code = (ROOT / "src" / "global_planner" / "social_global_planner.cpp").read_text(encoding="utf-8")
    read = dict(re.findall(r'(?:own\.param\(|atLeast\(own, )"(\w+)", (?:parameters_\.\w+, )?'
                           r"([^,)]+|std::string\([^)]*\))", code))
    shown = read_yaml(ROOT / "config" / "social_global_planner.yaml")
    assert set(read) == set(shown)
    for name, default in read.items():
        plain = default.replace("std::string(", "").strip('()"')
        assert plain == (str(shown[name]).lower() if isinstance(shown[name], bool) else str(shown[name])), name


def test_every_field_is_explained() -> None:
    for path in [*ROOT.glob("msg/*"), *ROOT.glob("srv/*")]:
        lines = path.read_text(encoding="utf-8").splitlines()
        assert lines[0].startswith("# "), f"{path.name} does not say what it is"
        declarations = [line for line in lines if line and not line.startswith(("#", "---"))]
        assert not [line for line in declarations if "#" not in line and "SUCCESS=0" not in line], path.name


@pytest.mark.parametrize("name, fields", [
    ("EncounterWindow", "robot_r robot_s kind r_enter r_exit s_enter s_exit first"),
    ("Precedence", "at other other_at"),
    ("PlannedPath", "header robot path max_speed radius temporary"),
    ("Schedule", "header robot path max_speed radius arc_lengths times precedences version"),
    ("Progress", "header robot schedule_version arc_length speed state"),
])
def test_messages_keep_their_fields(name: str, fields: str) -> None:
    assert set(fields.split()) <= set(message(name).fields)


@pytest.mark.parametrize("name, asked, answered", [
    ("PlanPath", "robot start goal tolerance", "status message path length social_cost planning_time temporary"),
    ("Coordinate", "planning fixed time_margin time_limit",
     "status message schedules windows solve_time objective gap"),
])
def test_services_keep_their_fields(name: str, asked: str, answered: str) -> None:
    assert set(asked.split()) <= set(request(name).fields)
    assert set(answered.split()) <= set(response(name).fields)


def test_statuses_are_those_of_move_base_flex_where_it_has_them() -> None:
    get_path = {"SUCCESS": 0, "FAILURE": 50, "CANCELED": 51, "INVALID_START": 52, "INVALID_GOAL": 53,
                "NO_PATH_FOUND": 54, "PAT_EXCEEDED": 55, "TF_ERROR": 57, "NOT_INITIALIZED": 58, "INTERNAL_ERROR": 60}
    plan_path, coordinate = response("PlanPath").constants, response("Coordinate").constants
    assert get_path.items() <= plan_path.items()
    assert coordinate["TIMED_OUT"] == get_path["PAT_EXCEEDED"]
    for name in set(plan_path) & set(coordinate):
        assert plan_path[name] == coordinate[name]
    for constants in (plan_path, coordinate):
        assert len(set(constants.values())) == len(constants)
        assert all(value >= 71 for name, value in constants.items() if name not in get_path and name != "TIMED_OUT")


def test_progress_states_are_the_trackers() -> None:
    assert message("Progress").constants == {state.name: state.value for state in ProgressState}


def test_window_kinds_are_the_coordinators() -> None:
    kinds = message("EncounterWindow").constants
    assert [name.lower() for name in sorted(kinds, key=kinds.__getitem__)] == list(KINDS)


def test_version_and_licence_are_the_same_everywhere() -> None:
    version = PACKAGE.findtext("version") or ""
    assert social_fleet.__version__ == version
    assert re.search(rf"^{re.escape(version)} \(", (ROOT / "CHANGELOG.rst").read_text(encoding="utf-8"), re.MULTILINE)
    assert PACKAGE.findtext("license") == "BSD"
    assert (ROOT / "LICENSE").read_text(encoding="utf-8").startswith("BSD 3-Clause License")


def test_commands_have_the_run_bit() -> None:
    commands = [path for path in (ROOT / "tools").iterdir() if path.is_file() and not path.suffix]
    assert {"setup", "demo", "test", "social_fleet"} <= {path.name for path in commands}
    assert not [path.name for path in [*commands, ROOT / ".ci" / "run"] if not os.access(path, os.X_OK)]


def test_the_library_is_imported_without_ros() -> None:
    assert not (SOURCE / "msg").exists()  # messages are generated into the workspace, beside the sources
