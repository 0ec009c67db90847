"""`noctule run forest`: fly through a forest until a collision, and say how many obstacles were avoided."""

from __future__ import annotations

from typing import Any

from chips.selection.model import selection_errors
from circuits.errors import ParameterError
from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity
from system.cli.output import print_json, print_line, progress_bar
from system.cli.run_forest_latency import run_latency
from system.cli.run_output import print_run
from system.forest.animation import check_animation, save_animation
from system.forest.run import SYSTEM, Scenario, Trace, read_options
from system.openspace.senses import Sensing
from system.options.block import describe_die, read_die
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.spiking_bat.run import MODELS
from system.system import Summary


def run_forest(
    system: str,
    silicon: SiliconChoice,
    seed: int,
    plot: str | None,
    *,
    as_json: bool,
    animate: str | None = None,
    **options: Any,
) -> None:
    """Run one sample, print its summary; `plot` and `animate` draw its first run.

    `options` are those of its scenario, and `model`, of the bat's mind.
    """
    if plot is not None:
        check_picture(plot)
    if animate is not None:
        check_animation(animate)
    options = _checked_model(options)
    if "model" in options:
        if animate is not None:
            raise ParameterError(f"--animate: {animate}, not with --model {options['model']}; use --plot")
        run_latency(silicon, seed, plot, as_json=as_json, **options)
        return
    celsius = parse_quantity(silicon.temperature, "degC", "--temperature")
    check_temperature(celsius)
    fields = read_options(options)
    _check_silicon(silicon, fields["sensing"])
    scenario = Scenario(seed=seed, die=read_die(silicon), temperature_c=celsius, **fields)
    with progress_bar(f"{system} (the first run compiles its kernels)") as progress:
        trace = SYSTEM.run(scenario, progress)
    summary = SYSTEM.summarise(trace)
    if plot is not None:
        save_picture(plot, lambda figure: SYSTEM.draw(trace, figure))
    if animate is not None:
        save_animation(animate, trace)
    if as_json:
        print_json(_document(system, trace, summary))
    else:
        _print(system, trace, summary)


def _checked_model(options: dict[str, Any]) -> dict[str, Any]:
    """Options, without the model where it is the analog one; refuses what only other models have."""
    model = options.get("model", MODELS[0])
    if model not in MODELS:
        raise ParameterError(f"--model: {model}, must be {', '.join(MODELS[:-1])} or {MODELS[-1]}")
    if model != MODELS[0]:
        return options
    for name in ("paths", "taps", "codes", "units"):
        if name in options:
            shown = "unit" if name == "units" else name.replace("_", "-")
            raise ParameterError(f"--{shown}: {options[name]}, the analog model has none; choose --model")
    return {name: value for name, value in options.items() if name != "model"}


def _check_silicon(silicon: SiliconChoice, sensing: Sensing) -> None:
    """Refuse a die where there is no silicon."""
    if silicon.die is not None and not sensing.silicon:
        raise ParameterError(
            f"--die: {silicon.die}, no chip is in the loop; give --ranges chip or --selection chip"
        )


def _document(system: str, trace: Trace, summary: Summary) -> dict[str, Any]:
    s, log = trace.scenario, trace.first.log
    return {
        "system": system,
        "map": s.map,
        "obstacles": len(trace.first.forest.place),
        "max_speed_m_per_s": s.bat.max_speed,
        "ping_rate_Hz": s.bat.ping_rate,
        **_of_senses(s),
        "zone_m": s.bat.zone,
        "seed": s.seed,
        "start_m": trace.first.start,
        "ended": summary["reason"],
        "obstacles_m": trace.first.forest.place,
        "time_s": log[:, 0],
        "path_m": trace.path,
        "heading_rad": log[:, 3],
        "ping_direction": log[:, 4].astype(int),
        "arc": log[:, 5].astype(int),
        "scanning": log[:, 7].astype(bool),
        "summary": summary,
    }


def _of_senses(scenario: Scenario) -> dict[str, Any]:
    sensing = scenario.sensing
    found = {
        "ranges": sensing.ranges,
        "selection": sensing.selection,
        "silicon_noise": sensing.silicon_noise,
        "azimuth_noise_rad": sensing.azimuth_noise,
        "ping_bias": scenario.bat.ping_bias,
        "immediacy_range_m": scenario.bat.immediacy_range,
    }
    if sensing.silicon:
        found |= {
            "reader": sensing.reader,
            "area": sensing.ranging_area,
            "temperature_C": scenario.temperature_c,
            **describe_die(scenario.die),
        }
    if sensing.selection == "chip":
        found["selection_errors"] = dict(selection_errors())
    return found


def _print(system: str, trace: Trace, summary: Summary) -> None:
    first, bat, sensing = trace.first, trace.scenario.bat, trace.scenario.sensing
    where = f"{first.start[0]:.2f},{first.start[1]:.2f} m"
    print_line(f"first of {trace.sample.runs} runs from {where} to {first.end[0]:.2f},{first.end[1]:.2f} m")
    title = f"{system}, {len(first.forest.place)} obstacles, {bat.max_speed:g} m/s, {bat.ping_rate:g} Hz"
    title += f", ranges {sensing.ranges}, selection {sensing.selection}"
    print_run(title, SYSTEM, summary)
    if sensing.ranges == "chip":
        print_line("the chip gives ranges only: azimuths are the true ones, with --azimuth-noise if any")
    if not trace.sample.collided:
        print_line("--pings N flies on")
