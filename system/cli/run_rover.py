"""`noctule run rover`: plan a way on a cost map, drive it, and say how well."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.cli.run_output import print_run
from system.options.block import describe_die, read_die
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.rover.run import SYSTEM, Scenario, Trace, Trip, no_silicon, read_options
from system.system import Summary


def run_rover(
    system: str,
    silicon: SiliconChoice,
    seed: int,
    plot: str | None,
    *,
    as_json: bool,
    **options: Any,
) -> None:
    """Run the rover, print its ways and summary; `plot` draws them. `options` are texts of its scenario."""
    if plot is not None:
        check_picture(plot)
    celsius = parse_quantity(silicon.temperature, "degC", "--temperature")
    check_temperature(celsius)
    _check_silicon(silicon, options)
    scenario = Scenario(
        seed=seed,
        die=read_die(silicon),
        temperature_c=celsius,
        **read_options(options),
    )
    with progress_bar(f"{system} (the first run compiles its kernels)") as progress:
        trace = SYSTEM.run(scenario, progress)
    summary = SYSTEM.summarise(trace)
    if plot is not None:
        save_picture(plot, lambda figure: SYSTEM.draw(trace, figure))
    if as_json:
        print_json(_document(system, trace, summary))
    else:
        _print(system, trace, summary)


def _check_silicon(silicon: SiliconChoice, options: Mapping[str, Any]) -> None:
    """Refuse what only silicon has where there is none, the usual values too."""
    if options.get("cells", "ideal") != "ideal":
        return
    asked = {
        "die": silicon.die is not None,
        "temperature": silicon.temperature != "27",
        "unit": "unit" in options,
        "bias-kind": "bias_kind" in options,
        "silicon-noise": options.get("silicon_noise", "off") != "off",
    }
    for name, given in asked.items():
        if given:
            raise no_silicon(f"--{name}")


def _document(system: str, trace: Trace, summary: Summary) -> dict[str, Any]:
    s, last = trace.scenario, trace.trips[-1]
    return {
        "system": system,
        "map": trace.cost_map.name,
        "rows": trace.cost_map.shape[0],
        "columns": trace.cost_map.shape[1],
        "cell_width_m": trace.cost_map.cell_width,
        "cell_height_m": trace.cost_map.cell_height,
        "start": s.start,
        "goal": s.goal,
        "planner": s.planner,
        "cells": s.cells,
        "need": s.need,
        "learn": s.learn,
        "temperature_C": s.temperature_c,
        **describe_die(s.die),
        "bias_kind": s.bias_kind,
        "unit_s": s.unit,
        "silicon_noise": s.silicon_noise,
        "seed": s.seed,
        "planned_path": last.plan.path,
        "time_s": last.drive.time,
        "driven_path_m": last.drive.place,
        "gps_path_m": last.drive.fix,
        "trips": [_trip(trip) for trip in trace.trips],
        "summary": summary,
    }


def _trip(trip: Trip) -> dict[str, Any]:
    return {
        "planned_path": trip.plan.path,
        "length": trip.plan.length,
        "cost": trip.plan.cost,
        "regret": trip.plan.regret,
        "interventions": trip.drive.interventions,
        "arrived": trip.drive.arrived,
        "map_error": trip.map_error,
    }


def _print(system: str, trace: Trace, summary: Summary) -> None:
    s = trace.scenario
    way = " ".join(f"{row},{column}" for row, column in trace.trips[-1].plan.path.tolist())
    print_line(f"planned on {trace.cost_map.name}: {way}")
    if len(trace.trips) > 1:
        rows = [
            (k, t.plan.length, t.plan.cost, t.plan.regret, f"{t.map_error:.3g}")
            for k, t in enumerate(trace.trips)
        ]
        print_table("trips", ("trip:", "length:", "cost:", "regret:", "map error:"), rows)
    print_run(_title(system, s), SYSTEM, summary)


def _title(system: str, scenario: Scenario) -> str:
    title = f"{system}, {scenario.planner} on {scenario.cells} cells"
    return title if scenario.cells == "ideal" else f"{title}, {scenario.temperature_c:g} degC, {scenario.die}"
