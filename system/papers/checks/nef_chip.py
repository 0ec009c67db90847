"""The NEF chip beside its circuit, and what its ensembles represent.

No figure of a paper. Three things are measured, and each is compared with a limit of ours:

* The rate of a neuron in the model is compared with that of its transistors, for neurons of 20 dies that
  nothing was made from, at 0, 27 and 60 degC with both kinds of biases, each fixed at 27 degC. Used are rates
  from a twentieth of the highest that an ensemble asks for to that highest, at the die's own speed (gate
  biases make a cold chip slow). They must be within 3 %.
* The error of representation is the rms over time of a decoded number, with spikes filtered by 20 ms, about
  what it is on average, and of that average about the number, together. Its slope over 50 to 1,000 neurons
  must be -0.5 +- 0.1.
* A die's own decoders are compared with those of another die, by the rms of what 500 neurons represent on
  average: they must be at least three times better in the median of 20 pairs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from chips.nef.build import Built, build, exchanged
from chips.nef.chip import NefChip
from chips.nef.devices import PLACE
from chips.nef.model import neurons_on
from chips.nef.network.network import Connection, Ensemble, Network, Node, Probe
from chips.nef.simulation import Simulation
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.nef import neuron as nef_neuron
from circuits.blocks.nef.neuron import LEAK
from circuits.circuit import BiasKind
from circuits.place import bias_path
from circuits.silicon.components import Extent
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from system.experiment import Experiment, Progress, Report
from system.rule import at_least, within
from system.statement import Statement

FIRST, DIES = 3000, 20
TEMPERATURES = (0.0, 27.0, 60.0)
KINDS: tuple[BiasKind, ...] = ("gate", "ideal")
SHARES = (0.05, 0.1, 0.25, 0.5, 1.0)  # of the highest rate
HIGHEST = 400.0  # Hz, of the design at 27 degC
CLOSE = 0.03
SIZES = (50, 100, 200, 400, 700, 1000)
SLOPE, SLOPE_TOLERANCE = -0.5, 0.1
FILTER, SETTLING, WATCHED = 0.02, 0.2, 0.5  # s
SPREAD = 9  # numbers that are represented one after the other
PAIRS, PAIR_NEURONS, WORSE = 20, 500, 3.0


@dataclass(frozen=True, slots=True)
class Found:
    """What was measured.

    rate: relative errors, float64[kinds, temperatures, dies, shares]; error: rms, float64[sizes, dies]; own,
    other: rms with a die's own and with another's decoders, float64[pairs] each.
    """

    rate: F64
    error: F64
    own: F64
    other: F64


def rate_errors(
    die: int, temperature: float, kind: BiasKind, shares: tuple[float, ...] = SHARES,
    process: Process = ROLLS_180_IDEAL, variation: Extent = "plain",
) -> F64:  # fmt: skip
    """Rates of the model over those of the transistor circuit, less 1, of the chip's neuron number `die`."""
    number, silicon = die % 4096, Silicon(process, temperature, Die(number=die, variation=variation))
    circuit = rebias(nef_neuron.build(), {}, kind)
    # the biases' copies are the chip's
    biases = tuple(replace(b, place=(*PLACE, *bias_path(b.port, ()))) for b in circuit.biases)
    circuit = replace(circuit, biases=biases)
    law = neurons_on(silicon, number + 1, circuit.biases)
    speed = law.leak[number] / (law.charge[number] * nef_rate_unit())
    highest = HIGHEST * speed
    there = replace(silicon, place=(*PLACE, ("neuron", (number,))))
    found = []
    for share in shares:
        rate = share * highest / (1.0 + share * highest * law.refractory[number])
        current = law.leak[number] + law.charge[number] / (1.0 / rate - law.refractory[number])
        stimuli = {"current": current * LEAK, "duration": 3.5 / rate + 2.0 * nef_neuron.STEP_TIME}
        bench = nef_neuron.testbench(circuit, stimuli, ROLLS_180_IDEAL.v_dd)
        spikes = simulate(bench, there, record=("v_mem",)).spikes["spike"]
        told = float(law.rates(number, np.array([current]))[0])
        found.append(told * float(spikes[-1] - spikes[-2]) - 1.0)
    return np.array(found)


def nef_rate_unit() -> float:
    """Give the leak over the charge of the nominal neuron at 27 degC, 1/s."""
    law = neurons_on(Silicon(ROLLS_180_IDEAL), 1, nef_neuron.BIASES)
    return float(law.leak[0] / law.charge[0])


def represented(built: Built, numbers: F64) -> tuple[F64, F64]:
    """Give mean and variance over time of what is decoded of each number, float64[numbers] each."""
    run = Simulation(built, 1e-3)
    mean, variance = [], []
    for x in numbers:
        run.set("in", x)
        run.advance(SETTLING)
        seen = []
        for _ in range(round(WATCHED / 1e-3)):
            run.advance(1e-3)
            seen.append(run.read("x?")[0])
        mean.append(np.mean(seen))
        variance.append(np.var(seen))
    return np.array(mean), np.array(variance)


def one_ensemble(neurons: int) -> Network:
    """Build an ensemble of a number, what brings it and what reads it."""
    return Network(
        (Ensemble("x", neurons),),
        (Node("in", 1),),
        (Connection("in", "x"),),
        (Probe("x?", "x", synapse=FILTER),),
    )


