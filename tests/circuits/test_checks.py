"""What constructors refuse, and for how long what is implausible is allowed."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from circuits.checks import (
    LIMITS,
    implausible_allowed,
    require_choice,
    require_plausible,
    require_real,
    require_reals,
)
from circuits.devices import Capacitor
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, Process, TransistorModel
from circuits.silicon.silicon import Silicon


@pytest.mark.parametrize("unit", LIMITS)
def test_limits_belong_to_what_is_taken(unit: str) -> None:
    low, high = LIMITS[unit]
    for value in (low, high, -high):
        require_plausible("x", value, unit, allowed=False)
    for value in (1.01 * high, -1.01 * high, float("nan"), float("inf")):
        with pytest.raises(ParameterError, match=r"^x: .*`allow_implausible` where it is meant"):
            require_plausible("x", value, unit, allowed=False)
    require_plausible("x", 1.01 * high, unit, allowed=True)
    with pytest.raises(ParameterError):
        require_plausible("x", float("nan"), unit, allowed=True)


def test_what_is_a_number() -> None:
    for value in (1, 1.0, np.float64(1.0), np.int32(1), np.float32(1.0)):
        require_real("x", value, "V")
        require_reals("x", (value, value), "V")
    for wrong in ("1", True, None, 1j, [1.0], b"1"):
        with pytest.raises(ParameterError, match=r"^x: .*must be a number in V"):
            require_real("x", wrong, "V")
    for several in ("1", ("1", 2.0), (True, False), None, ((1.0,), (1.0, 2.0))):
        with pytest.raises(ParameterError, match=r"^x: .*must be a number in V"):
            require_reals("x", several, "V")


def test_a_choice_says_what_it_takes() -> None:
    require_choice("x", "a", ("a", "b", "c"))
    for wrong in ("A", "", 1, None, ["a"]):
        with pytest.raises(ParameterError, match=r"^x: .*, must be a, b or c"):
            require_choice("x", wrong, ("a", "b", "c"))


def test_the_allowance_ends_with_its_block_and_stays_in_its_thread() -> None:
    refused = []

    def elsewhere() -> None:
        try:
            Capacitor("c", "a", "b", 1.0)
        except ParameterError:
            refused.append(True)

    with pytest.raises(ZeroDivisionError), implausible_allowed():
        Capacitor("c", "a", "b", 1.0)
        thread = threading.Thread(target=elsewhere)
        thread.start()
        thread.join()
        raise ZeroDivisionError
    assert refused == [True]
    with pytest.raises(ParameterError):
        Capacitor("c", "a", "b", 1.0)


@pytest.mark.parametrize(
    ("construct", "text"),
    [
        (lambda: Die(corner="slow"), "corner: 'slow', must be random, typical, ss, ff, sf or fs"),
        (lambda: Die(mismatch="no"), "die.mismatch: 'no', must be True or False"),
        (lambda: Die(number=1.5), "die: 1.5, must be a whole number"),
        (lambda: Silicon("ami-1500"), "silicon.process: 'ami-1500', must be a process"),
        (lambda: Silicon(AMI_1500_IDEAL, die=1003), "silicon.die: 1003, must be a die"),
        (lambda: Silicon(AMI_1500_IDEAL, temperature_c="27"), "temperature: '27', must be a number in degC"),
        (lambda: Silicon(AMI_1500_IDEAL, temperature_c=True), "temperature: True, must be a number in degC"),
        (
            lambda: TransistorModel(0.6, 0.7, 72e-6, law="bsim"),
            "transistor_model.law: .bsim., must be ekv",
        ),
        (lambda: TransistorModel("0.6", 0.7, 72e-6), "transistor_model.v_t0: '0.6', must be a number"),
        (
            lambda: Process("p", AMI_1500_IDEAL.n, None, 5.0, 1e-9, 1e-9),
            "p.p: None, must be a transistor model",
        ),
        (
            lambda: Process("p", AMI_1500_IDEAL.n, AMI_1500_IDEAL.p, "5V", 1e-9, 1e-9),
            "p.v_dd: '5V', must be a number",
        ),
    ],
)
def test_silicon_refuses_what_it_does_not_know(construct: object, text: str) -> None:
    with pytest.raises(ParameterError, match=f"^{text}") as caught:
        construct()  # type: ignore[operator]
    assert "\n" not in str(caught.value)
