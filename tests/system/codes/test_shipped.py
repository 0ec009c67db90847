"""Codes that ship with the package are found again by the calibration of today."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from chips.validity import OutsideBoxError
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from system.codes.file import read_codes
from system.codes.find import calibrated_anew, codes_on, shipped_file
from system.registry import calibration_names, load_calibration
from system.system import DRAWN

FOLDER = Path(str(files("chips"))) / "calibrated"
NUMBERS = (None, DRAWN)
SHIPPED = [name for name in calibration_names() if not name.startswith("pushbot")]  # which takes minutes


def _silicon(name: str, number: int | None) -> Silicon:
    return Silicon(load_calibration(name).process, 27.0, Die(number=number))


@pytest.mark.parametrize("number", NUMBERS)
def test_every_chip_has_codes_in_the_package_that_a_run_takes(number: int | None) -> None:
    for name in SHIPPED:
        silicon = _silicon(name, number)
        shipped = read_codes(shipped_file(name, silicon))
        assert repr(codes_on(name, silicon, "generator")) == repr(shipped), name
    assert len(list(FOLDER.glob("*.toml"))) >= len(SHIPPED) * len(NUMBERS)


@pytest.mark.parametrize("name", SHIPPED)
def test_a_silicon_outside_of_a_models_box_is_no_chip_that_failed(name: str) -> None:
    frozen = replace(_silicon(name, DRAWN), temperature_c=-40.0)
    box = "0 to 60" if name == "rolls" else "-[12]0 to [68][05]"
    with pytest.raises(OutsideBoxError, match=f"-40 degC, must be {box}"):
        calibrated_anew(name, frozen, "generator")


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_codes_are_those_of_a_calibration(name: str) -> None:
    silicon = _silicon(name, DRAWN)
    shipped = read_codes(shipped_file(name, silicon))
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
