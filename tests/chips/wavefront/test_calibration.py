"""The wavefront chip of a die, calibrated: its unit is the design's, and its cells' delays near to costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.codes import Codes
from chips.validity import OutsideBoxError
from chips.wavefront.calibration import CALIBRATION, Design, calibrate, cell_codes
from chips.wavefront.chip import ChipCells, WavefrontChip
from circuits.blocks.wavefront.axon_delay import UNIT
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

SILICON = Silicon(AMI_1500, die=Die(number=103))
DESIGN = Design((3, 8))


@pytest.fixture(scope="module")
def codes() -> Codes:
    return calibrate(SILICON, "generator", DESIGN)


def test_the_unit_of_a_die_comes_to_the_design(codes: Codes) -> None:
    unit, *delays = codes.measured
    assert codes.failed == ""
    assert abs(unit.before / UNIT - 1.0) > 0.03
    assert unit.after == pytest.approx(UNIT, rel=0.01)  # half a step of its code is 0.4 %
    assert [m.name for m in delays] == [f"delay[{k}]" for k in range(1, 32)]
    # half a code, of a cell that is up to 15 % off, and what a fast cell lacks at the highest cost
    assert all(abs(m.after - m.wanted) < 0.6 * UNIT for m in delays[:25])
    assert codes.bench_s > 1.0


def test_the_chip_has_the_delays_that_the_bench_timed(codes: Codes) -> None:
    found = cell_codes(codes, DESIGN)
    chip = WavefrontChip(*DESIGN.shape, cells=ChipCells(SILICON, calibrated=found))
    costs = np.full(DESIGN.shape, 31)
    costs[:, 1::2] = 7
    program = chip.program(costs)
    assert np.array_equal(program.codes, found.written(costs))
    timed = chip.plan(program, (1, 1)).arrivals[1, 2]
    # of the lines through two codes, and of an axon that is straight within 0.04 % of its full scale
    assert timed == pytest.approx(found.delays(costs)[1, 1], abs=2e-3 * 31 * UNIT)
    wanted = costs * UNIT
    plain = WavefrontChip(*DESIGN.shape, cells=ChipCells(SILICON)).plan(program, (1, 1)).arrivals[1, 2]
    assert abs(timed - wanted[1, 1]) < abs(plain - wanted[1, 1])


def test_costs_are_written_as_the_codes_that_come_nearest(codes: Codes) -> None:
    found = cell_codes(codes, DESIGN)
    costs = np.full(DESIGN.shape, 20)
    off = np.abs(found.delays(costs) - 20 * UNIT)
    for step in (-1, 1):
        other = (found.offset + found.own * (found.written(costs).ravel() + step)).reshape(DESIGN.shape)
        assert (off <= np.abs(other - 20 * UNIT) + 1e-15).all()
    assert found.written(np.zeros(DESIGN.shape)).sum() == 0


def test_waves_go_round_a_cell_that_is_left_out(codes: Codes) -> None:
    found = cell_codes(replace(codes, off={"cell": (12,)}), DESIGN)  # row 1, column 4
    chip = WavefrontChip(*DESIGN.shape, cells=ChipCells(SILICON, calibrated=found))
    program = chip.program(np.ones(DESIGN.shape, dtype=np.int64))
    path = chip.plan(program, (1, 0), (1, 7)).path().tolist()
    assert [1, 4] not in path
    with pytest.raises(ParameterError, match="is blocked"):
        chip.plan(program, (1, 4))


@pytest.mark.parametrize(("unit", "side"), [(1e3 * UNIT, "unit: 0.1 s"), (1e-6, "i_delay: 3.19e-07 A")])
def test_a_unit_that_the_record_does_not_reach_is_no_chip_that_failed(unit: float, side: str) -> None:
    with pytest.raises(OutsideBoxError, match=f"wavefront_chip.{side}"):
        calibrate(replace(SILICON, die=Die(number=3)), "generator", Design((2, 2), unit))


def test_a_chip_without_a_cell_cannot_be_used(codes: Codes) -> None:
    none = replace(codes, failed="no cell is left")
    with pytest.raises(ParameterError, match="could not be calibrated, no cell is left"):
        none.check(none.chip, SILICON, "generator", DESIGN)


def test_it_is_calibrated_for_the_chip_of_a_rover() -> None:
    assert CALIBRATION.setup == Design((20, 20), UNIT)
