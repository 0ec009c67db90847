"""Codes of another die's calibration, which a run keeps by `codes_of`."""

from __future__ import annotations

from pathlib import Path

import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.approach.run import SYSTEM
from system.options.codes import described
from system.options.die.file import write_die_file

DIE = Die(number=1000)  # whose codes ship


def test_healed_die_keeps_the_codes_of_the_die() -> None:
    own = SYSTEM.scenario(die=DIE)
    held = SYSTEM.scenario(die=DIE.healed("ranging_chip"), coded_on=DIE)
    assert held.ranging_codes is own.ranging_codes
    assert described(held)["codes"] == "calibrated, of die A/1000"
    assert described(own)["codes"] == "calibrated"


def test_die_of_the_codes_is_a_number_or_a_file(tmp_path: Path) -> None:
    path = tmp_path / "die.toml"
    write_die_file(path, DIE)
    for text in ("1000", str(path)):
        assert SYSTEM.scenario(codes_of=text).coded_on == DIE
    with pytest.raises(ParameterError, match="codes_of"):
        SYSTEM.scenario(codes_of="x")
