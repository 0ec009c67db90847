"""`noctule run rolls`: drive all neurons of a die alike, and say how they answer."""

from __future__ import annotations

from typing import Any

from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity
from system.cli.output import print_json, progress_bar
from system.cli.run_output import print_run
from system.options.block import describe_die, read_die
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.rolls.run import SYSTEM, Scenario, Trace, read_options
from system.system import Summary


def run_rolls(
    system: str, silicon: SiliconChoice, seed: int, plot: str | None, *, as_json: bool, **options: Any
) -> None:
    """Run once, print its summary; `plot` draws spikes and rates. `options` are those of its scenario."""
    if plot is not None:
        check_picture(plot)
    celsius = parse_quantity(silicon.temperature, "degC", "--temperature")
    check_temperature(celsius)
    scenario = Scenario(seed=seed, die=read_die(silicon), temperature_c=celsius, **read_options(options))
    with progress_bar(f"{system} (the first run compiles its kernels)") as progress:
        trace = SYSTEM.run(scenario, progress)
    summary = SYSTEM.summarise(trace)
    if plot is not None:
        save_picture(plot, lambda figure: SYSTEM.draw(trace, figure))
    if as_json:
        print_json(_document(system, trace, summary))
    else:
        title = f"{system}, {scenario.die}, {celsius:g} degC, {scenario.input_rate:g} events/s a neuron"
        print_run(title, SYSTEM, summary)


def _document(system: str, trace: Trace, summary: Summary) -> dict[str, Any]:
    s = trace.scenario
    return {
        "system": system,
        "bias_file": s.bias_file,
        "bias_kind": s.bias_kind,
        "temperature_C": s.temperature_c,
        **describe_die(s.die),
        "silicon_noise": s.silicon_noise,
        "seed": s.seed,
        "duration_s": s.duration,
        "input_rate_Hz": s.input_rate,
        "rates_Hz": trace.rates,
        "restless": trace.restless,
        "spike_times_s": trace.spikes.times,
        "spike_neurons": trace.spikes.neurons,
        "summary": summary,
    }
