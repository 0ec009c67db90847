"""Events of trains and of rate steps; what transistors make of such is in the tables' tests."""

from __future__ import annotations

import numpy as np
import pytest

from chips.rolls.chip import RollsChip
from chips.rolls.depression import trains as rolls_depression_trains
from chips.rolls.depression.reference import Events
from chips.rolls.depression.trains import (
    AT,
    CHIP_STEP,
    COLUMNS,
    HIGH,
    INPUTS,
    LEVELS,
    LOW,
    UNTIL,
    chip_on,
    constants,
    inputs_of,
    rate_step,
    response,
    train,
)


@pytest.fixture(scope="module")
def chip() -> RollsChip:
    return chip_on(1000)


@pytest.fixture
def taken(monkeypatch: pytest.MonkeyPatch) -> list[Events]:
    """Events that a run would get."""
    found: list[Events] = []
    monkeypatch.setattr(rolls_depression_trains, "_beside", lambda _, events, __: found.append(events))
    return found


@pytest.mark.parametrize("rate", [5.0, 200.0, 1000.0])
def test_a_train_has_settled_on_the_chip_s_own_steps(
    chip: RollsChip, taken: list[Events], rate: float
) -> None:
    train(chip, rate)
    (events,) = taken
    assert set(events) == {COLUMNS[0], COLUMNS[-1]}
    spent, tau = constants(chip)
    found = 1.0
    for times in events.values():
        assert np.allclose(np.diff(times), 1.0 / rate)
        assert np.allclose(times / CHIP_STEP, np.round(times / CHIP_STEP), atol=1e-6)
    gone = np.exp(-1.0 / (rate * tau))
    for _ in range(events[COLUMNS[0]].size - 1):
        found = 1.0 - (1.0 - found * np.exp(-spent)) * gone
    # e^-6 of what a synapse at rest has more
    assert found == pytest.approx((1.0 - gone) / (1.0 - gone * np.exp(-spent)), abs=np.exp(-6.0))


def test_a_rate_step_is_of_all_levels_one_after_another(chip: RollsChip, taken: list[Events]) -> None:
    rate_step(chip)
    (events,) = taken
    assert len(events) == len(LEVELS)
    first = events[COLUMNS[0]]
    gaps = np.diff(first)
    assert gaps[0] == pytest.approx(1.0 / LOW)
    assert gaps[-1] == pytest.approx(1.0 / HIGH)
    together = np.sort(np.concatenate(list(events.values())))
    assert np.diff(together).min() > 1e-3  # no two at once: a pulse is 23 us
    assert together[-1] < UNTIL + 0.01


def test_inputs_step_in_rate_with_a_phase_each() -> None:
    events = inputs_of(7)
    assert set(events) == set(INPUTS)
    after = [t[t >= AT] for t in events.values()]
    assert {t.size for t in after} == {round(HIGH * (UNTIL - AT))}
    assert np.allclose([np.diff(t) for t in after], 1.0 / HIGH)
    assert len({float(t[0]) for t in after}) == len(INPUTS)


def test_a_population_falls_after_a_step_and_one_without_depression_does_not() -> None:
    found = response(3, 0)
    assert found.depressed.max() > 1.4 * found.depressed[-5:].mean()
    assert found.plain.max() < 1.1 * found.plain[-5:].mean()
    assert 0.05 < found.spread < 0.5
    assert found.circuit == ()
