"""`noctule run pushbot`: drive through a scene with the network on a chip, and say how it went."""

from __future__ import annotations

from typing import Any

import numpy as np

from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity
from system.cli.output import print_json, progress_bar
from system.cli.run_output import print_run
from system.options.block import describe_die, read_die
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.pushbot.loop import all_events, rates
from system.pushbot.readout import LOOK
from system.pushbot.run import SYSTEM, Scenario, Trace, read_options
from system.system import Summary
from system.worlds.camera.file import check_events, write_events


def run_pushbot(
    system: str,
    silicon: SiliconChoice,
    seed: int,
    plot: str | None,
    *,
    as_json: bool,
    events: str | None = None,
    **options: Any,
) -> None:
    """Run the robot, print its summary; `options` are texts of its scenario.

    plot: draws the run; events: file for those that reached the controller, at the times at which they did.
    """
    if plot is not None:
        check_picture(plot)
    if events is not None:
        check_events(events)
    celsius = parse_quantity(silicon.temperature, "degC", "--temperature")
    check_temperature(celsius)
    scenario = Scenario(seed=seed, die=read_die(silicon), temperature_c=celsius, **read_options(options))
    with progress_bar(f"{system} (the first run compiles its kernels)") as progress:
        trace = SYSTEM.run(scenario, progress)
    summary = SYSTEM.summarise(trace)
    if plot is not None:
        save_picture(plot, lambda figure: SYSTEM.draw(trace, figure))
    if events is not None:
        write_events(events, all_events(trace.record))
    if as_json:
        print_json(_document(system, trace, summary))
    else:
        _print(system, trace, summary)


def _document(system: str, trace: Trace, summary: Summary) -> dict[str, Any]:
    s, path = trace.scenario, np.array(trace.drive.path)
    time, found = rates(trace.brain.network, trace.record, max(float(path[-1, 0]), LOOK))
    readout, codes = s.read(), trace.brain.chip.program.biases.codes()
    return {
        "system": system,
        "scene": trace.scene.name,
        "speed_factor": s.speed_factor,
        "turn_factor": readout.factors.turn,
        "window_s": readout.window,
        "readout": readout.kind,
        "modified": s.modified,
        "target_field": trace.brain.target,
        "dropped": s.dropped,
        "temperature_C": s.temperature_c,
        **describe_die(s.die),
        "bias_kind": s.bias_kind,
        "calibrated": s.calibrated,
        "codes": dict(sorted(codes.items())),  # coarse and fine
        "neurons": {p.name: len(p) for p in trace.brain.network.populations},
        "cautions": summary["cautions"],
        "seed": s.seed,
        "silicon_noise": s.silicon_noise,
        "touched": trace.drive.touched,
        "path": path,  # s, m, m, rad
        "commands": np.array(trace.record.commands).reshape(-1, 3),  # s, v, w
        "rate_time_s": time,
        "rates_Hz": found,
        "obstacle_line_m": None if trace.course is None else trace.course.distance,
        "summary": summary,
    }


def _print(system: str, trace: Trace, summary: Summary) -> None:
    s = trace.scenario
    title = f"{system}, {trace.scene.name}, speed factor {s.speed_factor:g},"
    title += f" turn factor {s.read().factors.turn:g}, {s.die}"
    print_run(title, SYSTEM, summary)
