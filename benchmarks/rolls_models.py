"""Claim: the ROLLS synapse's and neuron's behavioural models agree with their transistor circuits.

Synapse: mean output current and its waveform (rms of the difference over the peak) within 3 %, over 0 to 60
degC, both bias kinds, time constants of 1 to 100 ms, all eight levels, events at 1 to 1,000 Hz. Neuron: rate
within 5 % over 5 to 200 Hz, latency of the first spike within 5 %, silent or not on 98 % of runs, 20 dies at
27 degC and 5 each at 0 and 60 degC, both bias kinds. Dies from 1000 on, mismatch and process; the models
hold nothing fitted. The currents of a neuron are those at which the model fires at 5, 20, 70 and 200 Hz on
that die, and 3 % less and 3 % more than the first of these; a circuit that has no state of rest counts as one
that fires by itself. Of levels and rates of events every one is met on each die, not every pair. Solver of
the transistor level at rtol 1e-7 (neuron) and 1e-6 (synapse). Returns 1 where the claim is missed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from _report import Row, parser_of, report
from chips.rolls.neuron import model as rolls_neuron_model
from chips.rolls.neuron.kernel import Neurons
from chips.rolls.synapse import model as rolls_synapse_model
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.block import Block
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.circuit import BiasKind, Circuit
from circuits.errors import SolverError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL, thermal_voltage
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current
from circuits.solver.transient import Result, simulate

FIRST_DIE = 1000
KINDS: tuple[BiasKind, ...] = ("gate", "ideal")
RATES = (5.0, 20.0, 70.0, 200.0)  # Hz
SYNAPSE_ALLOWED, NEURON_ALLOWED, SILENT_ALLOWED = 0.03, 0.05, 0.98
STEP = 1e-4  # s, of the model
LONGEST = 1.0  # s, of a run that looks for the least current
EVENT_RATES = ((1.0, 2), (30.0, 4), (300.0, 30), (1000.0, 100))  # Hz, events


@dataclass(slots=True)
class Errors:
    """Relative errors of a group of runs, and how many runs agree on silence."""

    dies: set[int] = field(default_factory=set)
    rate: list[float] = field(default_factory=list)
    latency: list[float] = field(default_factory=list)
    agreeing: int = 0
    runs: int = 0


def run(block: Block, circuit: Circuit, silicon: Silicon, rtol: float, **stimuli: float | None) -> Result:
    """Transistor level of a block under its testbench."""
    values = block.defaults | stimuli
    return simulate(block.testbench(circuit, values, ROLLS_180_IDEAL.v_dd), silicon, rtol=rtol)


def spikes(neurons: Neurons, current: float, duration: float) -> F64:
    """Spike times of one model neuron after a step of current, s."""
    steps = np.full((round(duration / STEP), 1), current)
    return rolls_neuron_model.respond(neurons, steps, STEP).spikes[0]


def current_for(neurons: Neurons, rate: float) -> float:
    """Current at which the model fires at `rate`, bisected in its logarithm, A."""
    low, high = 1e-13, 1e-7
    for _ in range(24):
        middle = float(np.sqrt(low * high))
        # of the second interval, adaptation being off
        found = spikes(neurons, middle, 2.5 / rate)
        if found.size > 1 and found[1] - found[0] < 1.0 / rate:
            high = middle
        else:
            low = middle
    return high


def compare_neuron(dies: Iterable[int], temperature: float, kind: BiasKind, *, latch: bool) -> Errors:
    """All runs of one condition."""
    errors = Errors()
    circuit = rebias(rolls_neuron.build(), kind=kind)
    model = rolls_neuron_model.model_of(circuit, ROLLS_180_IDEAL)
    for die in dies:
        silicon = Silicon(ROLLS_180_IDEAL, temperature, Die(number=die))
        neurons = rolls_neuron_model.neurons_on(model, silicon, np.array([latch]))
        slow = 1.0 if latch else None
        restless = bool(rolls_neuron_model.at_rest(neurons)[0, 0] >= neurons.top[0])
        if restless:
            errors.runs += 1
            errors.agreeing += not _rests(circuit, silicon, slow)
            errors.dies.add(die)
            continue
        for current, duration in _currents(neurons):
            _add(errors, die, neurons, circuit, silicon, current, duration, slow)
    return errors


def _rests(circuit: Circuit, silicon: Silicon, slow: float | None) -> bool:
    try:
        run(rolls_neuron.BLOCK, circuit, silicon, 1e-5, current=0.0, slow=slow, duration=3e-3)
    except SolverError:
        return False
    return True


def _currents(neurons: Neurons) -> Iterator[tuple[float, float]]:
    """Currents (A) of a neuron's runs, with their durations (s)."""
    found = [current_for(neurons, rate) for rate in RATES]
    for rate, current in zip(RATES, found, strict=True):
        yield current, 4.0 / rate
    yield 0.97 * found[0], 0.5
    yield 1.03 * found[0], 0.5


