"""Plan and coordinate the fleet of a scenario file: when each robot is where, so that no two ever touch."""

import argparse
from dataclasses import replace
from typing import Any, Dict, List

from social_fleet.cli.arguments import check_outputs, positive
from social_fleet.cli.output import show, table, written
from social_fleet.cli.progress import progress
from social_fleet.coordination.options import FORMULATIONS, MODES, OBJECTIVES
from social_fleet.errors import Infeasible, NoPath, SolverFailed, TimedOut

SUMMARY = "schedule the fleet of a scenario file"
EXAMPLE = "social_fleet coordinate config/scenarios/figure_9.yaml --out schedule.json --plot schedule.png"

_STATUS = {NoPath: "no_path_found", Infeasible: "infeasible", TimedOut: "timed_out", SolverFailed: "solver_failed"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes; an option overrides the file's."""
    parser.add_argument("scenario", metavar="SCENARIO.yaml", help="map, robots and options")
    parser.add_argument("--mode", choices=MODES, help="overrides the file's")
    parser.add_argument("--formulation", choices=FORMULATIONS,
                        help="exact never lets two robots touch; paper is Eq. 5-8 as printed")
    parser.add_argument("--objective", choices=OBJECTIVES, help="overrides the file's")
    parser.add_argument("--partial", action="store_true",
                        help="where not all can be served, name those left out and schedule the rest")
    parser.add_argument("--time-limit", type=positive, metavar="S", help="of the solver [s]")
    parser.add_argument("--out", metavar="schedule.json", help="write the schedule")
    parser.add_argument("--plot", metavar="schedule.png", help="draw paths, encounters and the space-time diagram")


def run(args: argparse.Namespace) -> int:
    """Coordinate, write, draw and sum up."""
    check_outputs(args.out, args.plot)
    from social_fleet.mapping.files import load_map
    from social_fleet.scenario.files import load_scenario
    from social_fleet.scenario.fleet import coordinate_scenario

    scenario = load_scenario(args.scenario)
    options = {name: getattr(args, name) for name in ("mode", "formulation", "objective", "time_limit")}
    given = {name: value for name, value in options.items() if value is not None}
    scenario = replace(scenario, coordination=replace(scenario.coordination, **given))
    grid = load_map(scenario.map_path)
    try:
        with progress(len(scenario.robots), "planning", "robots") as update:
            fleet = coordinate_scenario(scenario, grid, partial=args.partial, progress=update)
    except (NoPath, Infeasible, TimedOut, SolverFailed) as error:
        if not args.json:
            raise
        show(args, {"map": scenario.map, "status": _STATUS[type(error)], "message": str(error), "robots": []}, [])
        return 1
    if fleet.schedules:
        _write(fleet, grid, scenario.name, args)
    files = written(args.out, args.plot) if fleet.schedules else ["nobody is served, so no file is written"]
    show(args, _as_json(fleet) if args.json else None, [*summary(fleet), *files])
    return 1 if fleet.unserved else 0


def _write(fleet: Any, grid: Any, title: str, args: argparse.Namespace) -> None:
    if args.out:
        from social_fleet.coordination.files import write_schedule
        write_schedule(fleet, args.out)
    if args.plot:
        from social_fleet.scenario.pictures.schedule_picture import schedule_picture
        schedule_picture(grid, fleet, args.plot, title=title)


def _as_json(fleet: Any) -> Dict[str, Any]:
    from social_fleet.coordination.files import schedule_to_dict
    return schedule_to_dict(fleet)


def summary(fleet: Any) -> List[str]:
    """A table of the robots and what the coordination took."""
    rows = [[schedule.name, f"{schedule.robot.max_speed:.2f}", f"{schedule.robot.path.length:.1f}",
             f"{schedule.times[0]:.1f}", f"{schedule.arrival_time:.1f}", str(len(schedule.precedences))]
            for schedule in fleet.schedules]
    kinds: Dict[str, int] = {}
    for window in fleet.windows:
        kinds[window.kind] = kinds.get(window.kind, 0) + 1
    meetings = ", ".join(f"{number} {kind.replace('_', ' ')}" for kind, number in sorted(kinds.items()))
    lines = table(["robot", "m/s", "path m", "departs s", "arrives s", "precedences"], rows)
    lines.append(f"sum of completion {fleet.sum_of_completion:.1f} s, makespan {fleet.makespan:.1f} s, "
                 f"gap {round(100.0 * fleet.gap, 4):g} %; encounters: {meetings or 'none'}")
    lines.append(f"planning {fleet.planning_time:.2f} s, encounters {fleet.encounter_time:.3f} s, "
                 f"program {fleet.solve_time:.3f} s ({fleet.formulation} formulation)")
    lines += [f"left out: {name}: {reason}" for name, reason in fleet.unserved]
    return lines + ([fleet.message] if fleet.message else [])
