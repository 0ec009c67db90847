"""Jitter of events: closed forms of ramps, of shot noise and of flicker, and the past."""

import math
from dataclasses import replace

import pytest

from chips.noise import SiliconNoise
from chips.shot_noise import current_wander, shot_share, steepness
from circuits.blocks.latency import tap as latency_tap
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Resistor, Source, Transistor
from circuits.devices.noise import WHITE_ONLY, NoiseModel
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import AMI_1500_IDEAL, BOLTZMANN, ELEMENTARY_CHARGE, kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.event_jitter import event_jitter
from circuits.testbench import Testbench

CURRENT = 3.34e-9  # A, of a tap
K_T = BOLTZMANN * kelvin(27.0)


def low_pass(rise, stop, resistance=1e6, capacitance=1e-12):
    """A ramp from 0 to the supply in `rise` s behind a low-pass."""
    devices = Resistor("r", "ramp", "out", resistance), Capacitor("c", "out", "0", capacitance)
    circuit = Circuit("low_pass", (Port("ramp", "analog"), Port("out", "event", "out")), devices)
    wave = PiecewiseLinear((0.0, 1e-6, 1e-6 + rise), (0.0, 0.0, AMI_1500_IDEAL.v_dd))
    bench = Testbench("low-pass", circuit, (Source("ramp", "ramp", wave),), stop, watch=("out",))
    return to_kernel(bench, Silicon(AMI_1500_IDEAL))


def tap(duration=3.3e-3):
    circuit = latency_tap.build(latency_tap.Params(taps=1))
    return to_kernel(
        latency_tap.testbench(circuit, {"duration": duration}, AMI_1500_IDEAL.v_dd), Silicon(AMI_1500_IDEAL)
    )


def test_a_slow_ramp_behind_a_low_pass_moves_by_k_t_over_c():
    """`sqrt(k T / C) / slope`: within 3 %, what steps of a twentieth of the time left make of it."""
    jitter = event_jitter(low_pass(100e-6, 80e-6), "out", WHITE_ONLY, rtol=1e-6)
    slope = AMI_1500_IDEAL.v_dd / 100e-6
    assert jitter.deviation == pytest.approx(math.sqrt(K_T / 1e-12) / slope, rel=0.03)
    assert jitter.time == pytest.approx(1e-6 + 50e-6 + 1e-6, rel=1e-3)
    assert jitter.devices == ("r",)
    assert jitter.flicker.tolist() == [0.0]


def test_a_fast_ramp_needs_the_rest_before_it():
    """Noise of a run that begins at its ramp is `1 - e^(-2 t / R C)` of k T / C, with the past all of it."""
    machine = low_pass(0.1e-6, 5e-6)
    without, with_past = (event_jitter(machine, "out", WHITE_ONLY, rest=r, rtol=1e-6) for r in (0.0, 20e-6))
    share = -math.expm1(-2.0 * without.time / 1e-6)
    assert (without.deviation / with_past.deviation) ** 2 == pytest.approx(share, abs=0.02)


def test_a_tap_has_the_shot_noise_of_the_charge_that_it_gathers():
    """`sqrt(phi q T / I)`, phi what moderate inversion leaves of shot noise: 2 % for the bends of the law.

    The tolerance of the run does not matter, though a tap's end grows from microvolts by regeneration.
    """
    coarse, fine = (event_jitter(tap(), "out[0]", WHITE_ONLY, rtol=r) for r in (2e-5, 1e-6))
    assert coarse.deviation == pytest.approx(fine.deviation, rel=2e-3)
    timer = fine.devices.index("tap.mt")
    time = fine.time - latency_tap.START
    device = latency_tap.build(latency_tap.Params(taps=1)).instances[0].circuit.device("mt")
    specific = Silicon(AMI_1500_IDEAL).law("p").square_current * device.width / device.length
    phi = float(shot_share(CURRENT, specific))
    assert math.sqrt(fine.white[timer]) == pytest.approx(
        math.sqrt(phi * ELEMENTARY_CHARGE * time / CURRENT), rel=0.02
    )
    assert next(iter(fine.shares())) == "tap.mt"


def test_a_leaking_junction_has_the_shot_noise_of_its_charge():
    """`sqrt(q T / I)`: nothing but the drain junction of a pFET that is off charges the node."""
    leaky = replace(AMI_1500_IDEAL, p=replace(AMI_1500_IDEAL.p, junction_leakage=1e-4))
    devices = (
        Transistor("hold", "n", "out", "held", "0", "0", 3e-6, 1.5e-6),
        Transistor("off", "p", "out", "vdd", "vdd", "vdd", 3e-6, 1.5e-6),
        Capacitor("c", "out", "0", 1e-12),
    )
    ports = Port("vdd", "supply"), Port("held", "event"), Port("out", "event", "out")
    wave = PiecewiseLinear((0.0, 10e-6, 11e-6), (5.0, 5.0, 0.0))
    sources = Source("vdd", "vdd", Constant(5.0)), Source("held", "held", wave)
    bench = Testbench("leak", Circuit("leak", ports, devices), sources, 20e-3, watch=("out",))
    found = event_jitter(to_kernel(bench, Silicon(leaky)), "out", WHITE_ONLY, rtol=1e-6)
    expected = math.sqrt(ELEMENTARY_CHARGE * (found.time - 11e-6) / (1e-4 * 3e-6))
    assert found.devices == ("hold", "off")
    assert math.sqrt(found.white[1]) == pytest.approx(expected, rel=0.03)
    assert sum(found.shares().values()) == pytest.approx(1.0)


def test_flicker_of_a_tap_is_the_mean_wander_of_its_gate():
    """`T d ln I` of the mean of the gate's flicker over T, within 3 %."""
    jitter = event_jitter(tap(), "out[0]", NoiseModel(0.0, 2e-25))
    timer, time = jitter.devices.index("tap.mt"), jitter.time - latency_tap.START
    device = latency_tap.build(latency_tap.Params(taps=1)).instances[0].circuit.device("mt")
    area = device.width * device.length
    steep = steepness(CURRENT, Silicon(AMI_1500_IDEAL).law("p").square_current * device.width / device.length)
    noise = SiliconNoise(flicker=NoiseModel(0.0, 2e-25))
    expected = time * math.sqrt(float(current_wander(Silicon(AMI_1500_IDEAL), noise, "p", area, time, steep)))
    assert math.sqrt(jitter.flicker[timer]) == pytest.approx(expected, rel=0.03)
    assert not jitter.flicker[jitter.devices.index("tap.mgn")]


def test_refusals_name_the_port():
    machine = low_pass(100e-6, 80e-6)
    with pytest.raises(ParameterError, match=r"low-pass\.out: 1 events, must be more than 1"):
        event_jitter(machine, "out", number=1)
    with pytest.raises(ParameterError, match=r"low-pass\.nothing: 0 events"):
        event_jitter(machine, "nothing")
