"""The NEF chip under the full law beside its transistors: neurons alone, and neurons with what drives them.

No figure of a paper. Twenty dies that nothing was made from, with mismatch and process variation, at -10, 27
and 60 degC, biases fixed and from the generator:

* A neuron alone, biases as they stand for 27 degC: the model's rate over its transistors', less 1, from a
  twentieth of the highest rate that an ensemble asks for to that highest. Within 3 %.
* A neuron as a network has it, on a chip that is calibrated there: codes of its bias and of two dimensions
  are those of an ensemble's neuron, whose encoder, intercept and highest rate are drawn, and filters stand
  where a point of the ensemble's circle brings them. Neuron, stages, lines and filters are one circuit in the
  solver.

Of the latter, which make more than 500 cases,

* 99 % of those that are decided fire, or are silent for two seconds, as the model says. A neuron is decided
  unless its current is within `SURE` of the least that fires it, twice the rms error of the model on dies
  10 to 12; undecided are less than 2 %.
* The current is within 5 %: what the model needs for the transistors' rate. Two stages may nearly cancel, so
  that an error counts against the magnitudes that the neuron gets from them and its bias, with the leak.
* Where most of a period is refractory, it says little of a current. The rate itself is within 3 % there.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from matplotlib.figure import Figure

from chips.nef import devices
from chips.nef.chip import HEADROOM, Conditions, NefChip
from chips.nef.circuit import chain
from chips.nef.devices import Biases, on_chip, set_tau
from chips.nef.network.network import Ensemble
from chips.nef.population import populate
from chips.record import content, record_key
from circuits.arrays import F64
from circuits.blocks.drive import Wave, current_into, powered, step
from circuits.blocks.nef.encoder import bits_of
from circuits.circuit import BiasKind
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner
from circuits.solver.version import VERSION
from circuits.testbench import Testbench
from system.experiment import Experiment, Progress, Report, with_progress
from system.papers.checks.beside import (
    ALIKE,
    ENOUGH,
    KINDS,
    NEAR,
    TEMPERATURES,
    TIED,
    TIME_SHARE,
    Condition,
    conditions,
)
from system.papers.checks.nef_chip import rate_errors
from system.rule import at_least, at_most
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution

FIRST, DIES, CASES = 3400, 20, 5  # first die, dies, and neurons of a network on each
CURRENT_SHARE = 0.05  # by which a current may be off; ours
SURE = 0.016  # of the magnitudes: twice 0.8 %
TAU = 5e-3  # s, of the filters
COUNT = 3  # columns: that of the bias, and two of signals
SAMPLED = 256  # neurons of the chip, by which it is calibrated
ON = 1e-3  # s, when the codes are set
WATCHED = 2.0  # s, without a spike in which a neuron is silent
SPIKES = 3  # after which no more are waited for
MOSTLY = 0.5  # of a period that is refractory, beyond which the rate is compared


@dataclass(frozen=True, slots=True)
class Chain:
    """A neuron of a network, as the model has it.

    codes: of the stages of its bias and of two signals; inputs: s of their filters, float64[columns];
    current, sunk: what it gets, and what of it mirrors draw, thresholds; magnitude: of what stages and leak
    bring, thresholds; spare: how far the current is above the least that fires it, over the magnitude; rate:
    Hz.
    """

    codes: tuple[int, ...]
    inputs: F64
    current: float
    sunk: float
    magnitude: float
    spare: float
    rate: float

    @property
    def decided(self) -> bool:
        """Whether the model is sure that it fires, or that it is silent."""
        return abs(self.spare) > SURE


@dataclass(frozen=True, slots=True)
class Beside:
    """A neuron on both levels: whether it fires in the circuit, and the errors of current and of rate.

    Errors are None where it does not fire on both levels; refractory: whether most of its period is.
    """

    kind: BiasKind
    temperature_c: float
    model: Chain
    fires: bool
    current: float | None
    rate: float | None
    refractory: bool


def chains(here: Conditions, count: int, seed: int) -> Iterator[Chain]:
    """Yield neurons as an ensemble of two dimensions has them; seed: of the ensemble and of its points."""
    random = np.random.default_rng(seed)
    some = populate(Ensemble("x", count, 2), here, 0, seed, np.zeros((1, 2)))
    bias = here.bias_codes(some.bias)
    rows = [here.codes(row, HEADROOM, 1)[0] for row in (some.encoders * some.gain[:, None]).T]
    middle = here.filters(np.full(COUNT, TAU)).scale_for(here.lines.zero[:COUNT])
    for codes in np.stack([bias, *rows], axis=1):
        angle, length = random.uniform(0.0, 2.0 * np.pi), np.sqrt(random.uniform())
        point = np.array([0.0, length * np.cos(angle), length * np.sin(angle)])
        yield told(here, tuple(int(code) for code in codes), middle * (1.0 + point / HEADROOM))


def told(here: Conditions, codes: tuple[int, ...], inputs: F64) -> Chain:
    """Return what the model says of a neuron; arguments as of `Chain`."""
    law, curves = here.law, here.filters(np.full(COUNT, TAU)).curves
    if curves is None:
        raise TypeError("a chip under the ideal law")
    sums, stages = np.exp(curves.at(curves.output, inputs)), [np.array([code]) for code in codes]
    standing, turned = here.standing(0, stages[0], stages[1:])
    parts = [
        float(row[0] * half)
        for column in range(1, COUNT)
        for row, half in zip(
            here.stage(0, column, stages[column][None]), here.lines.given(column, sums[column]), strict=True
        )
    ]
    mirrored = -sum(min(part, 0.0) for part in parts)
    current, sunk = np.array([standing[0] + sum(parts)]), np.array([turned[0] + mirrored])
    bias = float(here.bias(0, stages[0])[0])
    magnitude = abs(float(current[0])) + 2.0 * (mirrored + max(-bias, 0.0)) + float(law.leak[0])
    spare, rate = (float(f(0, current, sunk)[0]) for f in (law.spare, law.rates))
    return Chain(codes, inputs, float(current[0]), float(sunk[0]), magnitude, spare / magnitude, rate)


def gates(silicon: Silicon, biases: Biases) -> dict[str, float]:
    """Return the voltages of the lines of biases of a chain, V, by port; column 0 has that of biases."""
    found: dict[str, float] = {}
    made = {"neuron": devices.neurons(1), "filter": devices.filters(COUNT), "line": devices.lines(COUNT)}
    for array, circuit in made.items():
        d = on_chip(array, circuit, silicon, biases)
        found |= {port: float(np.ravel(volts)[0]) for port, volts in d.gate.items()}
    stage = on_chip("stage", devices.column(1), silicon, biases, ("md0",), (("column", (0,)),))
    return found | {"v_pos[0]": float(np.ravel(stage.gate["v_pos"])[0]), "v_neg[0]": silicon.process.v_dd}


def bench(here: Conditions, given: Chain) -> Testbench:
    """Return the transistors of a neuron, whose codes are set at `ON`; it starts at rest."""
    silicon, biases = here.silicon, set_tau(here.biases, TAU)
    v_dd, waves = silicon.process.v_dd, dict[str, Wave](gates(silicon, biases))
    for column, code in enumerate(given.codes):
        for port, volts in bits_of(code, v_dd).items():
            later = port != "sign" and volts == 0.0
            waves[f"{port}[{column}]"] = step(ON, ON + 1e-6, v_dd, 0.0) if later else volts
    still = Testbench("NEF chain", chain(COUNT), powered(v_dd, waves), WATCHED, watch=("spike",))
    nodes = operating_point(still, silicon).voltages()
    d = on_chip("filter", devices.filters(COUNT), silicon, biases)
    middle = d.current("mv1", d.gate["v_mid"], np.array([nodes[f"i_in[{k}]"] for k in range(COUNT)]))
    drawn = -middle * (given.inputs - 1.0)
    currents = tuple(current_into(f"i_in[{k}]", float(drawn[k])) for k in range(1, COUNT))
    driven = replace(still, sources=(*still.sources, *currents))
    held = {source.node for source in driven.sources}
    start = {k: v for k, v in operating_point(driven, silicon).voltages().items() if k not in {"0", *held}}
    return replace(driven, start=start)


def spikes_of(here: Conditions, given: Chain) -> F64:
    """Return the first spikes of a neuron's transistors, s, fewer than `SPIKES` if they take too long."""
    machine = to_kernel(bench(here, given), here.silicon)
    run = Runner(machine)
    state, found = run.begin(operating_point(machine)), list[float]()
    while len(found) < SPIKES:
        state, segment = run.advance(state, WATCHED)
        if not segment.spikes:
            break
        found += [time for _, time in segment.spikes]
    return np.array(found)


