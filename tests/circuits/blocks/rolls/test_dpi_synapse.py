"""ROLLS synapse against the closed forms of its filter."""

from __future__ import annotations

import math

import numpy as np
import pytest

from circuits.bias import bias_voltages, rebias
from circuits.blocks.bias.generator import transistor_current
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls.bias import default_current
from circuits.blocks.rolls.dpi_synapse import BLOCK, FIRST_EVENT, Params, build, latches
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180_IDEAL, thermal_voltage
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.power import drain_current
from circuits.solver.transient import Result, simulate

V_DD = ROLLS_180_IDEAL.v_dd
USUAL = Params()
DEFAULTS = BLOCK.defaults
# A line without load: what the filter's equation describes
LONE = Params(line_capacitance=1e-15)


def run(level: float = 1.0, params: Params = USUAL, **biases: float) -> Result:
    bench = BLOCK.testbench(rebias(build(params), biases), DEFAULTS | {"level": level}, V_DD)
    return simulate(bench, Silicon(ROLLS_180_IDEAL), rtol=1e-6)


def number(result: Result, name: str) -> float:
    found = BLOCK.measures(result)[name]
    assert found is not None
    return found


def at_v_syn(params: Params) -> float:
    """C_syn and what the pair and the output add: half an oxide each, the pair's drain."""
    n = ROLLS_180_IDEAL.n
    areas = params.pair_width * params.pair_length + params.output_width * params.output_length
    drain = (n.overlap_capacitance + n.junction_capacitance) * params.pair_width * 1e-6
    return params.synapse_capacitance + 0.5 * n.oxide_capacitance * areas * 1e-12 + drain


# 3 %: the output is up to 0.013 into moderate inversion, where its slope is 5 % less; the inhibitory output's
# mirror follows late by C U_T / (kappa I) of its own node, 3 us at the peak, 30 us at a tenth of it
@pytest.mark.parametrize(("level", "i_tau", "within"), [(1.0, "i_etau", 0.03), (-1.0, "i_itau", 0.09)])
def test_time_constant_is_the_closed_form(level: float, i_tau: str, within: float) -> None:
    circuit = build(LONE)
    current = circuit.bias(i_tau).value
    assert isinstance(current, float)
    tau = at_v_syn(LONE) * thermal_voltage(27.0) / (ROLLS_180_IDEAL.p.kappa * current)
    assert number(run(level, LONE, i_inh=19e-9), "decay_s") == pytest.approx(tau, rel=within)


def test_line_slows_the_decay() -> None:
    # while the pair still conducts the line follows v_syn, and its capacitance is beside C_syn
    lone, loaded = (number(run(1.0, p), "decay_s") for p in (LONE, USUAL))
    share = USUAL.line_capacitance / USUAL.synapse_capacitance
    assert 0.1 * share < loaded / lone - 1.0 < 1.1 * share


def test_pulse_width_is_the_closed_form() -> None:
    i_pw = build().bias("i_pwlk").value
    assert isinstance(i_pw, float)
    # the event itself lasts 10.1 us; the inverter switches between a third and a half of the supply
    rest = number(run(), "pulse_width_s") - 10.1e-6
    low, high = (USUAL.pulse_capacitance * share * V_DD / i_pw for share in (0.33, 0.5))
    assert low < rest < high


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_levels_are_in_order(sign: float) -> None:
    peaks = [number(run(sign * level), "peak_current_A") for level in (1.0, 2.0, 3.0, 4.0)]
    assert peaks == sorted(peaks)
    assert peaks[0] > 0.0


def test_level_of_one_sign_leaves_the_other_filter_at_rest() -> None:
    for level, other in ((3.0, "v_inh_syn"), (-3.0, "v_exc_syn")):
        v = run(level)[other]
        assert float(v.max() - v.min()) < 1e-3


def leaks(level: float, temperature: float) -> tuple[float, float]:
    """What an idle synapse draws from its lines, A."""
    bench = BLOCK.testbench(build(), DEFAULTS | {"level": level}, V_DD)
    point = operating_point(bench, Silicon(ROLLS_180_IDEAL, temperature))
    return (transistor_current(point, "synapse.me9"), transistor_current(point, "synapse.mi1"))


