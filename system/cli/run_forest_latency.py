"""`noctule run forest --model latency-network|latency-chip`: fly once, steered by spikes."""

from __future__ import annotations

from typing import Any

from circuits.devices.source import Polyline
from circuits.errors import ParameterError
from system.cli.output import print_json, print_line, progress_bar
from system.cli.run_output import print_run
from system.forest.run import QUANTITIES, ROOM_TEMPERATURE, SYSTEM, read_options, read_place
from system.options.block import read_die
from system.options.silicon import SiliconChoice
from system.options.temperature import read_course
from system.plot import save_picture
from system.reader import read_texts
from system.spiking_bat.run import (
    MODELS,
    LatencyTrace,
    account,
    document,
    draw,
    run,
    scenario_of,
    summarise,
)
from system.system import summary_of


def run_latency(
    silicon: SiliconChoice, seed: int, plot: str | None, *, as_json: bool, **options: Any
) -> None:
    """Fly once, print what came of it; `options` are those of a `LatencyScenario`."""
    chip = _silicon(silicon, read_course(silicon.temperature), options["model"])
    scenario = scenario_of({**options, **_checked(options), **chip, "seed": seed})
    with progress_bar(f"forest, {scenario.model} (the first run compiles its kernels)") as progress:
        trace = run(scenario, progress)
    if plot is not None:
        save_picture(plot, lambda figure: draw(trace, figure))
    if as_json:
        print_json(document(trace))
    else:
        _print(trace)


def _checked(options: dict[str, Any]) -> dict[str, Any]:
    """Place and numbers as the analog model reads them, so that they are refused in the same words."""
    read_options({n: options[n] for n in ("map", "obstacles", "vmax", "ping_rate") if n in options})
    found = read_texts(options, {**QUANTITIES, "start": read_place})
    if "units" in options:
        found["units"] = tuple(read_unit(text) for text in options["units"])
    return found


def read_unit(text: str) -> tuple[int, int]:
    """Memory and number of a unit from `MEMORY,UNIT`; raises `ParameterError`."""
    parts = text.split(",")
    if len(parts) != 2 or not all(part.strip().isdecimal() for part in parts):
        raise ParameterError(f'--unit: "{text}", must be MEMORY,UNIT; write as in --unit 16,5')
    return int(parts[0]), int(parts[1])


def _silicon(silicon: SiliconChoice, warmth: float | Polyline, model: str) -> dict[str, Any]:
    """Die and temperature of a chip; refuses them where there is no silicon."""
    if model == MODELS[2]:
        die = read_die(silicon)
        if isinstance(warmth, tuple):
            course = tuple(zip(*(map(float, each) for each in warmth), strict=True))
            return {"die": die, "temperature_c": course[0][1], "course": course}
        return {"die": die, "temperature_c": warmth}
    remedy = f"--model {model} has no silicon; leave it out"
    if silicon.die is not None:
        raise ParameterError(f"--die: {silicon.die}, {remedy}")
    if warmth != ROOM_TEMPERATURE:
        raise ParameterError(f"--temperature: {silicon.temperature} degC, {remedy}")
    return {}


def _print(trace: LatencyTrace) -> None:
    s = trace.scenario
    where = ["{:.2f},{:.2f}".format(*at) for at in (trace.start, trace.flown.end)]
    print_line(f"flight from {where[0]} m to {where[1]} m")
    title = f"forest, {s.model}, {len(trace.forest.place)} obstacles, {s.max_speed:g} m/s, {s.ping_rate:g} Hz"
    print_run(title, SYSTEM, summary_of(account(trace), summarise(trace)))
    if not trace.flown.collided:
        print_line("--pings N flies on")
