"""Calibrations of the Pushbot's networks give codes, and its chip takes them."""

from __future__ import annotations

import pytest

from chips.rolls.calibration import Calibration
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.pushbot.brain import Architecture, brain_of
from system.pushbot.network import codes as pushbot_codes
from system.pushbot.network.biases import pushbot_biases
from system.pushbot.network.codes import NEURON, biases_of, gone_of
from system.pushbot.network.plain import PAPER
from system.registry import load_calibration

NOMINAL, DIE = Silicon(ROLLS_180), Silicon(ROLLS_180, die=Die(number=104))


def found(monkeypatch: pytest.MonkeyPatch, rate: float) -> None:
    """Let a search find a code, two neurons to leave out, and a rate of sp."""
    table = pushbot_biases({"VA_EXC_N": ("0.4u", 100)}, "full")
    calibration = Calibration(table, {"OL": (33, 21), "sp": ()}, {"sp": rate}, {"sp": 3.0}, 10)
    monkeypatch.setattr(pushbot_codes, "calibrate_pushbot", lambda *_: calibration)


def test_the_nominal_die_keeps_its_table_and_is_measured() -> None:
    codes = load_calibration("pushbot").calibrate(NOMINAL, "generator", PAPER)
    assert biases_of(codes) == pushbot_biases(law="full")
    assert gone_of(codes) == frozenset()
    assert {m.name: m.wanted for m in codes.measured}["rate[DL in a turn]"] == 104.0
    assert (codes.failed, codes.unmended) == ("", ())


def test_a_chip_takes_the_codes_of_its_die_without_what_is_off(monkeypatch: pytest.MonkeyPatch) -> None:
    found(monkeypatch, 31.0)
    codes = pushbot_codes.calibrate_plain(DIE, "generator", PAPER)
    assert (codes.off, codes.bench_s) == ({NEURON: (21, 33)}, 12.0)
    brain = brain_of(Architecture(), DIE, "generator", codes=codes)
    assert brain.chip.program.biases == pushbot_biases({"VA_EXC_N": ("0.4u", 100)}, "full")
    assert not {21, 33} & set(brain.network["OL"].neurons)


def test_a_silent_population_is_a_die_that_cannot_be_used(monkeypatch: pytest.MonkeyPatch) -> None:
    found(monkeypatch, 0.0)
    codes = pushbot_codes.calibrate_plain(DIE, "generator", PAPER)
    assert codes.failed == "rate[sp]: no spikes at any code that was tried"
    with pytest.raises(ParameterError, match="die A/104 could not be calibrated"):
        codes.require_usable()


def test_a_chip_without_codes_has_the_table_of_its_law() -> None:
    for law in ("ideal", "full"):
        chip = brain_of(Architecture(), Silicon(ROLLS_180.under(law))).chip
        assert chip.program.biases == pushbot_biases(law=law)