def beside(here: Conditions, given: Chain) -> Beside:
    """Return a neuron on both levels."""
    spikes, kind, law = spikes_of(here, given), here.chip.bias_kind, here.law
    fires = spikes.size > 1
    if not (fires and given.rate):
        return Beside(kind, here.temperature_c, given, fires, None, None, refractory=False)
    period = float(spikes[-1] - spikes[-2])
    shares = np.linspace(-1.0, 1.0, 20_001)
    # the current that the model needs for that period
    rates = law.rates(0, (given.current + shares * given.magnitude)[:, None], np.array(given.sunk))[:, 0]
    off = -float(np.interp(1.0 / period, rates, shares))
    mostly = float(law.refractory[0]) > MOSTLY / given.rate
    return Beside(kind, here.temperature_c, given, fires, off, given.rate * period - 1.0, mostly)


@dataclass(frozen=True, slots=True)
class OnDie:
    """What a die has at a temperature with a kind of biases.

    rate : errors of the rate of a neuron alone, float64[shares]; networks : neurons of networks.
    """

    rate: F64
    networks: tuple[Beside, ...]


def on_die(at: Condition) -> OnDie:
    """Return a neuron alone and neurons of networks on a die, at both levels."""
    rate = rate_errors(at.die, at.temperature_c, at.kind, process=ROLLS_180)
    chip = NefChip(Die(number=at.die), at.kind, {}, at.temperature_c, SAMPLED, process=ROLLS_180)
    here = chip.at(at.temperature_c)
    return OnDie(np.array(rate), tuple(beside(here, given) for given in chains(here, CASES, at.die)))


