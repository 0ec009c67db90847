"""`noctule run approach`: the sonar in its world, and any system with a scenario like its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity
from system.approach.trace import LAWS, LEVELS, Scenario, Trace
from system.cli.output import print_json, print_line, progress_bar
from system.cli.run_output import print_run
from system.options.block import describe_die, read_die
from system.options.noise import NOISY
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.registry import load_system
from system.system import Summary
from system.worlds.sound.targets import default_scene, describe, read_targets


def run_approach(
    system: str,
    silicon: SiliconChoice,
    seed: int,
    plot: str | None,
    *,
    as_json: bool,
    targets: str | None = None,
    level: str | None = None,
    transistors: Sequence[str] = (),
    isolation: bool = True,
    amplitude_law: str | None = None,
    duration: str | None = None,
    noise: str | None = None,
    silicon_noise: str | None = None,
) -> None:
    """Run `system` and print its arrays and summary; `plot` draws it."""
    if plot is not None:
        check_picture(plot)
    loaded = load_system(system)
    scenario = scenario_of(targets, isolation, amplitude_law, duration, silicon, seed, noise)
    boxes: Any = frozenset(transistors)
    at: Any = level or LEVELS[0]
    noisy: Any = silicon_noise or NOISY[0]
    scenario = replace(scenario, level=at, transistors=boxes, silicon_noise=noisy)
    with progress_bar(f"{system} (the first run compiles its kernels)") as progress:
        trace: Trace = loaded.run(scenario, progress)
    summary = loaded.summarise(trace)
    if plot is not None:
        save_picture(plot, lambda figure: loaded.draw(trace, figure))
    if as_json:
        print_json(_document(system, trace, summary))
        return
    for target in scenario.targets:
        print_line(describe(target))
    title = f"{system}, {scenario.level} level, {scenario.temperature_c:g} degC, {scenario.die}"
    print_run(title, loaded, summary)


def scenario_of(
    targets: str | None,
    isolation: bool,
    amplitude_law: str | None,
    duration: str | None,
    silicon: SiliconChoice,
    seed: int,
    noise: str | None,
) -> Scenario:
    """Scenario from the command line's texts; raises `ParameterError` or `DataError` naming the option."""
    celsius = parse_quantity(silicon.temperature, "degC", "--temperature")
    check_temperature(celsius)
    law: Any = amplitude_law or LAWS[0]
    length = parse_quantity(duration or "4s", "s", "--duration")
    rms = parse_quantity(noise or "0V", "V", "--noise")
    scene = default_scene() if targets is None else read_targets(targets)
    return Scenario(scene, length, celsius, isolation, law, rms, seed, read_die(silicon))


def _document(system: str, trace: Trace, summary: Summary) -> dict[str, Any]:
    scenario = trace.scenario
    arrays = ("time_s", "range_m", "estimate_m", "proximity_V", "call_rate_Hz", "call_amplitude_V")
    return {
        "system": system,
        "level": scenario.level,
        "transistors": sorted(scenario.transistors),
        "temperature_C": scenario.temperature_c,
        **describe_die(scenario.die),
        "isolation": scenario.isolation,
        "amplitude_law": scenario.amplitude_law,
        "noise_rms_V": scenario.noise_rms,
        "silicon_noise": scenario.silicon_noise,
        "noisy_boxes": scenario.noisy_boxes,
        "seed": scenario.seed,
        "targets": [t.name for t in scenario.targets],
        **{name: getattr(trace, name) for name in arrays},
        "calls_s": trace.calls[:, 0],
        "pulses_s": trace.pulses,
        "echoes_s": trace.echoes,
        "spikes": [{"time_s": time, "neuron": neuron} for time, neuron in trace.spikes],
        "summary": {**summary, **trace.counts},
    }
