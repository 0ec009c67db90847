"""Models are judged on the dies and with the numbers that their records name."""

import pytest

from chips.measured.held_out import DIES, TEMPERATURES, every_silicon, of_dies, rms_and_max, silicon_in_turn


def test_every_die_is_met_at_every_temperature() -> None:
    met = [(number, s.temperature_c, s.die.number, s.die.lot) for number, s in every_silicon()]
    assert met == [(n, t, n, "0") for n in DIES for t in TEMPERATURES]


def test_kinds_of_bias_and_temperatures_take_turns() -> None:
    met = [(number, kind, s.temperature_c) for number, kind, s in silicon_in_turn(range(7, 14))]
    assert met == [
        (7, "gate", 0.0), (8, "ideal", 0.0), (9, "gate", 27.0), (10, "ideal", 27.0),
        (11, "gate", 60.0), (12, "ideal", 60.0), (13, "gate", 0.0),
    ]  # fmt: skip


def test_errors_are_told_by_their_mean_square_and_their_largest() -> None:
    assert rms_and_max("delay", [3.0, -4.0], "s") == pytest.approx(
        {"delay_rms_s": 12.5**0.5, "delay_max_s": 4.0}
    )
    assert list(rms_and_max("share", [1.0], "")) == ["share_rms", "share_max"]
    assert of_dies((500, 501)) == {"dies": 2.0, "first_die": 500.0}
