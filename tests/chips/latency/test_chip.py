"""Addresses in, addresses out; the same bits from any thread; what does not fit is refused."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from chips.aer import Bus
from chips.latency.chip import LatencyChip, PingResponse, counted
from chips.latency.errors import usual_design
from chips.latency.model import usual_biases
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

DESIGN = usual_design()
CHIP = LatencyChip(DESIGN, silicon=Silicon(AMI_1500_IDEAL))


def train(chip: LatencyChip) -> tuple[np.ndarray, np.ndarray]:
    """Onset, goal, direction, and inputs to memories 14 to 18."""
    a = chip.addresses
    addresses = np.array([a.onset, a.goal + 16, a.direction + 2, 14, 15, 16, 17, 18])
    return np.array([0.0, 5e-3, 10e-3, 8e-3, 9e-3, 7e-3, 9e-3, 8e-3]), addresses


def told(chip: LatencyChip, pings: int = 3) -> list[PingResponse]:
    memory = chip.new_memory()
    first = chip.ping(memory, 0.1, *train(chip))
    quiet = (np.zeros(1), np.array([chip.addresses.onset]))
    return [first, *(chip.ping(memory, 0.1 * (k + 2), *quiet) for k in range(pings - 1))]


def test_memories_slow_the_race_and_are_repeated() -> None:
    first, second, third = told(CHIP)
    assert np.flatnonzero(np.isfinite(first.memory)).tolist() == [14, 15, 16, 17, 18]
    assert first.paths.size
    assert not set(first.paths.tolist()) & {14, 15, 16, 17, 18}
    assert np.array_equal(second.memory, third.memory)
    assert np.isfinite(second.memory).sum() == 5


def test_a_die_says_the_same_from_any_thread() -> None:
    def run(number: int) -> list[PingResponse]:
        silicon = Silicon(AMI_1500_IDEAL, die=Die(number=number))
        return told(LatencyChip(DESIGN, usual_biases(DESIGN, "ideal"), silicon))

    alone = [run(k) for k in range(4)]
    with ThreadPoolExecutor(3) as pool:
        together = list(pool.map(run, range(4)))
    for a, b in zip(alone, together, strict=True):
        for x, y in zip(a, b, strict=True):
            assert np.array_equal(x.times, y.times)
            assert np.array_equal(x.memory, y.memory)
            assert np.array_equal(x.free, y.free)


def test_a_slow_bus_is_late_and_a_full_one_drops() -> None:
    slow = told(LatencyChip(DESIGN, silicon=Silicon(AMI_1500_IDEAL), bus=Bus(service=0.2e-3)), 1)[0]
    assert slow.times[0] > told(CHIP, 1)[0].times[0]
    chip = LatencyChip(DESIGN, silicon=Silicon(AMI_1500_IDEAL), bus=Bus(service=20e-3, depth=1))
    assert told(chip, 1)[0].lost_in > 0


def test_another_temperature_is_the_same_die() -> None:
    warm = CHIP.at(40.0)
    assert warm.silicon.temperature_c == 40.0
    assert warm.lumped.hold.mean() < CHIP.lumped.hold.mean()
    assert counted(warm.new_memory()) == {"overflowed": 0, "undecided": 0}


def test_what_does_not_fit_is_refused() -> None:
    memory = CHIP.new_memory()
    onset = CHIP.addresses.onset
    with pytest.raises(ParameterError, match=r"latency_chip\.address: 999, must be 0 to"):
        CHIP.ping(memory, 0.0, np.zeros(2), np.array([onset, 999]))
    with pytest.raises(ParameterError, match=r"latency_chip\.events: 0 onsets, must be one"):
        CHIP.ping(memory, 0.0, np.zeros(1), np.array([3]))
    with pytest.raises(ParameterError, match=r"latency_chip\.memory\[33\]\.unit\[0\]: not on a chip"):
        CHIP.check_unit(33, 0)
