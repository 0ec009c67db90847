"""Bias table of the Pushbot's network: what the chip's generator can give, and that the levels exist."""

import pytest

from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.network import network_program
from chips.rolls.program.program import level_current, missing_levels
from circuits.errors import ParameterError
from system.pushbot.network.biases import CODES, LEVELS, pushbot_biases
from system.pushbot.network.plain import pushbot_network


def test_only_the_named_codes_differ_from_the_defaults() -> None:
    ours, theirs = pushbot_biases().codes(), default_biases().codes()
    assert {name for name in theirs if ours[name] != theirs[name]} == set(CODES)


def test_the_network_has_its_levels_and_obstacles_outdo_the_target() -> None:
    table = pushbot_biases()
    assert missing_levels(table) == {}
    network_program(pushbot_network(levels=LEVELS), table)
    obstacle = 16 * level_current(table, LEVELS.obstacle_to_drive)
    # a bump of the field is itself and two neighbours on either side
    bump = 5 * level_current(table, LEVELS.target_to_drive)
    assert obstacle > bump


def test_a_drive_that_has_won_outlasts_as_many_events_on_its_own_side() -> None:
    # its own turn makes events on both sides: what drives the other is met by more than twice as much; in the
    # modified network the gyro's populations silence these events
    table = pushbot_biases()
    held = level_current(table, LEVELS.drive_to_drive)
    assert held > 2.0 * level_current(table, LEVELS.obstacle_to_drive)


def test_changes_go_over_the_table() -> None:
    changed = pushbot_biases({"VA_EXC_N": ("50n", 100)})
    assert changed.current("VA_EXC_N") == pytest.approx(50e-9 * 100 / 256)
    with pytest.raises(ParameterError, match="fine"):
        pushbot_biases({"VA_EXC_N": ("50n", 300)})
