"""Events come where the closed form has the contrast, and not below it."""

import math

import pytest

from circuits.bias import rebias
from circuits.blocks.bench.dvs_pixel import BLOCK, Params
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

N, P = ROLLS_180_IDEAL.n.kappa, ROLLS_180_IDEAL.p.kappa


def numbers(ratio: float = 10.0) -> dict[str, float | None]:
    circuit = BLOCK.build()
    diff = float(circuit.bias("i_dfb").value)  # type: ignore[arg-type]
    circuit = rebias(circuit, {"i_on": ratio * diff, "i_off": diff / ratio})
    return BLOCK.measures(simulate(BLOCK.bench(circuit), Silicon(ROLLS_180_IDEAL)))


def test_the_amplifier_has_the_capacitors_ratio() -> None:
    # the reset's switch and the amplifier's own gate to drain add an overlap of 1.2 fF to 50.6 fF, and the
    # amplifier's gate takes its share of the charge
    assert numbers()["amplifier_gain"] == pytest.approx(-0.98e-12 / 50.6e-15, rel=0.06)


@pytest.mark.parametrize("ratio", [6.0, 10.0])
def test_thresholds_are_those_of_the_closed_form(ratio: float) -> None:
    found = numbers(ratio)
    closed = (50.6e-15 / 0.98e-12) * N / P**2 * math.log(ratio)
    # the switch that opens shifts both the same way: their distance is what the closed form has
    half = 0.5 * ((found["theta_on"] or 0.0) - (found["theta_off"] or 0.0))
    assert half == pytest.approx(closed, rel=0.1)


def test_less_light_than_the_threshold_makes_no_event() -> None:
    result = simulate(BLOCK.bench(change=0.05), Silicon(ROLLS_180))
    assert BLOCK.outcome(result) == "none"
    assert BLOCK.outcome(simulate(BLOCK.bench(), Silicon(ROLLS_180))) == "both"


def test_what_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"step: 40 e-folds, must be within 20 either way"):
        BLOCK.bench(change=40.0)
    with pytest.raises(ParameterError, match=r"feedback_capacitance: 0 F, must be > 0"):
        Params(feedback_capacitance=0.0)
