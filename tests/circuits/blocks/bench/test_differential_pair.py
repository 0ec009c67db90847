"""The pair is a tanh whose offset is the difference of thresholds, and codes are what the generator has."""

import math

import pytest

from circuits.bias import rebias
from circuits.blocks.bench.bias import MASTERS, code_current
from circuits.blocks.bench.differential_pair import BLOCK
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current
from circuits.solver.transient import simulate


def test_the_law_without_second_order_effects_is_a_tanh() -> None:
    silicon = Silicon(ROLLS_180_IDEAL)
    weak = rebias(BLOCK.build(), {"i_tail": 0.5e-9})  # a thousandth of the specific current
    result = simulate(BLOCK.bench(weak), silicon)
    found = BLOCK.measures(result)
    # sqrt(I / I_S) / 2 of 1.5 % is what moderate inversion takes from the slope
    assert found["kappa"] == pytest.approx(ROLLS_180.n.kappa, rel=0.02)
    tail, kappa = found["tail_A"], found["kappa"]
    k = int(abs(result["v1"] - 0.93).argmin())
    difference = drain_current(result, "m1")[k] - drain_current(result, "m2")[k]
    wide = (result["v1"] - result["v2"])[k]
    assert difference == pytest.approx(
        tail * math.tanh(kappa * wide / (2.0 * silicon.thermal_voltage)), rel=0.02
    )


def test_the_offset_is_the_pair_s_own() -> None:
    silicon = Silicon(ROLLS_180_IDEAL, die=Die(number=1001, process=False))
    circuit = BLOCK.build()
    v_t0 = [float(silicon.deviation(circuit.name, ((m, ()),), 1e-12, "n")[0][0]) for m in ("m1", "m2")]
    beta = [float(silicon.deviation(circuit.name, ((m, ()),), 1e-12, "n")[1][0]) for m in ("m1", "m2")]
    found = BLOCK.measures(simulate(BLOCK.bench(), silicon))
    own = v_t0[0] - v_t0[1] - silicon.thermal_voltage / ROLLS_180.n.kappa * (beta[0] - beta[1])
    assert abs(own) > 2e-3
    assert found["offset_V"] == pytest.approx(own, abs=3e-4)


def test_a_code_gives_three_times_the_square() -> None:
    assert code_current(MASTERS[1], 37, 1.0, 1.0) == pytest.approx(199.5e-12, rel=1e-3)
    assert code_current(MASTERS[0], 2, 3.4, 1.0) == pytest.approx(4.8e-12, rel=0.01)


@pytest.mark.parametrize("fine", [256.0, -1.0, 1.5])
def test_a_code_that_the_generator_lacks_is_refused(fine: float) -> None:
    with pytest.raises(
        ParameterError, match=rf"bias fine code: {fine:g}, must be a whole number from 0 to 255"
    ):
        code_current(MASTERS[0], fine, 1.0, 1.0)
    with pytest.raises(ParameterError, match=r"bias master: 1e-09 A, must be one of 6e-11, .* A"):
        code_current(1e-9, 1.0, 1.0, 1.0)


def test_a_sweep_that_leaves_the_supply_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"span: -0.05 V, must be within 0 V and the supply"):
        BLOCK.bench(common=0.1)


def test_a_sweep_that_does_not_reach_the_offset_is_one_sided() -> None:
    silicon = Silicon(ROLLS_180, die=Die(number=1001, process=False))
    result = simulate(BLOCK.bench(span=1e-4), silicon)
    assert BLOCK.outcome(result) == "one-sided"
    assert BLOCK.measures(result)["kappa"] is None
