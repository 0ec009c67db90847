"""A ROLLS chip whose temperature moves, against the transistors of one of its rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.rolls.chip import NO_INPUTS, RollsChip
from chips.rolls.cut import cut_row, silicon_of
from chips.rolls.cut import testbench as bench_of
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.course import Course
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.temperature import simulate_course

SILICON = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1003))
# all neurons run on a direct current, at some 200 Hz
PROGRAM = Program(np.zeros((NEURONS, NEURONS), np.int8), default_biases().with_code("IF_DC_P", 5, 150))
NEURON, STEP, STOP = 5, 0.06, 0.12  # s: of the temperature, and the end


# 2 % seen of the first spike, 0.5 % of intervals; where a spike under way kept its time, 22 and 10 %
@pytest.mark.parametrize(("kind", "to"), [("ideal", 7.0), ("gate", 47.0)])
def test_a_step_of_20_degrees_moves_spikes_as_it_does_the_circuit_s(kind: BiasKind, to: float) -> None:
    chip = RollsChip(PROGRAM, SILICON, kind, step=0.2e-3)
    found, _ = chip.run(chip.at_rest(), STOP, NO_INPUTS, lambda t: 27.0 if t < STEP - 1e-4 else to)
    ours = found.times[found.neurons == NEURON]
    cut = cut_row(PROGRAM, NEURON, kind)
    bench, on = replace(bench_of(cut, {}, STOP, ROLLS_180_IDEAL.v_dd), begin="uic"), silicon_of(cut, SILICON)

    def circuit(step: float, stop: float) -> np.ndarray:
        course = Course(((0.0, 27.0), (step - 1e-7, 27.0), (step, to)))
        return simulate_course(replace(bench, stop=stop), on, course, record=()).spikes["spike[0]"]

    # both begin at 0 V, the circuit's inner nodes too; from then on the step is at the same phase in both
    early = circuit(1.0, STEP - 5e-3)
    late = ours[early.size - 1] - early[-1]
    theirs = circuit(STEP - late, STOP) + late
    assert ours.size == theirs.size
    after = theirs > STEP
    mean = np.diff(theirs[after]).mean()
    assert ours[after][0] - theirs[after][0] == pytest.approx(0.0, abs=0.03 * mean)
    assert np.diff(ours[after]) == pytest.approx(np.diff(theirs[after]), rel=0.03)
    # which is no small matter
    assert mean != pytest.approx(np.diff(early).mean(), rel=0.1)


def test_a_temperature_that_stays_changes_nothing() -> None:
    chip = RollsChip(PROGRAM, SILICON)
    still, _ = chip.run(chip.at_rest(), 0.05)
    flat, _ = chip.run(chip.at_rest(), 0.05, temperature=Course(((0.0, 27.0),)).at)
    assert flat.times == pytest.approx(still.times, abs=1e-12)  # by sums of other parts
    assert np.array_equal(still.neurons, flat.neurons)


def test_a_course_that_leaves_the_box_says_when() -> None:
    chip, course = RollsChip(PROGRAM, SILICON), Course(((0.0, 27.0), (0.02, 27.0), (0.021, 64.0)), 0.25)
    said = r"rolls_chip\.temperature: 64 degC at 0\.0[23]\d* s, must be 0 to 60"
    with pytest.raises(ParameterError, match=said):
        chip.run(chip.at_rest(), 0.05, temperature=course.at)
