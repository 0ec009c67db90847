"""Circuits with diodes in every analysis: charge, small signals, noise, stability, gradients, temperature."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, InstanceArray, Node, Port
from circuits.devices import Capacitor, Diode, Resistor, Source
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.gradient.gradient import gradients_of
from circuits.gradient.measure import Voltage
from circuits.lowering.kernel import on_die, to_kernel
from circuits.measure.current import device_current, static_currents
from circuits.silicon.course import Course
from circuits.silicon.die import Die, shared_relative
from circuits.silicon.process import AMI_1500_IDEAL, ELEMENTARY_CHARGE, DiodeVariation
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.analysis import noise, noise_sources
from circuits.solver.noise.transient import NoiseRun, simulate_noisy
from circuits.solver.operating_point import operating_point
from circuits.solver.power import delivered_energy, node_voltages
from circuits.solver.small_signal import ac
from circuits.solver.temperature import simulate_course
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from tests.circuits.gradient.differences import by_temperature, read

SILICON = Silicon(AMI_1500_IDEAL)
D = Diode("d", "a", "o", saturation_current=1e-12, junction_capacitance=5e-12, transit_time=1e-9)
EDGE = PiecewiseLinear((1e-7, 1.1e-7, 6e-7, 6.1e-7), (0.3, 3.0, 3.0, -1.0))


def half_wave(waveform=EDGE, *more):
    devices = (D, Capacitor("c", "o", "0", 20e-12), Resistor("r", "o", "0", 1e4), *more)
    circuit = Circuit("half_wave", (Port("a", "supply"), Port("o", "analog", "out")), devices)
    return Testbench("half wave", circuit, (Source("v", "a", waveform),), 1e-6)


def test_charge_is_conserved_between_a_source_and_what_it_feeds() -> None:
    result = simulate(to_kernel(half_wave(), SILICON), rtol=1e-6)
    v, kink = node_voltages(result), np.zeros(result.time.size, np.bool_)
    kink[[0, -1]] = True
    through, given = (device_current(result.machine, v, result.time, kink, name) for name in ("d", "v"))
    # what passes the diode is what the source gives, displacement included
    np.testing.assert_allclose(-given, through, rtol=1e-9, atol=1e-15)
    energy = delivered_energy(result)["v"]
    assert 0.0 < energy < 3.0 * 5e-7 * 3e-4


def test_small_signals_at_a_point_are_those_of_conductance_and_capacitance() -> None:
    point = operating_point(half_wave(Constant(0.9)), SILICON)
    current = static_currents(point.machine, point.voltage[None])["d"][0]
    frequency = np.array([1e5, 1e7])
    g = (current + 1e-12) / (SILICON.thermal_voltage)
    drop = 0.9 - point["o"]
    assert 0.2 < drop < 0.5
    c = 5e-12 / np.sqrt(1.0 - drop) + 1e-9 * g
    own = g + 2j * np.pi * frequency * c
    load = 1e-4 + 2j * np.pi * frequency * 20e-12
    np.testing.assert_allclose(
        ac(point, "v", frequency, ("o",)).transfer[:, 0], own / (own + load), rtol=1e-9
    )
    assert point.stable


def test_a_diode_makes_shot_noise() -> None:
    point = operating_point(half_wave(Constant(0.9)), SILICON)
    sources = noise_sources(point)
    current = static_currents(point.machine, point.voltage[None])["d"][0]
    assert sources.kind == ("diode", "resistor")
    assert sources.white[0] == pytest.approx(2.0 * ELEMENTARY_CHARGE * current, rel=1e-12)
    # at low frequencies both currents see the same parallel resistance
    found = noise(point, "o", np.array([1.0]), "v")
    resistance = 1.0 / (1e-4 + (current + 1e-12) / SILICON.thermal_voltage)
    assert found.output[0] == pytest.approx(sources.white.sum() * resistance**2, rel=1e-6)
    run = simulate_noisy(to_kernel(half_wave(Constant(0.9)), SILICON), NoiseRun(step=2e-9), 3)
    assert 0.0 < np.std(run["o"] - point["o"]) < 1e-3


def test_gradients_go_through_a_diode() -> None:
    machine = to_kernel(half_wave(), SILICON)
    found = gradients_of(machine, (Voltage("o", 7e-7), Voltage("o", 8e-7)), rtol=1e-7)
    step = 1e-3
    for label, name in (("half_wave.c.capacitance", "c"), ("half_wave.r.resistance", "r")):
        ends = []
        for share in (1.0 + step, 1.0 - step):
            devices = tuple(
                replace(d, **{k: share * v for k, v in d.parameters().items()}) if d.name == name else d
                for d in machine.testbench.circuit.devices
            )
            bench = replace(machine.testbench, circuit=replace(machine.testbench.circuit, devices=devices))
            run = simulate(bench, SILICON, rtol=1e-7)
            ends.append(np.interp([7e-7, 8e-7], run.time, run["o"]))
        value = {"c": 20e-12, "r": 1e4}[name]
        wanted = (ends[0] - ends[1]) / (2.0 * step * value)
        np.testing.assert_allclose(found.by[:, found.labels.index(label)], wanted, rtol=1e-2)
    warm = found.by[0, found.labels.index("temperature")]
    assert warm == pytest.approx(by_temperature(machine, Voltage("o", 7e-7), 0.1), rel=1e-2)


def test_gradients_by_a_diodes_own_figures_are_central_differences() -> None:
    own = replace(D, area=2.0, breakdown_voltage=0.9)
    silicon = Silicon(replace(AMI_1500_IDEAL, diodes=DiodeVariation(0.05, 0.1)), die=Die("A", 1003))
    # while it conducts, after charge was pushed through it, and in breakdown
    at = {"saturation_current": 5e-7, "emission": 5e-7, "area": 5e-7, "breakdown_voltage": 8e-7}
    at |= dict.fromkeys(("junction_capacitance", "junction_potential", "grading", "transit_time"), 6.3e-7)

    def bench(**figures: float) -> Testbench:
        plain = half_wave()
        devices = (replace(own, **figures), *plain.circuit.devices[1:])
        return replace(plain, circuit=replace(plain.circuit, devices=devices))

    machine = to_kernel(bench(), silicon)
    times = sorted({*at.values()})
    found = gradients_of(machine, [Voltage("o", t) for t in times], rtol=1e-7)
    made = float(machine.kernel.diodes.saturation[0]) / (2.0 * D.saturation_current)
    for name, time in at.items():
        value = getattr(own, name)
        ends = [
            read(to_kernel(bench(**{name: value * (1.0 + step)}), silicon), Voltage("o", time))
            for step in (1e-2, -1e-2)
        ]
        by = found.by[times.index(time), found.labels.index(f"half_wave.d.{name}")]
        by *= value * (made if name == "saturation_current" else 1.0)
        assert by == pytest.approx((ends[0] - ends[1]) / 2e-2, rel=1.5e-2), name
    k = found.labels.index("process.diode.shared.saturation_current")
    own_k, all_of = found.labels.index("half_wave.d.saturation_current"), found.by[times.index(5e-7)]
    dies = [silicon.die.with_("process.diode", "saturation_current", moved) for moved in (5e-3, -5e-3)]
    ends = [read(on_die(machine, die), Voltage("o", 5e-7)) for die in dies]
    about_zero = all_of[k] * (1.0 + shared_relative(silicon.die, silicon.process, *SHARED_DRAW))
    assert about_zero == pytest.approx((ends[0] - ends[1]) / 1e-2, rel=1e-3)
    assert found.sigma[k] == 0.1
    assert found.sigma[own_k] == pytest.approx(D.saturation_current * 0.025, rel=0.3)


SHARED_DRAW = ("diode", "saturation_current", 0.1)


def test_a_charge_that_begins_with_held_voltages_moves_what_follows() -> None:
    bench = replace(half_wave(Constant(0.0)), begin="uic", initial={"o": 0.6}, stop=2e-7)
    found = gradients_of(to_kernel(bench, SILICON), (Voltage("o", 1e-7),), rtol=1e-7)
    ends = []
    for share in (1.01, 0.99):
        devices = (replace(D, junction_capacitance=share * 5e-12), *bench.circuit.devices[1:])
        moved = replace(bench, circuit=replace(bench.circuit, devices=devices))
        ends.append(read(to_kernel(moved, SILICON), Voltage("o", 1e-7)))
    by = found.by[0, found.labels.index("half_wave.d.junction_capacitance")]
    assert by * 5e-12 == pytest.approx((ends[0] - ends[1]) / 2e-2, rel=1e-3)
    assert found.notes == ("",)
    # a source that is not at 0 V charges the node through the diode's capacitance before the run begins
    kicked = replace(bench, circuit=bench.circuit, sources=half_wave(Constant(0.3)).sources)
    (note,) = gradients_of(to_kernel(kicked, SILICON), (Voltage("o", 1e-7),), rtol=1e-6).notes
    assert note.startswith("uic: sources move o by 0.051")


def test_temperature_moves_a_diode_while_it_runs_and_a_die_does_not() -> None:
    bench = half_wave(Constant(0.9))
    course = Course(((0.0, 27.0), (1e-6, 60.0)))
    result = simulate_course(bench, SILICON, course)
    ends = [operating_point(bench, replace(SILICON, temperature_c=t))["o"] for t in (27.0, 60.0)]
    assert result["o"][0] == pytest.approx(ends[0], abs=1e-6)
    # 25 pF on the diode's 500 Ohm lag 12 ns behind a ramp of 1 us
    assert result["o"][-1] == pytest.approx(ends[1], abs=0.02 * (ends[1] - ends[0]))
    machine = to_kernel(bench, SILICON)
    moved = on_die(machine, Die("A", 3))
    assert operating_point(moved)["o"] == operating_point(machine)["o"]


def test_an_array_of_diodes_has_figures_of_its_own() -> None:
    cell = Circuit("cell", (Port("a", "analog"), Port("o", "analog", "out")), half_wave().circuit.devices)
    rows = {"d.saturation_current": (1e-12, 1e-10), "d.junction_capacitance": (0.0, 5e-12)}
    array = InstanceArray("cell", cell, (2,), {"a": "a", "o": "o"}, rows)
    circuit = Circuit("two", (Port("a", "supply"),), (), (array,), (Node("o", (2,)),))
    bench = Testbench("two", circuit, (Source("v", "a", EDGE),), 1e-6)
    both = simulate(bench, SILICON)
    for k in range(2):
        figures = {name.partition(".")[2]: value[k] for name, value in rows.items()}
        alone = half_wave()
        devices = (replace(D, **figures), *alone.circuit.devices[1:])
        own = simulate(replace(alone, circuit=replace(alone.circuit, devices=devices)), SILICON)
        apart = both[f"o[{k}]"] - np.interp(both.time, own.time, own["o"])
        assert np.abs(apart).max() < 2e-3


def test_diodes_in_a_row_start_though_nothing_else_stores_charge() -> None:
    devices = (Diode("d", "a", "o", junction_capacitance=4e-12), replace(D, name="e", anode="o", cathode="0"))
    circuit = Circuit("row", (Port("a", "supply"),), (Resistor("r", "b", "a", 1e3), *devices))
    circuit = replace(circuit, devices=(replace(devices[0], anode="b"), *circuit.devices[:1], devices[1]))
    bench = Testbench("row", circuit, (Source("v", "a", EDGE),), 1e-6)
    result = simulate(bench, SILICON)
    rest = operating_point(bench, SILICON, time=5e-7)
    assert np.interp(5e-7, result.time, result["o"]) == pytest.approx(rest["o"], abs=1e-4)
