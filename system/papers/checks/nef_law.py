"""The NEF chip under the full law beside its transistors: neurons alone, and a neuron with what drives it.

No figure of a paper. Dies that nothing was made from, with mismatch and process variation, at -10, 27 and 60
degC, biases fixed and from the generator:

* A neuron alone, biases as they stand for 27 degC: the model's rate over its transistors', less 1, from a
  twentieth of the highest rate that an ensemble asks for to that highest. Within 3 %.
* A neuron with two filters, lines and stages, of drawn inputs and codes, on a chip that is calibrated there:
  all of it is one circuit in the solver. Two stages may nearly cancel, so that an error of the current counts
  against the magnitudes that the neuron gets, with the leak: within 5 %. The current of the transistors is
  what the model needs for their rate. Drawn are inputs at which the model's neuron fires; one that would not
  with 5 % less is undecided. Of the decided ones 99 % must fire.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from matplotlib.figure import Figure

from chips.nef import devices
from chips.nef.chip import Conditions, NefChip
from chips.nef.circuit import chain
from chips.nef.devices import Biases, on_chip, set_tau
from circuits.arrays import F64
from circuits.blocks.drive import Wave, current_into, powered, step
from circuits.blocks.nef.encoder import bits_of
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from system.experiment import Experiment, Progress, Report
from system.papers.checks.nef_chip import nef_rate_unit, rate_errors
from system.rule import at_least, below, within
from system.statement import Statement

FIRST, DIES, CHAINS = 3400, 10, 4  # first die, and of how many neurons alone and chains are
TEMPERATURES = (-10.0, 27.0, 60.0)
KINDS: tuple[BiasKind, ...] = ("gate", "generator")
CLOSE, CURRENT_CLOSE, AGREE, UNDECIDED = 0.03, 0.05, 0.99, 0.05
TAU = 5e-3  # s, of the filters
UNHURRIED, SLOWEST = 0.5, 10.0  # share of the model's rate that is waited for, and Hz
COUNT = 3  # columns: that of the biases, which is empty, and two of signals
ON = 1e-3  # s, when the codes are set
LOWEST, HIGHEST = 0.05, 1.0  # rates of chains but for refractory periods, of the highest that is asked for
DESIGN_RATE = 400.0  # Hz, that highest at the design's speed
DRAWS = 500  # after which no input is found that fires the neuron


@dataclass(frozen=True, slots=True)
class Chain:
    """A drawn input: codes of the two stages, and x of the two filters; the current of its neuron.

    current, sunk: what the model's neuron gets, and what of it mirrors draw, thresholds; rate: the model's,
    Hz.
    """

    codes: tuple[int, int]
    inputs: tuple[float, float]
    current: float
    sunk: float
    rate: float


def told(here: Conditions, codes: tuple[int, int], inputs: tuple[float, float]) -> Chain:
    """Return what the model says of an input."""
    filters, lines, parts = here.filters(np.full(COUNT, TAU)), here.lines, list[float]()
    rest = 0.0
    if filters.curves is None:
        raise TypeError("a chip under the ideal law")
    sums = np.exp(filters.curves.at(filters.curves.output, 1.0 + np.array([0.0, *inputs])))
    for column, code in enumerate(codes, start=1):
        halves = lines.given(column, sums[column])
        rows = here.stage(0, column, np.array([[code]]))
        parts += [float(row[0] * half) for row, half in zip(rows, halves, strict=True)]
        rest += float(lines.rest * (rows[0][0] + rows[1][0]))
    current, sunk = sum(parts) + rest, -sum(min(p, 0.0) for p in parts)
    rate = float(here.law.rates(0, np.array([current]), sunk)[0])
    return Chain(codes, inputs, current, sunk, rate)


def drawn(here: Conditions, random: np.random.Generator) -> Chain:
    """Return an input at which the model's neuron fires, at a usual rate."""
    law = here.law
    fastest = DESIGN_RATE * float(law.leak[0] / law.charge[0]) / nef_rate_unit()
    for _ in range(DRAWS):
        first, second = (int(code) for code in random.integers(-255, 256, 2))
        found = told(here, (first, second), tuple(random.uniform(-0.9, 0.9, 2)))
        charging = found.rate / max(1.0 - found.rate * float(law.refractory[0]), 1e-9)
        if LOWEST * fastest < charging < HIGHEST * fastest:
            return found
    raise AssertionError("no input fires the neuron")


def gates(silicon: Silicon, biases: Biases) -> dict[str, float]:
    """Return the voltages of the lines of biases of a chain, V, by port."""
    found: dict[str, float] = {}
    made = {"neuron": devices.neurons(1), "filter": devices.filters(COUNT), "line": devices.lines(COUNT)}
    for array, circuit in made.items():
        d = on_chip(array, circuit, silicon, biases)
        found |= {port: float(np.ravel(volts)[0]) for port, volts in d.gate.items()}
    return found


