"""What the full law moves in a ROLLS chip: each effect by itself, and all together.

No figure of a paper. The nominal die at 27 degC with fixed gates, whose voltages are those that the currents
of the default codes need under the same law, by the chip's own tables (`chips.rolls.tables`). In these rows
`paper` is the number under the ideal law and the rule tells how far the full law moves it; none passes or
fails. The picture has each effect alone: body effect, Early effect, mobility reduction, and leakage.

Then depressed synapses and plastic weights under the full law beside their transistors, on dies from 1000 on.
Rules, stated before the first run: the charge of every pulse of a train within 5 %, and of the events of a
plastic synapse 99 % of those that are decided move its weight the same way. Decided is an event whose move
is not within a factor of two of `MOVES`, at which a move is one, by either.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np
from matplotlib.figure import Figure

from chips.rolls.chip import STEP
from chips.rolls.circuit import Params
from chips.rolls.depression.model import charges, depression_model, depression_on, resources
from chips.rolls.plastic.reference import MOVES, Stimulus, simulated, sizes, stepped
from chips.rolls.portrait import nominal_neuron, rates, rheobase, weight_program, weights
from chips.rolls.program.bias_file import DIRECT_CURRENT, OFF, default_biases
from chips.rolls.tables import build_tables
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.rolls import depressing_synapse
from circuits.blocks.rolls.dpi_synapse import FIRST_EVENT
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current
from circuits.solver.transient import simulate
from system.experiment import Experiment, Progress, Report, with_progress
from system.papers.checks.second_order import EFFECTS, draw_shifts, percent, with_effects
from system.rule import at_least, at_most, unjudged
from system.statement import Statement

INPUTS = (0.2e-9, 1e-9, 5e-9)  # A, ours: into a neuron, whose rates are compared
LONG = 0.2  # s, of a run
_BIASES = default_biases().with_code(DIRECT_CURRENT, *OFF)
FIRST_DIE, TEMPERATURES = 1000, (0.0, 27.0, 50.0)  # of what is held against transistors; degC
KINDS: tuple[BiasKind, ...] = ("gate", "ideal")
PULSES, RATE = 8, 100.0  # of a train at a depressed synapse; Hz
CHARGE_ALLOWED, ALIKE = 0.05, 0.99
EVENTS, LENGTH = 50, 1010  # of a plastic synapse and of its neuron, in so many steps


def run(progress: Progress) -> Report:
    """Build the chip under every effect by itself, and under all."""
    ideal, *others = [measured(fields) for fields in with_progress(((), *EFFECTS.values()), progress)]
    rows = [
        Statement(
            name, value, others[-1][name], unjudged(f"moved by {percent(value, others[-1][name]):+.3g} %")
        )
        for name, value in ideal.items()
    ]
    rows += [*_depression(), *_plastic()]
    shifts = {name: [percent(value, found[name]) for found in others] for name, value in ideal.items()}

    def draw(figure: Figure) -> None:
        draw_shifts(shifts, figure)

    return Report(tuple(rows), draw)


def measured(fields: tuple[str, ...]) -> Mapping[str, float]:
    """Return what the nominal chip is like with some fields of its process's law, the others ideal."""
    return {**of_neuron(fields), **of_synapses(fields)}


def of_neuron(fields: tuple[str, ...]) -> Mapping[str, float]:
    """Return least current, refractory period and rates of the nominal neuron under some fields."""
    neuron = nominal_neuron(_BIASES, _nominal(fields), "gate", Params())
    found = {"least_current_A": float(rheobase(neuron)[0]), "refractory_s": float(neuron.refractory[0])}
    fired = rates(neuron, np.array(INPUTS)[:, None], np.full(len(INPUTS), LONG))[:, 0]
    return found | {f"rate_at_{1e9 * i:g}_nA_Hz": float(rate) for i, rate in zip(INPUTS, fired, strict=True)}


