"""`noctule run head`: follow a moving target with the sonar head, and say how well."""

from __future__ import annotations

from typing import Any

import numpy as np

from chips.lso.model import RECORD
from chips.record import current_record
from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity
from system.cli.output import print_json, print_line, progress_bar
from system.cli.run_output import print_run
from system.head.loop import LOST
from system.head.run import SYSTEM, Scenario, Trace, read_options
from system.options.block import describe_die, read_die
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.system import Summary


def run_head(
    system: str, silicon: SiliconChoice, seed: int, plot: str | None, *, as_json: bool, **options: Any
) -> None:
    """Run once, print its summary; `plot` draws angles and spikes. `options` are those of its scenario."""
    if plot is not None:
        check_picture(plot)
    celsius = parse_quantity(silicon.temperature, "degC", "--temperature")
    check_temperature(celsius)
    scenario = Scenario(seed=seed, die=read_die(silicon), temperature_c=celsius, **read_options(options))
    with progress_bar(f"{system}, {scenario.motion}") as progress:
        trace = SYSTEM.run(scenario, progress)
    summary = SYSTEM.summarise(trace)
    if plot is not None:
        save_picture(plot, lambda figure: SYSTEM.draw(trace, figure))
    if as_json:
        print_json(_document(system, trace, summary))
    else:
        _print(system, trace, summary)


def _document(system: str, trace: Trace, summary: Summary) -> dict[str, Any]:
    s, log = trace.scenario, trace.log
    return {
        "system": system,
        "motion": s.motion,
        "wiring": s.wiring,
        "bias_kind": s.bias_kind or "gate",
        "temperature_C": s.temperature_c,
        **describe_die(s.die),
        "area": s.area,
        "silicon_noise": s.silicon_noise,
        "seed": s.seed,
        "duration_s": s.duration,
        "ping_rate_Hz": s.head.ping_rate,
        "gain_deg_a_spike": np.degrees(s.head.gain),
        "distance_m": s.target.distance,
        "swing_m": s.target.swing,
        "time_s": log.time,
        "target_deg": np.degrees(log.target),
        "head_deg": np.degrees(log.head),
        "range_m": log.distance,
        "spikes_left": log.heard[:, 0],
        "spikes_right": log.heard[:, 1],
        "lost": list(log.lost),
        "model_errors": dict(current_record(RECORD).errors),
        "summary": summary,
    }


def _print(system: str, trace: Trace, summary: Summary) -> None:
    s = trace.scenario
    print_run(f"{system}, {s.motion}, {s.wiring}", SYSTEM, summary)
    lost = {name: trace.log.counts[name] for name in LOST if trace.log.counts[name]}
    if lost:
        print_line("pings without an answer: " + ", ".join(f"{n} {name}" for name, n in lost.items()))
