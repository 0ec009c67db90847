"""Two patterns taught to a chip: what is drawn, what is presented, and that it is learned."""

from dataclasses import replace

import numpy as np
import pytest

from chips.rolls.program.address import NONPLASTIC, VIRTUAL_EXCITATORY
from chips.rolls.setups.learning import (
    BACKGROUND,
    FIRST_COLUMN,
    VETO,
    Answers,
    Task,
    chips_of,
    held,
    learning_biases,
    lesson,
    patterns,
    presentation,
)
from chips.rolls.setups.learning_groups import GROUPS, of_group
from circuits.errors import ParameterError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from tests.refusals import refusals

SHORT = Task(training=12, tests=8)
DIE = 20  # one of those on which the numbers were chosen


@pytest.fixture(scope="module")
def chips():
    return chips_of(SHORT, Silicon(ROLLS_180_IDEAL, 27.0, Die(number=DIE)), "ideal", DIE)


def test_patterns_have_as_many_active_columns_and_differ() -> None:
    first, second = patterns(SHORT, 1)
    assert first.sum() == second.sum() == SHORT.active
    assert (first != second).any()
    assert np.array_equal(first, patterns(SHORT, 1)[0])


def test_a_presentation_is_jittered_and_taught_to_its_class() -> None:
    pattern = patterns(SHORT, 1)[0]
    events = presentation(SHORT, pattern, 1, 2.0, np.random.default_rng(0))
    assert events.times.min() >= 2.0
    assert events.times.max() <= 2.0 + SHORT.presentation
    assert (np.diff(events.times) >= 0.0).all()
    plastic = events.columns < NONPLASTIC
    counts = np.bincount(events.columns[plastic] - FIRST_COLUMN, minlength=SHORT.columns)
    assert counts[pattern].mean() > 4.0 * counts[~pattern].mean()
    for column, which in ((VIRTUAL_EXCITATORY, 1), (NONPLASTIC + BACKGROUND, 0), (NONPLASTIC + VETO, 0)):
        assert set(events.neurons[events.columns == column].tolist()) <= set(SHORT.neurons(which))
    silent = presentation(SHORT, pattern, None, 0.0, np.random.default_rng(0))
    assert (silent.columns < NONPLASTIC).all()


def test_answers_count_ties_as_half_and_not_as_right() -> None:
    rates = np.zeros((2, 256))
    rates[0, :16] = 10.0
    answers = Answers(np.array([0, 1]), rates, 0)
    assert answers.right(SHORT).tolist() == [True, False]
    assert answers.pairs_right(SHORT) == 0.75


def test_two_patterns_are_learned_and_kept(chips):
    found = lesson(chips, SHORT, DIE, silence=5.0)
    assert found.after.right(SHORT).mean() >= 0.9
    assert np.array_equal(found.bits, found.later)
    assert (np.minimum(found.weights, 1.8 - found.weights) < 0.05).all()
    # the weights of what was active in the own class alone are high more often than in the other one's
    a, b = patterns(SHORT, DIE)
    high = found.bits[: SHORT.population]
    assert high[:, a & ~b].mean() > high[:, b & ~a].mean() + 0.3


def test_held_biases_move_nothing(chips):
    assert all(held(learning_biases()).is_off(name) for name in ("PA_DELTAUP_P", "PA_DELTADN_N"))
    up = [each.built().plastic.tables.up.max() for each in chips]
    # an off current, not none
    assert up[1] < 1e-3 * up[0]


def test_a_group_alone_is_from_the_die(chips):
    plain = chips_of(SHORT, Silicon(ROLLS_180_IDEAL, 27.0, Die(number=DIE, mismatch=False)), "ideal", DIE)[
        0
    ].built()
    die = chips[0].built()
    for group in GROUPS:
        mixed = of_group(group, plain, die)
        taken = {
            "neurons": np.array_equal(mixed.tables.membranes.lines, die.tables.membranes.lines),
            "weights": np.array_equal(mixed.plastic.tables.up, die.plastic.tables.up),
            "slow filters": np.array_equal(mixed.plastic.filters[0].tau, die.plastic.filters[0].tau),
            "learning circuits": np.array_equal(mixed.plastic.tables.spike, die.plastic.tables.spike),
            "teaching": np.array_equal(mixed.tables.virtual, die.tables.virtual),
        }
        assert [name for name, same in taken.items() if same] == [group]
    with pytest.raises(UnknownNameError, match="mismatch group"):
        of_group("wires", plain, die)


test_a_task_beyond_the_chip_is_refused = refusals(
    ParameterError,
    lambda changed: replace(SHORT, **changed),
    [
        ({"columns": 65}, "task.columns: 65"),
        ({"population": 65}, "task.population"),
        ({"active": 0}, "task.active"),
    ],
)
