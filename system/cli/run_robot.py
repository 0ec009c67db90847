"""`noctule run robot`: drive through a forest of pipes by sonar, and say how it ended."""

from __future__ import annotations

from typing import Any

import numpy as np

from circuits.errors import ParameterError
from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity
from system.car.run import RANGES, SYSTEM, Scenario, Trace, read_options
from system.cli.output import print_json, print_line, progress_bar
from system.cli.run_output import print_run
from system.options.block import describe_die, read_die
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.system import Summary


def run_robot(
    system: str, silicon: SiliconChoice, seed: int, plot: str | None, *, as_json: bool, **options: Any
) -> None:
    """Drive once, print its summary; `plot` draws the way. `options` are those of its scenario."""
    if plot is not None:
        check_picture(plot)
    celsius = parse_quantity(silicon.temperature, "degC", "--temperature")
    check_temperature(celsius)
    if silicon.die is not None and options.get("ranges", RANGES[0]) != "chip":
        raise ParameterError(f"--die: {silicon.die}, no chip is in the loop; give --ranges chip")
    scenario = Scenario(seed=seed, die=read_die(silicon), temperature_c=celsius, **read_options(options))
    with progress_bar(f"{system}, {scenario.forest}") as progress:
        trace = SYSTEM.run(scenario, progress)
    summary = SYSTEM.summarise(trace)
    if plot is not None:
        save_picture(plot, lambda figure: SYSTEM.draw(trace, figure))
    if as_json:
        print_json(_document(system, trace, summary))
    else:
        _print(system, trace, summary)


def _document(system: str, trace: Trace, summary: Summary) -> dict[str, Any]:
    s, log = trace.scenario, trace.drive.log
    return {
        "system": system,
        "forest": s.forest,
        "ranges": s.ranges,
        **s.senses,
        **_of_chip(trace),
        "max_speed_m_per_s": s.robot.max_speed,
        "ping_rate_Hz": s.robot.ping_rate,
        "zone_m": s.robot.zone,
        "steering_deg": np.degrees(trace.arcs.steering),
        "curvature_per_m": trace.arcs.curvature,
        "ping_direction_of_arc": trace.arcs.group,
        "ping_directions_deg": np.degrees(trace.arcs.direction),
        "seed": s.seed,
        "start_m": trace.path[0],
        "ended": summary["reason"],
        "pipes_m": trace.forest.place,
        "time_s": log[:, 0],
        "path_m": trace.path,
        "heading_rad": log[:, 3],
        "ping_direction": log[:, 4].astype(int),
        "arc": log[:, 5].astype(int),
        "scanning": log[:, 6].astype(bool),
        "soft_ping": log[:, 7].astype(bool),
        "summary": summary,
    }


def _of_chip(trace: Trace) -> dict[str, Any]:
    s = trace.scenario
    if not s.silicon:
        return {}
    return {
        "reader": s.reader or "nominal",
        "bias_kind": s.bias_kind,
        "silicon_noise": s.silicon_noise,
        "temperature_C": s.temperature_c,
        **describe_die(s.die),
        "unsure_delays": trace.unsure,
    }


def _print(system: str, trace: Trace, summary: Summary) -> None:
    s, path = trace.scenario, trace.path
    print_run(f"{system}, {s.forest}, ranges {s.ranges}", SYSTEM, summary)
    where = [f"{x:.2f},{y:.2f} m" for x, y in (path[0], path[-1])]
    print_line(f"from {where[0]} to {where[1]}")
    if s.silicon:
        print_line("the chip gives ranges only: directions are those of the three envelopes")
    if trace.drive.ended == "undecided":
        print_line("--pings N drives on")
