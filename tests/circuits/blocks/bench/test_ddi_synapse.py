"""The slow filter less the fast one: nothing at first, a peak, and the slow one's decay."""

import pytest

from circuits.bias import rebias
from circuits.blocks.bench.bias import MASTERS, code_current
from circuits.blocks.bench.ddi_synapse import BLOCK, Params
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate


def numbers(**currents: float) -> dict[str, float | None]:
    circuit = rebias(BLOCK.build(), {f"i_{name}": value for name, value in currents.items()})
    return BLOCK.measures(simulate(BLOCK.bench(circuit), Silicon(ROLLS_180_IDEAL)))


def test_it_ends_with_the_slow_filter_s_time_constant() -> None:
    found, slow = numbers(), code_current(MASTERS[0], 10, 1.0, 1.0)
    closed = 2.08e-12 * Silicon(ROLLS_180_IDEAL).thermal_voltage / (ROLLS_180_IDEAL.p.kappa * slow)
    # gates of three devices of 10 um^2 add a few percent to the capacitor
    assert found["tau_s"] == pytest.approx(closed, rel=0.1)
    assert found["to_peak_s"] > 2.0 * (found["pulse_width_s"] or 0.0)


def test_each_weight_is_for_its_own_filter() -> None:
    both, slow_alone = numbers(), numbers(weight2=1e-13)
    assert slow_alone["peak_A"] > both["peak_A"]
    assert slow_alone["trough_A"] > -1e-12
    assert numbers(weight1=1e-13)["trough_A"] < -1e-10
    assert BLOCK.outcome(simulate(BLOCK.bench(rebias(BLOCK.build(), {"i_weight1": 1e-13})))) == "inhibits"


def test_what_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"fast_capacitance: 0 F, must be > 0"):
        Params(fast_capacitance=0.0)
