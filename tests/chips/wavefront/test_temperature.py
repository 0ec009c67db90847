"""A wave while its temperature moves, against the transistors of a row of cells."""

from __future__ import annotations

import numpy as np
import pytest

from chips.wavefront.chip import ChipCells, WavefrontChip
from circuits.bias import rebias
from circuits.blocks.wavefront.grid import START_TIME, Params, build, firing_times, plan_testbench
from circuits.circuit import BiasKind
from circuits.silicon.course import Course
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from circuits.solver.temperature import simulate_course

SILICON = Silicon(AMI_1500, die=Die(number=1003))
CODES = np.array([[3, 2, 1, 1]])


def course(step: float, to: float) -> tuple[np.ndarray, np.ndarray]:
    """27 degC, and `to` from `step` s on."""
    return np.array([0.0, step - 1e-7, step]), np.array([27.0, 27.0, to])


@pytest.mark.parametrize(("kind", "to"), [("gate", 7.0), ("gate", 47.0), ("generator", 47.0)])
def test_a_step_of_20_degrees_moves_a_wave_as_it_does_the_circuit_s(kind: BiasKind, to: float) -> None:
    chip = WavefrontChip(1, 4, cells=ChipCells(SILICON, kind))
    program = chip.program(CODES)
    still = chip.plan(program, (0, 0)).arrivals[0]
    step = float(still[1:3].mean())  # half through the second delay
    ours = chip.plan(program, (0, 0), temperature=course(step, to)).arrivals[0]
    stop = START_TIME + 1.5 * float(ours[-1])
    bench = plan_testbench(rebias(build(Params(1, 4)), kind=kind), CODES, (0, 0), stop, AMI_1500.v_dd)
    points = tuple(zip(*course(START_TIME + step, to), strict=True))
    theirs = firing_times(simulate_course(bench, SILICON, Course(points), record=()))[0]
    assert abs(theirs[0] - START_TIME) < 1e-6  # the start cell fires with its pulse
    found = theirs - theirs[0]
    assert found[1] < step < found[2]
    mean = np.diff(found).mean()
    assert ours == pytest.approx(found, abs=0.03 * mean)
    assert abs(ours[-1] - still[-1]) > 0.03 * mean


def test_a_temperature_that_stays_changes_nothing_and_steps_add_up() -> None:
    chip = WavefrontChip(4, 5, cells=ChipCells(SILICON))
    program = chip.program(np.random.default_rng(5).integers(1, 9, (4, 5)))
    still = chip.plan(program, (0, 0))
    flat = chip.plan(program, (0, 0), temperature=course(10.0, 47.0))
    assert np.array_equal(flat.arrivals, still.arrivals)
    middle = 0.5 * float(still.arrivals.max())
    there = chip.plan(program, (0, 0), temperature=course(middle, 47.0)).arrivals
    before = still.arrivals <= middle
    assert np.array_equal(there[before], still.arrivals[before])
    # in two steps of which the first one lasts a microsecond
    times, volts = course(middle, 47.0)
    twice = np.append(times, times[-1] + 1e-3 * middle), np.append(volts, 47.0)
    twice[1][2] = 37.0
    both = chip.plan(program, (0, 0), temperature=twice).arrivals
    assert both == pytest.approx(there, rel=2e-3)
