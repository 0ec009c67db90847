"""ROLLS synapse against the closed forms of its filter."""

from __future__ import annotations

import math

import pytest

from circuits.bias import bias_voltages, rebias
from circuits.blocks import dpi_synapse
from circuits.blocks.dpi_synapse import BLOCK, Params, build, latches
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.process import ROLLS_180, thermal_voltage
from circuits.silicon import Silicon
from circuits.solver.transient import Result, simulate

V_DD = ROLLS_180.v_dd
USUAL = Params()
DEFAULTS = {s.name: s.default for s in BLOCK.stimuli}
# A line without load: what the filter's equation describes
LONE = Params(line_capacitance=1e-15)


def run(level: float = 1.0, params: Params = USUAL, **biases: float) -> Result:
    bench = BLOCK.testbench(rebias(build(params), biases), DEFAULTS | {"level": level}, V_DD)
    return simulate(bench, Silicon(ROLLS_180), rtol=1e-6)


def number(result: Result, name: str) -> float:
    found = BLOCK.measures(result)[name]
    assert found is not None
    return found


# 3 %: the transistors' capacitances at v_syn, and the output 0.002 into moderate inversion; the inhibitory
# output's mirror follows late by C U_T / (kappa I) of its own node, 2 us at the peak, 20 us at a tenth of it
@pytest.mark.parametrize(("level", "i_tau", "within"), [(1.0, "i_etau", 0.03), (-1.0, "i_itau", 0.09)])
def test_time_constant_is_the_closed_form(level: float, i_tau: str, within: float) -> None:
    circuit = build(LONE)
    current = circuit.bias(i_tau).value
    assert isinstance(current, float)
    tau = LONE.synapse_capacitance * thermal_voltage(27.0) / (ROLLS_180.p.kappa * current)
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


def test_level_zero_lets_nothing_in() -> None:
    result = run(0.0)
    assert BLOCK.outcome(result) == "silent"
    assert float(result["v_exc_syn"].min()) > float(result["v_exc_syn"][0]) - 1e-3


def decay(kind: BiasKind, temperature: float) -> float:
    bench = BLOCK.testbench(rebias(build(), kind=kind), DEFAULTS, V_DD)
    return number(simulate(bench, Silicon(ROLLS_180, temperature), rtol=1e-5), "decay_s")


def test_generator_keeps_the_time_constant_over_temperature() -> None:
    # C U_T / (kappa I) with a PTAT current is constant; 3 %: off currents and moderate inversion
    assert decay("generator", 37.0) == pytest.approx(decay("generator", 17.0), rel=0.03)


def test_fixed_gate_drifts_as_the_closed_form_says() -> None:
    """d ln I/dT = (2 + m)/T + kappa |dV_T/dT|/U_T + kappa (V_T - V_G)/(U_T T); tau = C U_T/(kappa I)."""
    p, u_t, t = ROLLS_180.p, thermal_voltage(27.0), 300.15
    bias = build().bias("i_etau")
    gate = V_DD - float(bias_voltages(build(), bias, Silicon(ROLLS_180)))
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
    with pytest.raises(ParameterError, match="events: 0 at 1000 Hz"):
        dpi_synapse.testbench(build(), DEFAULTS | {"events": 0.0}, V_DD)