def rows(rate: F64, found: list[Beside]) -> tuple[Statement, ...]:
    """Make the statements."""
    decided = [b for b in found if b.model.decided]
    alike = sum(b.fires == (b.model.rate > 0.0) for b in decided) / max(len(decided), 1)
    current, other = (_largest([b for b in found if b.refractory == which]) for which in (False, True))
    named = (
        ("neuron_largest_error_of_rate", float(np.abs(rate).max()), NEAR),
        ("chain_cases", float(len(found)), at_least(ENOUGH)),
        ("chain_decided_as_the_circuit_share", alike, ALIKE),
        ("chain_undecided_share", 1.0 - len(decided) / len(found), TIED),
        ("chain_largest_error_of_current", current[0], at_most(CURRENT_SHARE)),
        ("chain_mostly_refractory_largest_error_of_rate", other[1], NEAR),
    )
    return tuple(Statement(name, None, value, rule) for name, value, rule in named)


def _largest(found: list[Beside]) -> tuple[float, float]:
    """Largest errors of current and of rate of neurons that fire on both levels."""
    errors = np.abs(np.array([(b.current, b.rate) for b in found if b.rate is not None]).reshape(-1, 2))
    current, rate = errors.max(axis=0, initial=0.0)
    return float(current), float(rate)


def run(progress: Progress, execution: Execution = ALONE, dies: int = DIES) -> Report:
    """Measure neurons alone and in networks on dies from `FIRST` on, and compare."""
    made_of = record_key(content(chain(COUNT)), TAU, CASES, SAMPLED, WATCHED)
    campaign = Campaign("nef-law", on_die, Condition, OnDie, (VERSION, made_of))
    keys = conditions(range(FIRST, FIRST + dies))
    with closing(execution.results(campaign, keys)) as results:
        each = [next(results) for _ in with_progress(keys, progress)]
    # conditions come die after die; rows are of conditions
    rate = np.stack([e.rate for e in each]).reshape(dies, len(KINDS) * len(TEMPERATURES), -1).swapaxes(0, 1)
    found = [b for e in each for b in e.networks]
    return Report(rows(rate, found), lambda figure: _draw(rate, found, figure), tuple(_notes(rate, found)))


def _notes(rate: F64, found: list[Beside]) -> Iterator[str]:
    """Yield a line a condition."""
    for j, (kind, t) in enumerate(product(KINDS, TEMPERATURES)):
        own = [b for b in found if (b.kind, b.temperature_c) == (kind, t)]
        free, mostly = (_largest([b for b in own if b.refractory == which]) for which in (False, True))
        fire, unsure = sum(b.fires for b in own), sum(not b.model.decided for b in own)
        yield (
            f"{kind} biases, {t:g} degC: rate alone within {np.abs(rate[j]).max():.2%}; of {len(own)} neurons"
            f" {fire} fire and {unsure} are undecided, current within {free[0]:.2%}, rate where most is"
            f" refractory within {mostly[1]:.2%}."
        )


def _draw(rate: F64, found: list[Beside], figure: Figure) -> None:
    left, right = figure.subplots(1, 2)
    for j, (kind, t) in enumerate(product(KINDS, TEMPERATURES)):
        left.plot(100.0 * np.abs(rate[j]).max(axis=0), "o-", label=f"{kind}, {t:g} degC")
        own = [b for b in found if (b.kind, b.temperature_c) == (kind, t) and not b.refractory]
        points = [(b.model.spare, b.current) for b in own if b.current is not None]
        right.plot(*100.0 * np.array(points).reshape(-1, 2).T, ".")
    left.axhline(100.0 * TIME_SHARE, color="grey", lw=0.8)
    left.set(xlabel="share of the highest rate, from low to high", ylabel="largest error of rate, %")
    left.legend(fontsize=7)
    right.set(xlabel="current above the least that fires, % of magnitudes", ylabel="error of the current, %")


EXPERIMENT = Experiment(
    "nef-law", "the NEF chip under the full law beside its transistors", run, {"dies": DIES}
)
