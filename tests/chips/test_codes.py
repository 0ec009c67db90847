"""Codes of a chip: what they hold for, their currents, and what they say."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from chips.codes import Codes, Measured, attempted, codes_begun, codes_near, key_of, left_off
from chips.law_lattice import TOLERANCE, law_key
from chips.validity import OutsideBoxError
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon

SILICON = Silicon(die=Die(number=1003))
CODES = Codes(
    "chip", key_of(SILICON, "generator"), 27.0, {"i_one": ((5, 128),), "i_two": ((5, 64), (4, 1))},
    law=law_key(SILICON.process),
)  # fmt: skip


def test_currents_are_those_of_the_codes() -> None:
    assert CODES.current("i_one") == pytest.approx(410e-12)
    assert CODES.currents["i_two"] == pytest.approx((205e-12, 6.5e-9 / 256))
    assert codes_near(CODES.currents) == {"i_one": ((5, 128),), "i_two": ((5, 64), (6, 62))}


def test_codes_are_taken_at_any_temperature_by_the_chip_that_they_are_of() -> None:
    assert CODES.key == key_of(replace(SILICON, temperature_c=60.0), "generator")
    CODES.check("chip", replace(SILICON, temperature_c=60.0), "generator")


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"die": Die(number=1004)}, "die A/1003, the run has A/1004"),
        ({"die": Die("B", 1003)}, "die A/1003, the run has B/1003"),
        ({"process": SILICON.process.under("ideal")}, "law full, the run has ideal"),
        ({"process": SILICON.of_area(4.0).process}, "process_digest"),
    ],
)
def test_codes_of_another_silicon_are_refused(changed: dict[str, object], says: str) -> None:
    with pytest.raises(ParameterError, match=says):
        CODES.check("chip", replace(SILICON, **changed), "generator")


def test_codes_of_another_chip_kind_or_setup_are_refused() -> None:
    for given, says in (
        (("other", SILICON, "generator"), "of chip, must be of other"),
        (("chip", SILICON, "ideal"), "bias_kind generator, the run has ideal"),
        (("chip", SILICON, "generator", ("another", 3)), "setup none"),
    ):
        with pytest.raises(ParameterError, match=says):
            CODES.check(*given)


def test_codes_of_another_law_are_refused_by_its_families() -> None:
    bias = CODES.law["bias"]
    replace(CODES, law={**CODES.law, "bias": (bias[0] + 0.5 * TOLERANCE, bias[1])}).check(
        "chip", SILICON, "generator"
    )
    without = {name: sums for name, sums in CODES.law.items() if name != "unit"}
    for law, says in (
        ({**CODES.law, "bias": (bias[0], bias[1] - 2.0 * TOLERANCE)}, "of another law of bias; calibrate"),
        (without, "of another law of unit;"),
        ({**CODES.law, "solver": (0.0,)}, "of another law of solver;"),
        ({}, "of a law that they do not tell; calibrate the chip on that silicon again"),
    ):
        with pytest.raises(ParameterError, match=says):
            replace(CODES, law=law).check("chip", SILICON, "generator")


def test_a_chip_that_could_not_be_calibrated_says_why() -> None:
    with pytest.raises(ParameterError, match=r"die A/1003 could not be calibrated, all neurons are deaf;"):
        replace(CODES, failed="all neurons are deaf").check("chip", SILICON, "generator")


def test_a_calibration_fails_for_its_reason_but_not_outside_of_a_models_box() -> None:
    def ends(error: ParameterError) -> Codes:
        def find(begun: Codes) -> Codes:
            raise error

        return attempted("chip", SILICON, "generator", None, find)

    begun = codes_begun("chip", SILICON, "generator")
    assert attempted("chip", SILICON, "generator", None, lambda codes: codes) == begun
    assert ends(ParameterError("deaf")) == replace(begun, failed="deaf")
    with pytest.raises(OutsideBoxError, match="too cold"):
        ends(OutsideBoxError("too cold"))


def test_what_stays_off_is_told_with_its_numbers() -> None:
    measured = (
        Measured("time[0]", "s", 1e-3, 2e-3, 1.05e-3),
        Measured("time[1]", "s", 1e-3, 2e-3, 1.2e-3),
        Measured("time[2]", "s", 1e-3, 2e-3, math.nan),
    )
    assert left_off(measured, 0.1) == (
        "time[1]: 1.2ms for 1ms (+20 %)", "time[2]: nothing could be measured",
    )  # fmt: skip
