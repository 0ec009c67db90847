"""The follower slews at I_b over C and ends with the time constant of the tanh."""

import pytest

from circuits.blocks.bench.bias import MASTERS, code_current
from circuits.blocks.bench.follower_integrator import BLOCK, Params
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

TAIL = code_current(MASTERS[1], 37, 1.0, 1.0)

SIZES = Params()


def numbers(
    process: Process = ROLLS_180_IDEAL, params: Params = SIZES, **knobs: float
) -> dict[str, float | None]:
    return BLOCK.measures(simulate(BLOCK.bench(BLOCK.build(params), **knobs), Silicon(process)))


def test_without_second_order_effects_it_is_the_closed_form() -> None:
    found = numbers()
    assert found["slew_rate_V_per_s"] == pytest.approx(TAIL / 1e-12, rel=0.05)  # and the mirrors' own charge
    tau = 2.0 * 1e-12 * Silicon(ROLLS_180_IDEAL).thermal_voltage / (ROLLS_180.n.kappa * TAIL)
    # the amplifier's own capacitances and the 0.5 % of the slope that moderate inversion takes
    assert found["time_constant_s"] == pytest.approx(tau, rel=0.06)
    assert found["gain"] == pytest.approx(1.0, abs=2e-3)


def test_a_line_s_capacitance_slows_it() -> None:
    alone, loaded = numbers(), numbers(params=Params(line_capacitance=1e-12))
    ratio = loaded["time_constant_s"] / alone["time_constant_s"]
    assert ratio == pytest.approx(2.0, rel=0.04)


def test_the_early_effect_leaves_an_offset_and_less_than_the_step() -> None:
    found = numbers(ROLLS_180)
    assert found["offset_V"] != pytest.approx(0.0, abs=1e-3)
    assert 0.95 < found["gain"] < 0.999


def test_a_short_run_does_not_settle() -> None:
    result = simulate(BLOCK.bench(duration=1e-3), Silicon(ROLLS_180))
    assert BLOCK.outcome(result) == "slews"
    assert BLOCK.outcome(simulate(BLOCK.bench(), Silicon(ROLLS_180))) == "settles"


def test_what_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"step: 1.9 V, must be within 0 V and the supply"):
        numbers(step=1.0)
    with pytest.raises(ParameterError, match=r"line_capacitance: -1e-12 F, must be 0 F or more"):
        Params(line_capacitance=-1e-12)