def bench(here: Conditions, given: Chain) -> Testbench:
    """Return the chain of transistors with an input, whose codes are set at `ON`; it starts at rest."""
    silicon, biases = here.silicon, set_tau(here.biases, TAU)
    v_dd, waves = silicon.process.v_dd, dict[str, Wave](gates(silicon, biases))
    for column, code in enumerate((0, *given.codes)):
        for port, volts in bits_of(code, v_dd).items():
            later = port != "sign" and volts == 0.0
            waves[f"{port}[{column}]"] = step(ON, ON + 1e-6, v_dd, 0.0) if later else volts
    stop = ON + 3.5 / max(given.rate * UNHURRIED, SLOWEST) + 8e-3
    still = Testbench("NEF chain", chain(COUNT), powered(v_dd, waves), stop, watch=("spike",))
    nodes = operating_point(still, silicon).voltages()
    d = on_chip("filter", devices.filters(COUNT), silicon, biases)
    middle = d.current("mv1", d.gate["v_mid"], np.array([nodes[f"i_in[{k}]"] for k in range(COUNT)]))
    drawn_at = [(k, -float(middle[k]) * x) for k, x in enumerate(given.inputs, start=1)]
    currents = tuple(current_into(f"i_in[{k}]", more) for k, more in drawn_at)
    driven = replace(still, sources=(*still.sources, *currents))
    held = {source.node for source in driven.sources}
    start = {k: v for k, v in operating_point(driven, silicon).voltages().items() if k not in {"0", *held}}
    return replace(driven, start=start)


def chain_error(here: Conditions, given: Chain) -> float:
    """Return the error of the model's current over the magnitudes, NaN where the transistors do not fire."""
    spikes = simulate(bench(here, given), here.silicon, record=("v_mem",)).spikes["spike"]
    if spikes.size < 2:
        return float("nan")
    period = float(spikes[-1] - spikes[-2])
    law, own = here.law, np.linspace(-1.0, 1.0, 20_001)
    # the current that the model needs for that period
    magnitude = abs(given.current) + 2.0 * given.sunk + float(law.leak[0])
    rates = law.rates(0, (given.current + own * magnitude)[:, None], given.sunk)[:, 0]
    return -float(np.interp(1.0 / period, rates, own))


def decided(here: Conditions, given: Chain) -> bool:
    """Return whether the model's neuron would fire with `UNDECIDED` less of the magnitudes."""
    magnitude = abs(given.current) + 2.0 * given.sunk + float(here.law.leak[0])
    less = given.current - UNDECIDED * magnitude
    return bool(here.law.rates(0, np.array([less]), given.sunk)[0] > 0.0)


def measure(progress: Progress, dies: int = DIES, chains: int = CHAINS) -> tuple[F64, F64, F64]:
    """Return errors of rates, [conditions, dies, shares], of chains, and whether each chain is decided."""
    settings = list(product(KINDS, TEMPERATURES))
    rate = np.array([
        [rate_errors(FIRST + k, t, kind, process=ROLLS_180) for k in range(dies)] for kind, t in settings
    ])  # fmt: skip
    progress(0.5)
    random, errors = np.random.default_rng(FIRST), np.empty((2, len(settings), chains))
    for k in range(chains):
        for j, (kind, t) in enumerate(settings):
            here = NefChip(Die(number=FIRST + k), kind, {}, t, 1024, process=ROLLS_180).at(t)
            given = drawn(here, random)
            errors[0, j, k], errors[1, j, k] = chain_error(here, given), decided(here, given)
        progress(0.5 + 0.5 * (k + 1) / chains)
    return rate, errors[0], errors[1] > 0.0


def rows(rate: F64, error: F64, sure: F64) -> tuple[Statement, ...]:
    """Make the statements."""
    fires = np.isfinite(error)
    share = float(fires[sure].mean()) if sure.any() else 0.0
    worst = float(np.abs(error[fires]).max(initial=0.0))
    return (
        Statement("neuron_largest_error_of_rate", None, float(np.abs(rate).max()), within(CLOSE, of=0.0)),
        Statement("chain_largest_error_of_current", None, worst, within(CURRENT_CLOSE, of=0.0)),
        Statement("chain_decided_that_fire_share", None, share, at_least(AGREE)),
        Statement(
            "chain_undecided_share", None, 1.0 - float(sure.mean()), below(1.0, "told, below {limit:g}")
        ),
    )


def reproduce(progress: Progress) -> Report:
    """Measure neurons and chains, and compare."""
    rate, error, sure = measure(progress)
    notes = tuple(
        f"{kind} biases, {t:g} degC: rate within {np.abs(rate[j]).max():.2%}, current of a chain within"
        f" {np.nanmax(np.abs(error[j])):.2%}."
        for j, (kind, t) in enumerate(product(KINDS, TEMPERATURES))
    )
    return Report(rows(rate, error, sure), lambda figure: _draw(rate, error, figure), notes)


def _draw(rate: F64, error: F64, figure: Figure) -> None:
    left, right = figure.subplots(1, 2)
    for j, (kind, t) in enumerate(product(KINDS, TEMPERATURES)):
        left.plot(100.0 * np.abs(rate[j]).max(axis=0), "o-", label=f"{kind}, {t:g} degC")
        right.plot(np.full(error[j].size, j), 100.0 * error[j], "o")
    left.set(xlabel="share of the highest rate, from low to high", ylabel="largest error of rate, %")
    left.legend(fontsize=7)
    right.set(xlabel="condition", ylabel="error of a chain's current, %")


EXPERIMENT = Experiment("nef-law", "the NEF chip under the full law beside its transistors", reproduce)