def of_synapses(fields: tuple[str, ...]) -> Mapping[str, float]:
    """Return the pulse, the filters' time constants and the weights' charges under some fields."""
    program = weight_program(_BIASES, ())
    built = build_tables(Params(), program, "gate", _nominal(fields), STEP)
    found = {"pulse_s": float(built.lengths[0])}
    found |= {
        f"{name}_tau_s": float(f.tau[0])
        for name, f in zip(("excitatory", "inhibitory"), built.filters, strict=False)
    }
    levels = weights(built, program)
    return found | {f"charge_of_level_{w.level}_C".replace("-", "minus_"): w.charge for w in levels}


def _nominal(fields: tuple[str, ...]) -> Silicon:
    return Silicon(with_effects(ROLLS_180, fields))


def _conditions() -> Iterator[tuple[Silicon, BiasKind]]:
    """Dies at their temperatures, one of each kind of bias."""
    for k, (celsius, kind) in enumerate(product(TEMPERATURES, KINDS)):
        yield Silicon(ROLLS_180, celsius, Die(number=FIRST_DIE + k)), kind


def _depression() -> tuple[Statement, ...]:
    """Charges of trains at depressed synapses of all levels."""
    worst = max(
        charge_error(silicon, kind, level) for silicon, kind in _conditions() for level in (1, 2, 3, 4)
    )
    return (Statement("depressed_charge_off", None, worst, at_most(CHARGE_ALLOWED)),)


def charge_error(silicon: Silicon, kind: BiasKind, level: int) -> float:
    """Return by what share the charge of a pulse in a train is off its transistors', at the worst."""
    circuit = rebias(depressing_synapse.build(), kind=kind)
    given = {"level": float(level), "events": float(PULSES), "rate": RATE, "duration": None}
    bench = depressing_synapse.testbench(circuit, given, silicon.process.v_dd)
    result = simulate(bench, silicon, rtol=1e-5)
    times = FIRST_EVENT + np.arange(PULSES) / RATE
    current = drain_current(result, "synapse.me9")
    inside = [(result.time > t) & (result.time < t + 0.1 / RATE) for t in times]
    drawn = np.array([np.trapezoid(current[each], result.time[each]) for each in inside])
    model = depression_model(depressing_synapse.Params(), circuit.biases, silicon.process)
    on = depression_on(model, silicon, level)
    return float(np.abs(charges(on, resources(on.branches, tuple(times)))[0] / drawn - 1.0).max())


def _plastic() -> tuple[Statement, ...]:
    """Moves of plastic weights."""
    found = [moved(silicon, kind) for silicon, kind in _conditions()]
    ours, theirs = (np.concatenate(each) for each in zip(*found, strict=True))
    decided = np.all([np.abs(np.log2(np.abs(x) / MOVES + 1e-9)) > 1.0 for x in (ours, theirs)], axis=0)
    way = [np.where(np.abs(x) > MOVES, np.sign(x), 0.0) for x in (ours, theirs)]
    share = float(np.mean((way[0] == way[1])[decided]))
    return (
        Statement("plastic_moves_alike", None, share, at_least(ALIKE)),
        Statement("plastic_moves_undecided", None, float(np.mean(~decided)), unjudged()),
    )


def moved(silicon: Silicon, kind: BiasKind) -> tuple[F64, F64]:
    """Return by how much events move a plastic weight, V: by the chip's steps, and by its transistors."""
    draw = np.random.default_rng(silicon.die.number)
    # in the middle of steps: the chip takes events at their beginnings
    at = STEP * (0.5 + draw.choice(np.arange(10, LENGTH - 10), 2 * EVENTS - 10, replace=False))
    membrane = tuple((0.05 * k, (0.1, 0.45)[int(draw.integers(2))]) for k in range(8))
    events, spikes = (tuple(np.sort(x)) for x in (at[:EVENTS], at[EVENTS:]))
    s = Stimulus(events, spikes, membrane, LENGTH * STEP)
    ours, times = stepped(s, silicon, kind)
    theirs = simulated(s, silicon, kind, times)
    return sizes(ours.tolist(), times, events, STEP), sizes(theirs.tolist(), times, events, STEP)


EXPERIMENT = Experiment("rolls-law", "what the full law moves in a ROLLS chip", run)