def paper_chip(die: int) -> NefChip:
    """Make the chip of a die without second-order effects, at fixed gates."""
    return NefChip(Die(number=die), "gate", process=ROLLS_180_IDEAL)


def error(neurons: int, die: int) -> float:
    """Give the rms error of what an ensemble on a die represents, from filtered spikes."""
    numbers = np.linspace(-0.9, 0.9, SPREAD)
    built = build(one_ensemble(neurons), paper_chip(die).at(27.0), die)
    mean, variance = represented(built, numbers)
    return float(np.sqrt((variance + (mean - numbers) ** 2).mean()))


def own_and_other(die: int) -> tuple[float, float]:
    """Give the rms of the mean that is represented, with decoders of this die and of the next one."""
    numbers = np.linspace(-0.9, 0.9, SPREAD)
    network = one_ensemble(PAIR_NEURONS)
    own, other = (build(network, paper_chip(d).at(27.0), FIRST) for d in (die, die + 1))
    found = []
    for built in (own, exchanged(own, other)):
        mean, _ = represented(built, numbers)
        found.append(float(np.sqrt(((mean - numbers) ** 2).mean())))
    return found[0], found[1]


def measure(
    progress: Progress, dies: int = DIES, sizes: tuple[int, ...] = SIZES, pairs: int = PAIRS
) -> Found:
    """Measure neurons, ensembles and decoders."""
    rate = np.empty((len(KINDS), len(TEMPERATURES), dies, len(SHARES)))
    for i, kind in enumerate(KINDS):
        for j, temperature in enumerate(TEMPERATURES):
            for k in range(dies):
                rate[i, j, k] = rate_errors(FIRST + k, temperature, kind)
    progress(1.0 / 3.0)
    few = max(dies // 2, 1)
    errors = np.array([[error(n, FIRST + k) for k in range(few)] for n in sizes])
    progress(2.0 / 3.0)
    both = np.array([own_and_other(FIRST + 2 * k) for k in range(pairs)])
    progress(1.0)
    return Found(rate, errors, both[:, 0], both[:, 1])


def slope(errors: F64, sizes: tuple[int, ...] = SIZES) -> float:
    """Give the slope of the logarithm of the rms over dies against that of the number of neurons."""
    rms = np.sqrt((errors**2).mean(axis=1))
    return float(np.polyfit(np.log(sizes), np.log(rms), 1)[0])


def rows(found: Found, sizes: tuple[int, ...] = SIZES) -> tuple[Statement, ...]:
    """Make the statements about rates, errors and decoders."""
    worst, steep = float(np.abs(found.rate).max()), slope(found.error, sizes)
    times = float(np.median(found.other / found.own))
    return (
        Statement("largest_error_of_rate", None, worst, within(CLOSE, of=0.0)),
        Statement("slope_of_error_over_neurons", SLOPE, steep, within(SLOPE_TOLERANCE)),
        Statement("other_dies_decoders_over_own_rms", None, times, at_least(WORSE)),
    )


def reproduce(progress: Progress) -> Report:
    """Measure neurons, ensembles and decoders, and compare."""
    found = measure(progress)
    by = [
        f"{kind} biases, {t:g} degC: error of rate {np.abs(found.rate[i, j]).max():.2%} at most,"
        f" {np.sqrt((found.rate[i, j] ** 2).mean()):.2%} rms."
        for i, kind in enumerate(KINDS)
        for j, t in enumerate(TEMPERATURES)
    ]
    least = float((found.other / found.own).min())
    by.append(f"decoders: own {found.own.mean():.3g} rms, the other die's {found.other.mean():.3g};")
    by.append(f"least ratio of a pair {least:.3g}.")
    return Report(rows(found), lambda figure: _draw(found, figure), tuple(by))


def _draw(found: Found, figure: Figure) -> None:
    figure.set_size_inches(9.6, 3.6)
    left, middle, right = figure.subplots(1, 3)
    for i, kind in enumerate(KINDS):
        for j, t in enumerate(TEMPERATURES):
            left.plot(
                SHARES, 100.0 * np.abs(found.rate[i, j]).max(axis=0), "o-"[i:], label=f"{kind}, {t:g} degC"
            )
    left.set(xscale="log", xlabel="share of the highest rate", ylabel="largest error of rate, %")
    left.legend(fontsize=7)
    rms = np.sqrt((found.error**2).mean(axis=1))
    middle.loglog(SIZES, found.error, ".", color="0.7")
    middle.loglog(SIZES, rms, "o-", label=f"slope {slope(found.error):.2f}")
    middle.set(xlabel="neurons", ylabel="rms error")
    middle.legend(fontsize=8)
    right.loglog(found.own, found.other, "o")
    low, high = found.own.min(), found.own.max()
    right.loglog([low, high], [WORSE * low, WORSE * high], "-", color="0.6", label=f"{WORSE:g} times")
    right.set(xlabel="rms, own decoders", ylabel="rms, another die's")
    right.legend(fontsize=8)


EXPERIMENT = Experiment(
    "nef-chip",
    "neurons of the NEF chip beside their circuit, errors, decoders",
    reproduce,
)
