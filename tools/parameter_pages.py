"""doc/parameters.md, from what declares the parameters and from the comments that explain them."""

import dataclasses
import re
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Union, get_type_hints

from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.files import read_yaml
from social_fleet.manual import read_manual
from social_fleet.planning.config import PlannerConfig
from social_fleet.ros.fake_robots import FakeRobotsParameters
from social_fleet.ros.fleet_coordinator import FleetCoordinatorParameters
from social_fleet.ros.navigator import NavigatorParameters
from social_fleet.ros.reconfigure import changeable
from social_fleet.ros.social_planner import SocialPlannerParameters
from social_fleet.ros.trajectory_tracker import TrajectoryTrackerParameters
from social_fleet.simulation.config import SimulationConfig

ROOT = Path(__file__).resolve().parent.parent
HEAD = """# Parameters

Written by `./tools/document_parameters` from `config/*.yaml`, which are the manual and show every default, and from
what declares the parameters; a test keeps this page up to date. Every node refuses an unknown name, a wrong type and a
value out of range, by the parameter's full name.
"""


class Page(NamedTuple):
    """One file of parameters and what declares them; None: the plugin, which is not Python."""

    file: str
    title: str
    kind: Optional[type]
    note: str = ""


PAGES = (
    Page("planner.yaml", "Planning, in the node social_planner and on the command line", PlannerConfig,
         "Those with an asterisk can be changed under way by dynamic_reconfigure; the next plan uses them."),
    Page("social_planner.yaml", "The node social_planner", SocialPlannerParameters),
    Page("social_global_planner.yaml", "move_base's plugin social_fleet/SocialGlobalPlanner", None,
         "Below its name, `~SocialGlobalPlanner/...` of move_base."),
    Page("fleet_coordinator.yaml", "The node fleet_coordinator", FleetCoordinatorParameters),
    Page("tracker.yaml", "Tracking, in the node trajectory_tracker", TrackerConfig),
    Page("trajectory_tracker.yaml", "The node trajectory_tracker", TrajectoryTrackerParameters),
    Page("recovery.yaml", "Promises, delays and replans, in the nodes trajectory_tracker and fleet_coordinator",
         RecoveryConfig, "Below `recovery`."),
    Page("navigator.yaml", "The node navigator", NavigatorParameters),
    Page("fake_robots.yaml", "Simulation, in the node fake_robots and on the command line", SimulationConfig),
    Page("fake_robots_node.yaml", "The node fake_robots", FakeRobotsParameters),
)


def document() -> str:
    """The whole page."""
    return HEAD + "".join(_section(page) for page in PAGES)


def _section(page: Page) -> str:
    rows = "\n".join(_rows(page))
    note = f"\n{page.note}\n" if page.note else ""
    return (f"\n## {page.title}\n\n[config/{page.file}](../config/{page.file})\n{note}\n"
            f"| parameter | default | allowed | meaning |\n|---|---|---|---|\n{rows}\n")


def _rows(page: Page) -> Iterator[str]:
    path = ROOT / "config" / page.file
    shown, declared = read_yaml(path), _declared(page.kind)
    asterisks = set(changeable()) if page.kind is PlannerConfig else set()
    for name, text in read_manual(path).items():
        default = "follows from others" if name not in shown else _shown(shown[name])
        cells = (f"`{name}`{' *' if name in asterisks else ''}", default, declared.get(name, ""), text)
        yield "| " + " | ".join(re.sub(r"(?<!\\)\|", r"\\|", cell) for cell in cells) + " |"


def _declared(kind: Optional[type]) -> Dict[str, str]:
    """What is allowed, by name."""
    if kind is None:
        return {}
    kinds = get_type_hints(kind)
    return {field.name: _allowed(kinds[field.name], field.metadata)
            for field in dataclasses.fields(kind)}


def _allowed(kind: Any, bounds: Any) -> str:
    if getattr(kind, "__origin__", None) is Union:
        kind = next(option for option in kind.__args__ if not isinstance(None, option))
    if bounds.get("choices"):
        return ", ".join(bounds["choices"])
    if kind is bool:
        return "true, false"
    words: List[str] = {float: ["number"], int: ["whole number"], str: ["text"]}.get(kind, [])
    signs = (("above", "greater than"), ("minimum", "at least"), ("maximum", "at most"))
    above = bounds.get("above")
    return " ".join(words) + "".join(
        f", {words} {bounds[name]:g}" for name, words in signs
        if bounds.get(name) is not None and not (name == "minimum" and above is not None))


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "none" if not value else "see the file"
    return f"`{value:.10g}`" if isinstance(value, float) else f"`{value}`" if value != "" else "empty"


if __name__ == "__main__":
    print(document(), end="")
