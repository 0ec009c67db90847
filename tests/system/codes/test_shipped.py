"""Codes that ship with the package are found again by the calibration of today."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from system.codes.file import read_codes
from system.codes.find import calibrated_anew, codes_on, shipped_file
from system.codes.table import load_calibration

FOLDER = Path(str(files("chips"))) / "calibrated"
NUMBERS = (None, 1000)
NAMES = ("ranging-chip",)


def test_those_that_are_to_ship_do() -> None:
    known = {shipped_file(name, Silicon(die=Die(number=n))).name for name in NAMES for n in NUMBERS}
    assert known <= {path.name for path in FOLDER.iterdir()}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("number", NUMBERS)
def test_shipped_codes_are_those_of_a_calibration(name: str, number: int | None) -> None:
    process = load_calibration(name).process
    silicon = Silicon(process, 27.0, Die(number=number))
    shipped = read_codes(shipped_file(name, silicon))
    assert repr(codes_on(name, silicon, "generator")) == repr(shipped)
    anew = calibrated_anew(name, silicon, "generator")
    assert (anew.key, anew.calibrated_c, anew.off, anew.failed) == (
        shipped.key, shipped.calibrated_c, shipped.off, shipped.failed,
    )  # fmt: skip
    # another machine's rounding may move a search by a step of its code, or of the bench's delays
    for bias, current in anew.currents.items():
        assert np.allclose(current, shipped.current(bias), rtol=0.05), bias
    for trim, value in anew.trims.items():
        assert np.allclose(value, shipped.trims[trim], rtol=0.0, atol=10e-3 if trim[0] == "v" else 0.3e-3), (
            trim
        )
