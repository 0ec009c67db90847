"""Claim: after a step of 20 K in a run the chips' models spike when their transistors do, within 3 %.

Of the mean interval between spikes after the step, or of the spike's latency where there is one spike. Each
chip is held at 27 degC up to the step, and at 7 or 47 degC from it on; at both levels all voltages stay.

* ROLLS: a neuron on a direct current, fixed gates and ideal biases, the step at phases of its interval;
  both begin at 0 V, so that the circuit's step is moved by what its spikes are before the model's then;
* ranging: a rebound neuron inhibited by a call, whose release the step moves, and an echo near its end;
* NEF: a neuron on a constant current, the step within an interval.

ours, peer: the largest and the rms error, %; ratio: the largest, %. The latency chip, the selection, the
wavefront and the head are used once in a while, and have the temperature of that time.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from _report import Row, parser_of, report
from chips.cell import Cell
from chips.nef.circuit import chip_biases
from chips.nef.devices import PLACE
from chips.nef.model import neurons_on
from chips.nef.temperature import moved_neurons
from chips.ranging import circuit as ranging_chip
from chips.ranging.chip import RangingChip
from chips.rolls.chip import NO_INPUTS, RollsChip
from chips.rolls.cut import cut_row, silicon_of, testbench
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from circuits.arrays import F64
from circuits.blocks.nef import neuron as nef_neuron
from circuits.blocks.nef.neuron import LEAK
from circuits.circuit import BiasKind
from circuits.place import circuit_at
from circuits.silicon.course import Course
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.temperature import simulate_course

ALLOWED = 3.0  # %
TO = (7.0, 47.0)  # degC
KINDS: tuple[BiasKind, ...] = ("gate", "ideal")
FIRST_DIE = 1000
PROGRAM = Program(np.zeros((NEURONS, NEURONS), np.int8), default_biases().with_code("IF_DC_P", 5, 150))
ROLLS_STEPS = (50e-3, 60e-3, 70e-3)  # s
NEF_CURRENT, NEF_PHASES = 0.25e-9, (0.3, 0.6, 0.9)  # A; share of an interval
CALL, RANGING_STEP, RANGING_STOP = 1e-3, 5e-3, 0.15  # s


def main() -> int:
    """Measure every chip and print what came of it."""
    options = parser_of(__doc__, "one die of each").parse_args()
    dies = range(FIRST_DIE, FIRST_DIE + (1 if options.quick else 8))
    return report(rows(dies), options, lambda r: f"largest {r.ours:.2f} %, rms {r.peer:.2f} %")


def rows(dies: Sequence[int]) -> Iterator[Row]:
    """A row a chip, kind of biases and temperature."""
    for to in TO:
        for kind in KINDS:
            yield _row(f"ROLLS, {kind}, to {to:g} degC", [e for die in dies for e in rolls(die, kind, to)])
        yield _row(f"ranging, to {to:g} degC", [e for die in dies for e in ranging(die, to)])
        yield _row(f"NEF, to {to:g} degC", [e for die in dies for e in nef(die, to)])


def _row(name: str, errors: list[float]) -> Row:
    found = 100.0 * np.abs(np.array(errors))
    if not found.size:
        return Row(name, np.inf, np.inf, np.inf, "no spike after a step", most=ALLOWED)
    largest, rms = float(found.max()), float(np.sqrt((found**2).mean()))
    return Row(name, largest, rms, largest, f"{found.size} steps", most=ALLOWED)


def course(step: float, to: float) -> Course:
    """27 degC up to the step (s), then `to`, degC."""
    return Course(((0.0, 27.0), (step - 1e-7, 27.0), (step, to)))


def rolls(die: int, kind: BiasKind, to: float, neuron: int = 5) -> Iterator[float]:
    """Errors of the first spike after the step, shares of the mean interval."""
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=die))
    chip = RollsChip(PROGRAM, silicon, kind, step=0.2e-3)
    cut = cut_row(PROGRAM, neuron, kind)
    bench, on = replace(testbench(cut, {}, 1.0, ROLLS_180_IDEAL.v_dd), begin="uic"), silicon_of(cut, silicon)

    def circuit(at: float, stop: float) -> F64:
        found = simulate_course(replace(bench, stop=stop), on, course(at, to), record=())
        return np.asarray(found.spikes["spike[0]"])

    for step in ROLLS_STEPS:
        stop = step + 70e-3
        found, _ = chip.run(
            chip.at_rest(), stop, NO_INPUTS, lambda t, step=step: 27.0 if t < step - 1e-4 else to
        )
        ours = found.times[found.neurons == neuron]
        early = circuit(1.0, step - 5e-3)
        late = ours[early.size - 1] - early[-1]
        theirs = circuit(step - late, stop) + late
        ours, theirs = ours[ours > step], theirs[theirs > step]
        if ours.size > 1 and theirs.size > 1:
            yield float((ours[0] - theirs[0]) / np.diff(theirs).mean())


def ranging(die: int, to: float, neuron: int = 6) -> Iterator[float]:
    """Error of the spike after the step, a share of its latency from the call on, at the middle echo."""
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=die))
    chip = RangingChip(silicon, bias_kind="gate")

    def ours(echo: float) -> list[float]:
        events, found = [("call", CALL), ("echo", CALL + echo)], list[float]()
        state, now = chip.begin(), 0.0
        for stop in (RANGING_STEP, RANGING_STOP):
            while now < stop:
                state, now, output = chip.advance(state, stop, events)
                events = []
                found += [time for port, time in output.events if port == f"spike[{neuron}]"]
            state = chip.moved(state, to) if stop == RANGING_STEP else state
        return found

    single = [(e, ours(e)) for e in np.arange(4.5e-3, 80e-3, 0.5e-3).tolist()]
    single = [(e, found) for e, found in single if len(found) == 1 and found[0] > RANGING_STEP]
    if not single:
        return
    echo, (spike,) = single[len(single) // 2]
    circuit, place = circuit_at(ranging_chip.build(), (("neuron", (neuron,)),))
    cell = Cell(circuit, replace(silicon, place=place), rtol=3e-4)
    state, reached, _ = cell.advance(cell.begin(), RANGING_STEP, [("call", CALL), ("echo", CALL + echo)])
    if reached == RANGING_STEP:
        warm, state = cell.moved(state, to)
        _, theirs, output = warm.advance(state, RANGING_STOP)
        yield float((spike - theirs) / (theirs - CALL)) if output.events else np.inf


def nef(die: int, to: float, neuron: int = 5) -> Iterator[float]:
    """Errors of the first spike after the step, shares of the mean interval after it."""
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=die))
    there = replace(silicon, place=(*PLACE, ("neuron", (neuron,))))
    bench = nef_neuron.testbench(
        nef_neuron.build(), {"current": NEF_CURRENT, "duration": 0.1}, ROLLS_180_IDEAL.v_dd
    )
    spikes = simulate_course(bench, there, Course(((0.0, 27.0),)), record=()).spikes["spike"]
    old, new = (neurons_on(replace(silicon, temperature_c=t), neuron + 1, chip_biases()) for t in (27.0, to))
    for phase in NEF_PHASES:
        last, period = spikes[-3], spikes[-2] - spikes[-3]
        step = last + phase * period
        theirs = simulate_course(bench, there, course(step, to), record=()).spikes["spike"]
        u = (NEF_CURRENT / LEAK - old.leak) / old.charge * (step - last - old.refractory)
        after, _ = moved_neurons(u, np.zeros(u.size), old, new)
        left = (1.0 - after) * new.charge / (NEF_CURRENT / LEAK - new.leak)
        later = theirs[theirs > step]
        if later.size and left[neuron] > 0.0:
            mean = np.diff(later).mean() if later.size > 1 else period
            yield float((step + left[neuron] - later[0]) / mean)


if __name__ == "__main__":
    sys.exit(main())
