"""Pings in the event loop are those of the chip, to the bit."""

from __future__ import annotations

import numpy as np
import pytest

from chips.latency.chip import LatencyChip
from chips.latency.errors import usual_design
from chips.latency.part import LatencyPart
from chips.noise import SiliconNoise
from chips.part import Event
from circuits.errors import ParameterError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from tests.chips.looped import looped


@pytest.mark.parametrize("noise", [None, SiliconNoise(seed=2)])
def test_a_ping_in_the_loop_is_the_chip_s(noise: SiliconNoise | None) -> None:
    chip = LatencyChip(usual_design(), silicon=Silicon(AMI_1500_IDEAL, die=Die(number=5)), noise=noise)
    first = [("onset", 0.1), ("goal[16]", 0.105), ("direction[2]", 0.11)]
    heard = ((14, 0.108), (15, 0.109), (16, 0.107), (17, 0.109), (18, 0.108))
    first += [(f"memory[{p}]", t) for p, t in heard]
    events = [*first, ("onset", 0.8), ("reset", 1.5), ("onset", 1.55)]
    said, state = looped(LatencyPart(chip), events, 2.3, horizon=0.05)
    a, memory = chip.addresses, chip.new_memory()
    chip.reset(memory, 0.0)
    words = [a.onset, a.goal + 16, a.direction + 2, 14, 15, 16, 17, 18]
    expected: list[Event] = []
    for start in (0.1, 0.8, 1.55):
        if start > 1.5:
            chip.reset(memory, 1.5)
        times = np.array([t - 0.1 for _, t in first]) if start == 0.1 else np.zeros(1)
        found = chip.ping(memory, start, times, np.array(words[: times.size]))
        each = zip(found.times.tolist(), found.paths.tolist(), strict=True)
        expected += sorted(((f"winner[{p}]", start + t) for t, p in each), key=lambda e: e[1])
    assert len(expected) >= 3  # one a ping
    assert said == expected
    np.testing.assert_array_equal(LatencyPart(chip).response(state).integrating, found.integrating)


def test_what_comes_before_an_onset_is_counted_and_a_memory_must_be_there() -> None:
    part = LatencyPart(LatencyChip(usual_design(), silicon=Silicon(AMI_1500_IDEAL)))
    state, _, _ = part.advance(part.begin(), 1e-3, [("memory[3]", 0.0)])
    assert state.unheard == 1
    with pytest.raises(UnknownNameError, match=r"latency_chip event port memory\[99\]"):
        part.advance(part.begin(), 1e-3, [("onset", 0.0), ("memory[99]", 1e-4)])


def test_units_of_transistors_have_no_place_in_the_loop() -> None:
    chip = LatencyChip(usual_design(), silicon=Silicon(AMI_1500_IDEAL))
    chip.units[0, 0] = None  # type: ignore[assignment]
    with pytest.raises(ParameterError, match=r"latency_chip\.units: 1, must be none in a loop"):
        LatencyPart(chip)