@pytest.mark.parametrize("level", [-4.0, -1.0, 0.0, 1.0, 4.0])
def test_an_idle_synapse_leaks_what_its_held_switch_does(level: float) -> None:
    # I_0 W/L e^(-V_shift / U_T) with the process's I_0 of 0.5 pA; 1 %: the line is not infinitely far
    expected = 0.501e-12 * 0.5 / 0.18 * math.exp(-0.25 / thermal_voltage(27.0))
    assert leaks(level, 27.0) == pytest.approx((expected, expected), rel=0.01)
    # 256 of them are below a hundredth of I_tau
    assert 256 * max(leaks(level, 60.0)) < 0.01 * 100e-12


# what the mirror or the switches cost: 1 % of the sum of the biases
@pytest.mark.parametrize(("level", "carried"), [(4.0, 616.7e-9), (-4.0, 44.0e-6)])
def test_the_largest_default_weights_are_carried(level: float, carried: float) -> None:
    bench = BLOCK.testbench(build(), DEFAULTS | {"level": level, "events": 1.0, "duration": 1.02e-3}, V_DD)
    result = simulate(bench, Silicon(ROLLS_180_IDEAL), rtol=1e-5)
    switch = "synapse.me9" if level > 0.0 else "synapse.mi1"
    drawn = np.abs(drain_current(result, switch))
    late = float(np.interp(FIRST_EVENT + 9e-6, result.time, drawn))
    assert late == pytest.approx(carried, rel=0.01)


def test_the_pair_is_in_weak_inversion_at_excitatory_weights_only() -> None:
    law = Silicon(ROLLS_180_IDEAL).law("n")
    specific = law.square_current * USUAL.pair_width / USUAL.pair_length
    exc = sum(default_current(f"NPA_WEIGHT_EXC{k}_P") for k in ("", "0", "1"))
    inh = [default_current(f"NPA_WEIGHT_INH{k}_N") for k in ("", "0", "1")]
    assert exc / specific < 0.1
    # moderate inversion at the least inhibitory weight, strong at the largest
    assert 0.1 < inh[0] / specific < 1.0 < sum(inh) / specific < 10.0


def test_level_zero_lets_nothing_in() -> None:
    result = run(0.0)
    assert BLOCK.outcome(result) == "silent"
    assert float(result["v_exc_syn"].min()) > float(result["v_exc_syn"][0]) - 1e-3


def decay(kind: BiasKind, temperature: float) -> float:
    bench = BLOCK.testbench(rebias(build(), kind=kind), DEFAULTS, V_DD)
    return number(simulate(bench, Silicon(ROLLS_180_IDEAL, temperature), rtol=1e-5), "decay_s")


def test_generator_keeps_the_time_constant_over_temperature() -> None:
    # C U_T / (kappa I) with a PTAT current is constant; 3 %: off currents and moderate inversion
    assert decay("ideal", 37.0) == pytest.approx(decay("ideal", 17.0), rel=0.03)


def test_fixed_gate_drifts_as_the_closed_form_says() -> None:
    """d ln I/dT = (2 + m)/T + kappa |dV_T/dT|/U_T + kappa (V_T - V_G)/(U_T T); tau = C U_T/(kappa I)."""
    p, u_t, t = ROLLS_180_IDEAL.p, thermal_voltage(27.0), 300.15
    bias = build().bias("i_etau")
    gate = V_DD - float(bias_voltages(build(), bias, Silicon(ROLLS_180_IDEAL)))
    drift = (
        (2.0 + p.mobility_exponent) / t - p.kappa * p.v_t0_drift / u_t + p.kappa * (p.v_t0 - gate) / (u_t * t)
    )
    found = math.log(decay("gate", 17.0) / decay("gate", 37.0)) / 20.0
    # 5 %: second order over 20 K, and the decay's own 3 %
    assert found == pytest.approx(drift - 1.0 / t, rel=0.05)


@pytest.mark.parametrize("level", [5.0, -5.0, 1.5])
def test_level_that_no_synapse_has(level: float) -> None:
    with pytest.raises(ParameterError, match="whole number from -4 to 4"):
        latches(level, V_DD)


def test_events_and_rate_must_be_positive() -> None:
    with pytest.raises(ParameterError, match="events: 0, must be a whole number from 1"):
        dpi_synapse.testbench(build(), DEFAULTS | {"events": 0.0}, V_DD)
