"""The learning circuit lets weights move while calcium is in its window, by where the membrane is."""

import pytest

from circuits.bias import rebias
from circuits.blocks.rolls.calcium_gate import BLOCK, build
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

NEVER = 0.0


def run(
    rate: float, spikes: float, membrane: float, silicon: Silicon | None = None, kind: BiasKind = "gate"
) -> Result:
    values = {"rate": rate, "spikes": spikes, "membrane": membrane, "duration": spikes / rate + 0.05}
    on = Silicon(ROLLS_180_IDEAL) if silicon is None else silicon
    return simulate(BLOCK.testbench(rebias(build(), {}, kind), values, 1.8), on)


@pytest.mark.parametrize(("membrane", "word"), [(0.5, "up"), (0.1, "dn")])
def test_a_few_spikes_open_the_window(membrane: float, word: str) -> None:
    assert BLOCK.outcome(run(100.0, 6.0, membrane)) == word
    assert BLOCK.outcome(run(5.0, 2.0, membrane)) == "neither"


def test_much_calcium_closes_first_the_way_down() -> None:
    found = BLOCK.measures(run(400.0, 60.0, 0.1))
    # the line falls between the thresholds of 16 and 66 pA, on the way up and after the spikes
    up = BLOCK.measures(run(400.0, 60.0, 0.5))
    assert found["dn_s"] is not None
    assert up["up_s"] is not None
    assert found["dn_s"] < 0.7 * up["up_s"]
    assert found["up_s"] == up["dn_s"] == NEVER


def test_calcium_adds_up() -> None:
    few, many = (BLOCK.measures(run(100.0, n, 0.1))["calcium_A"] for n in (3.0, 6.0))
    assert few is not None
    assert many is not None
    # tau / 0.88 = 0.1 s: (1 - e^-0.6) / (1 - e^-0.3)
    assert many / few == pytest.approx(1.74, rel=0.1)


def test_a_generator_holds_the_window_and_dies_differ() -> None:
    hot = Silicon(ROLLS_180_IDEAL, 60.0)
    gate, generator = (BLOCK.measures(run(100.0, 6.0, 0.1, hot, k))["calcium_A"] for k in ("gate", "ideal"))
    usual = BLOCK.measures(run(100.0, 6.0, 0.1))["calcium_A"]
    assert gate is not None
    assert generator is not None
    assert usual is not None
    assert gate / usual > 4.0
    assert generator / usual < 2.0
    a, b = (BLOCK.measures(run(100.0, 3.0, 0.1, Silicon(ROLLS_180_IDEAL, die=Die(number=n)))) for n in (1, 2))
    assert a["calcium_A"] != b["calcium_A"]


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"spikes: 0, must be a whole number from 1"):
        BLOCK.testbench(build(), {"spikes": 0.0, "rate": 100.0, "membrane": 0.5, "duration": None}, 1.8)
