"""Rates of the circuit are those of its three numbers; temperature, dies, both kinds of biases."""

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.nef.neuron import BLOCK, LEAK, Params, build
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from tests.circuits.blocks.values import number

DEFAULTS = BLOCK.defaults


def rate(current: float, duration: float, silicon: Silicon, kind: BiasKind = "gate") -> float | None:
    circuit = rebias(build(), {}, kind)
    bench = BLOCK.testbench(circuit, {"current": current, "duration": duration}, ROLLS_180_IDEAL.v_dd)
    return BLOCK.measures(simulate(bench, silicon))["rate_Hz"]


def test_periods_are_a_refractory_period_and_a_charge_over_what_the_leak_leaves() -> None:
    silicon = Silicon(ROLLS_180_IDEAL)
    currents = np.array([2.0, 4.0, 8.0]) * LEAK
    periods = np.array([1.0 / number(rate(i, 0.08, silicon)) for i in currents])
    slope = (periods[0] - periods[2]) / (1.0 / (currents[0] - LEAK) - 1.0 / (currents[2] - LEAK))
    refractory = periods[2] - slope / (currents[2] - LEAK)
    # the numbers of the docstring, and the law at the third current; the spike itself lasts microseconds
    assert slope / LEAK == pytest.approx(18e-3, rel=0.02)
    assert refractory == pytest.approx(2.0e-3, rel=0.03)
    assert periods[1] == pytest.approx(refractory + slope / (currents[1] - LEAK), rel=0.003)


def test_below_the_leak_it_is_silent() -> None:
    bench = BLOCK.testbench(build(), {"current": 0.97 * LEAK, "duration": 0.3}, ROLLS_180_IDEAL.v_dd)
    result = simulate(bench, Silicon(ROLLS_180_IDEAL))
    assert BLOCK.outcome(result) == "none"
    assert result["v_mem"][-1] < 0.2  # at rest, below where a spike leaves it


def test_a_large_input_s_reset_does_not_end_the_spike_before_c_ref_is_full() -> None:
    # a slow die in the warm: with a tenth of C_k, C_ref would be 110 mV short of the supply
    silicon = Silicon(ROLLS_180, 60.0, Die(number=0))
    stimuli = {"current": 160.0 * LEAK, "duration": 6e-3}
    result = simulate(BLOCK.testbench(build(), stimuli, ROLLS_180.v_dd), silicon)
    spikes = result.spikes["spike"]
    assert spikes.size > 2
    assert result["v_ref"][result.time > spikes[1]].max() > ROLLS_180.v_dd - 20e-3


def test_fixed_gates_speed_up_in_the_warm_and_generators_do_not() -> None:
    def at(temperature: float, kind: BiasKind, share: float) -> float:
        return number(rate(share * LEAK, 0.03, Silicon(ROLLS_180_IDEAL, temperature), kind))

    # gate biases: the leak is five times as large at 60 degC, and so is what makes the same rate then
    assert number(rate(5.0 * LEAK, 0.03, Silicon(ROLLS_180_IDEAL, 27.0))) > 150.0
    warm = BLOCK.testbench(build(), {"current": 4.5 * LEAK, "duration": 0.03}, ROLLS_180_IDEAL.v_dd)
    assert BLOCK.outcome(simulate(warm, Silicon(ROLLS_180_IDEAL, 60.0))) == "none"
    # generator: proportional to T, within 11 % of 27 degC, and a swing that falls by some per cent
    assert at(60.0, "ideal", 5.0) == pytest.approx(at(27.0, "ideal", 5.0), rel=0.2)


def test_dies_differ_and_a_die_is_the_same_again() -> None:
    found = [rate(6.0 * LEAK, 0.03, Silicon(ROLLS_180_IDEAL, 27.0, die)) for die in (NOMINAL, Die(number=7))]
    assert found[0] != found[1]
    assert found[1] == rate(6.0 * LEAK, 0.03, Silicon(ROLLS_180_IDEAL, 27.0, Die(number=7)))


def test_sizes_that_cannot_be_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"membrane_capacitance: 0 F, must be > 0"):
        Params(membrane_capacitance=0.0)
