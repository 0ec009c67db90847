"""ROLLS neuron: what each of its parts does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.rolls.bias import default_current
from circuits.blocks.rolls.neuron import BLOCK, STEP_TIME, Params, build
from circuits.devices import Source
from circuits.devices.source import PiecewiseLinear
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL, thermal_voltage
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

V_DD = ROLLS_180_IDEAL.v_dd
DEFAULTS = BLOCK.defaults


def run(
    stimuli: dict[str, float | None], biases: dict[str, float] | None = None, rtol: float = 1e-6
) -> Result:
    circuit = rebias(build(), biases)
    return simulate(BLOCK.testbench(circuit, DEFAULTS | stimuli, V_DD), Silicon(ROLLS_180_IDEAL), rtol=rtol)


def measure(result: Result, name: str) -> float:
    found = BLOCK.measures(result)[name]
    assert found is not None
    return found


def test_rate_rises_with_the_current_and_is_zero_below_the_leak() -> None:
    rates = [measure(run({"current": i, "duration": 60e-3}), "rate_Hz") for i in (3e-10, 1e-9, 3e-9)]
    assert rates == sorted(rates)
    # tau2 draws 64 pA, less than which the membrane cannot keep
    assert run({"current": 5e-11, "duration": 0.1}).spikes["spike"].size == 0


def test_slow_leak_lets_a_smaller_current_fire() -> None:
    weak = {"current": 2e-11, "duration": 0.3}
    assert run(weak).spikes["spike"].size == 0
    assert run(weak | {"slow": 1.0}).spikes["spike"].size > 0


def driven(points: tuple[tuple[float, float], ...], duration: float, node: str, slow: float | None) -> Result:
    """A current into `node` (A) along (s, A), none elsewhere."""
    bench = BLOCK.testbench(build(), DEFAULTS | {"current": 0.0, "slow": slow, "duration": duration}, V_DD)
    wave = PiecewiseLinear(*zip(*points, strict=True))
    sources = (*(s for s in bench.sources if s.name != "i_in"), Source("i_in", node, wave, "current"))
    return simulate(replace(bench, sources=sources), Silicon(ROLLS_180_IDEAL), rtol=1e-6)


# The transistors at v_mem add 6.5 % to C_mem (their half oxides, overlaps and junctions). Against the slower
# leak of 2.34 pA stand the feedback, 0.1 to 0.35 pA here, and off currents that differ by 0.1 pA.
@pytest.mark.parametrize(
    ("slow", "name", "amplitude", "longer"),
    [(None, "IF_TAU2_N", 3.5e-10, (1.05, 1.09)), (1.0, "IF_TAU1_N", 2.5e-10, (1.1, 1.25))],
)
def test_a_silent_membrane_falls_with_its_time_constant(
    slow: float | None, name: str, amplitude: float, longer: tuple[float, float]
) -> None:
    points = ((0.0, 0.0), (2e-3, 0.0), (2.001e-3, amplitude), (4e-3, amplitude), (4.001e-3, 0.0))
    result = driven(points, 0.15 if slow else 12e-3, "i_in", slow)
    assert result.spikes["spike"].size == 0
    peak = int(result["v_mem"].argmax())
    times = np.interp((-0.18, -0.12), -result["v_mem"][peak:], result.time[peak:])
    u_t, kappa = thermal_voltage(27.0), ROLLS_180_IDEAL.n.kappa
    found = (times[1] - times[0]) * u_t / (kappa * 0.06)  # I_mem = I_0 e^(kappa v_mem / U_T)
    closed = Params().membrane_capacitance * u_t / (kappa * default_current(name))
    assert longer[0] < found / closed < longer[1]


def test_a_current_drawn_from_the_membrane_is_borne() -> None:
    # 20 nA, as an ideal source draws on below ground, where off transistors give it back; then it fires again
    points = ((0.0, 0.0), (3e-3, 0.0), (3.001e-3, -2e-8), (5e-3, -2e-8), (5.001e-3, 1e-9), (10e-3, 1e-9))
    result = driven(points, 10e-3, "v_mem", None)
    assert -0.5 < float(result["v_mem"].min()) < -0.1
    assert result.spikes["spike"].size > 0
    assert float(result.spikes["spike"][0]) > 5e-3


def test_refractory_period_is_the_closed_form() -> None:
    i_rfr2 = 500e-12
    result = run({"current": 5e-9, "duration": 12e-3}, {"i_rfr2": i_rfr2})
    spike = float(result.spikes["spike"][0])
    released = (result.time > spike + 1e-6) & (result["v_mem"] > 0.02)
    found = float(result.time[released][0]) - spike
    # V_inv of the inverter at v_ref lies between 0.4 and 0.55 of the supply; its gates (9 um^2, half of their
    # oxide) are beside C_ref; the membrane needs 20 us to rise
    capacitance = Params().refractory_capacitance + 0.5 * ROLLS_180_IDEAL.n.oxide_capacitance * 9e-12
    low, high = (capacitance * (1.0 - share) * V_DD / i_rfr2 for share in (0.55, 0.4))
    assert low < found < high + 20e-6


def test_spike_is_whole() -> None:
    result = run({})
    assert float(result["spike"].max()) > 0.99 * V_DD
    assert float(result["v_mem"].min()) > -0.05


def test_latency_and_interval_follow_from_the_same_charge() -> None:
    result = run({})
    # the membrane starts at rest at 0 V either way; the refractory period is all that an interval has more
    gap = float(np.diff(result.spikes["spike"])[0])
    refractory = gap - (float(result.spikes["spike"][0]) - STEP_TIME)
    assert 20e-6 < refractory < 300e-6


def test_adaptation_lengthens_intervals() -> None:
    drive: dict[str, float | None] = {"current": 2e-9, "duration": 80e-3}
    strong = {"i_ahw": 100e-9, "i_ahtau": 2e-12, "i_athr": 20e-12}
    assert measure(run(drive), "adaptation") == pytest.approx(1.0, rel=1e-3)
    assert measure(run(drive, strong), "adaptation") < 0.8


def test_nmda_gate_passes_current_only_above_its_voltage() -> None:
    through: dict[str, float | None] = {"current": 0.0, "nmda": 2e-9, "duration": 60e-3}
    assert run(through).spikes["spike"].size > 0  # gate at ground
    closed = {"i_nmda": 1e-7}  # 0.55 V, which the resting membrane is below
    assert run(through, closed).spikes["spike"].size == 0


def test_mismatch_reaches_the_rate() -> None:
    bench = BLOCK.testbench(build(), DEFAULTS, V_DD)
    latencies = {
        simulate(bench, Silicon(ROLLS_180_IDEAL, die=Die(number=k, process=False)))
        .spikes["spike"][:1]
        .tobytes()
        for k in (1, 2, 3)
    }
    assert len(latencies) == 3