def _add(
    errors: Errors, die: int, neurons: Neurons, circuit: Circuit, silicon: Silicon, current: float,
    duration: float, slow: float | None,
) -> None:  # fmt: skip
    start = rolls_neuron.STEP_TIME
    stimuli = {"current": current, "duration": start + duration, "slow": slow}
    theirs = run(rolls_neuron.BLOCK, circuit, silicon, 1e-7, **stimuli).spikes["spike"] - start
    ours = spikes(neurons, current, duration)
    errors.dies.add(die)
    errors.runs += 1
    errors.agreeing += (theirs.size > 0) == (ours.size > 0)
    if theirs.size and ours.size:
        errors.latency.append(float(ours[0] / theirs[0] - 1.0))
    if theirs.size > 1 and ours.size > 1:
        last = min(theirs.size, ours.size) - 1
        gap, other = theirs[last] - theirs[last - 1], ours[last] - ours[last - 1]
        if RATES[0] <= 1.0 / gap <= RATES[-1] * 1.05:
            errors.rate.append(float(gap / other - 1.0))


def compare_synapse(
    die: int, temperature: float, kind: BiasKind, tau: float, level: int, rate: float, events: int
) -> tuple[float, float]:
    """Relative error of the mean output current, and rms of the difference over the peak."""
    i_tau = dpi_synapse.Params().synapse_capacitance * thermal_voltage(27.0) / (ROLLS_180_IDEAL.p.kappa * tau)
    circuit = rebias(dpi_synapse.build(), {"i_etau": i_tau, "i_itau": i_tau}, kind)
    silicon = Silicon(ROLLS_180_IDEAL, temperature, Die(number=die))
    stimuli = {"level": float(level), "events": float(events), "rate": rate}
    theirs = run(dpi_synapse.BLOCK, circuit, silicon, 1e-6, **stimuli)
    expected = np.abs(drain_current(theirs, "excitatory.md5" if level > 0 else "inhibitory.md7"))
    model = rolls_synapse_model.model_of(circuit, ROLLS_180_IDEAL)
    times = [dpi_synapse.FIRST_EVENT + k / rate for k in range(events)]
    found = rolls_synapse_model.respond(
        rolls_synapse_model.synapses_on(model, silicon, level), times, theirs.time
    )[0]
    mean = float(np.trapezoid(found, theirs.time) / np.trapezoid(expected, theirs.time) - 1.0)
    square = np.trapezoid((found - expected) ** 2, theirs.time) / theirs.time[-1]
    return mean, float(np.sqrt(square) / expected.max())


def synapse_rows(*, quick: bool) -> list[Row]:
    """Worst errors of the synapse over the box."""
    levels = (1, 2, 3, 4, -1, -2, -3, -4)
    found = []
    count = 0
    for temperature in (27.0, 0.0, 60.0):
        for kind in KINDS:
            for die in range(FIRST_DIE, FIRST_DIE + (2 if quick else 5)):
                for tau in (1e-3, 1e-2, 1e-1):
                    # every level and every rate on each die, in turn and not every pair of them
                    for j, (rate, events) in enumerate(EVENT_RATES):
                        chosen = (
                            levels[(count + 3 * j) % 8 :: 8] if quick else levels[(count + 3 * j) % 4 :: 4]
                        )
                        found += [
                            compare_synapse(die, temperature, kind, tau, x, rate, events) for x in chosen
                        ]
                    count += 1
    mean, rms = (np.abs([f[k] for f in found]) for k in (0, 1))
    return [
        _worst(f"synapse, {name}", x, SYNAPSE_ALLOWED, 2 if quick else 5)
        for name, x in (("mean current", mean), ("waveform, rms over peak", rms))
    ]


def _worst(name: str, errors: F64, allowed: float, dies: int) -> Row:
    """The largest of relative errors, with their median."""
    worst = float(np.abs(errors).max())
    note = f"median {np.median(np.abs(errors)):.2%}, {errors.size} runs, {dies} dies"
    return Row(name, worst, None, worst, note, most=allowed)


def neuron_rows(*, quick: bool) -> list[Row]:
    """Worst errors of the neuron at each temperature, with each leak."""
    rows: list[Row] = []
    for latch in (False, True):
        for temperature, dies in (
            (27.0, 3 if quick else 20),
            (0.0, 1 if quick else 5),
            (60.0, 1 if quick else 5),
        ):
            groups = [
                compare_neuron(range(FIRST_DIE, FIRST_DIE + dies), temperature, kind, latch=latch)
                for kind in KINDS
            ]
            name = f"neuron, {'tau1' if latch else 'tau2'}, {temperature:g} degC"
            for label, values in (
                ("rate", [e for g in groups for e in g.rate]),
                ("latency", [e for g in groups for e in g.latency]),
            ):
                if values:
                    rows.append(_worst(f"{name}, {label}", np.array(values), NEURON_ALLOWED, dies))
            agreeing, runs = (sum(getattr(g, key) for g in groups) for key in ("agreeing", "runs"))
            share, note = agreeing / runs, f"{runs} runs, {dies} dies"
            rows.append(Row(f"{name}, silent or not", share, None, share, note, least=SILENT_ALLOWED))
    return rows


def main() -> int:
    """Compare both levels and print all rows."""
    options = parser_of(__doc__, "fewer dies, and a part of the box").parse_args()
    rows = synapse_rows(quick=options.quick) + neuron_rows(quick=options.quick)
    return report(rows, options, lambda row: f"{row.ours:9.2%}")


if __name__ == "__main__":
    sys.exit(main())
