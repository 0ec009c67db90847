"""Waves in the event loop are the plans of the chip, to the bit."""

from __future__ import annotations

import numpy as np
import pytest

from chips.noise import SiliconNoise
from chips.part import Event
from chips.wavefront.chip import ChipCells, WavefrontChip
from chips.wavefront.part import WavefrontPart
from circuits.errors import UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from tests.chips.looped import looped


def test_a_wave_in_the_loop_is_the_plan_s() -> None:
    cells = ChipCells(Silicon(AMI_1500_IDEAL, die=Die(number=3)), noise=SiliconNoise(seed=1))
    chip = WavefrontChip(6, 5, cells=cells)
    program = chip.program(np.random.default_rng(1).integers(1, 9, (6, 5)))
    part = WavefrontPart(chip, program, goal=(5, 4))
    said, state = looped(part, [("start[7]", 1e-5), ("start[0]", 2e-3)], 6e-3)
    expected: list[Event] = []
    for number, (start, time) in enumerate((((1, 2), 1e-5), ((0, 0), 2e-3))):
        spikes = chip.plan(program, start, (5, 4), time=time, number=number).events()
        each = zip(spikes.times.tolist(), spikes.addresses.tolist(), strict=True)
        expected += [(f"fired[{k}]", time + t) for t, k in each]
    assert len(expected) > 20
    assert said == expected
    assert (state.waves, state.due) == (2, ())


def test_a_wave_starts_at_a_cell_of_the_chip() -> None:
    chip = WavefrontChip(2, 2)
    part = WavefrontPart(chip, chip.program(np.ones((2, 2), np.int64)))
    for port in ("start[4]", "goal[0]", "start[-1]", "start"):
        with pytest.raises(UnknownNameError, match=r"wavefront_chip event port .*known are start\[0\]"):
            part.advance(part.begin(), 1e-3, [(port, 0.0)])
