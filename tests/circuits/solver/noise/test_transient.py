"""Transient noise: k T / C, the jitter of a ramp, 1/f, keys, and the same bits on any number of threads."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Source, Transistor
from circuits.devices.noise import WHITE_ONLY, NoiseModel
from circuits.devices.source import Constant, Pulse
from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.process import AMI_1500_IDEAL, BOLTZMANN, ELEMENTARY_CHARGE, kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.analysis import noise
from circuits.solver.noise.transient import (
    NoiseRun,
    grid_step,
    map_trials,
    noise_keys,
    noise_place,
    relaxations,
    simulate_noisy,
)
from circuits.solver.operating_point import operating_point
from circuits.solver.small_signal import frequency_grid, linearise, transistors_at
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from tests.circuits.solver.examples import SUPPLY, UM, C, R, low_pass, neuron
from tests.circuits.solver.noise.test_analysis import switch

OUT = Port("y", "analog", "out")


def ramp() -> Machine:
    """1 pF held at the supply by a pFET until 20 us, then emptied by 0.5 nA of an nFET."""
    devices = (
        Transistor("pull", "p", "y", "up", "vdd", "vdd", 3 * UM, 1.5 * UM),
        Transistor("sink", "n", "y", "g", "0", "0", 6 * UM, 6 * UM),
        Capacitor("c", "y", "0", 1e-12),
    )
    circuit = Circuit("ramp", (Port("vdd", "supply"), Port("up", "event"), Port("g", "bias"), OUT), devices)
    sources = (
        SUPPLY,
        Source("up", "up", Pulse(0.0, 5.0, (20e-6,), 1.0, 1e-6, 1e-6)),
        Source("g", "g", Constant(0.395)),
    )
    return to_kernel(Testbench("ramp", circuit, sources, 4e-3))


def test_k_t_over_c_of_a_resistor_and_of_a_switch() -> None:
    point = switch(0.7)
    tau = linearise(point).charge[0, 0] / transistors_at(point).conductance[0, 0]
    for bench, capacitance, time in (
        (low_pass(Constant(0.0), 4000 * R * C), C, R * C),
        (point.machine.testbench, linearise(point).charge[0, 0], tau),
    ):
        long = Testbench(bench.title, bench.circuit, bench.sources, 4000 * time)
        found = simulate_noisy(to_kernel(long), NoiseRun(3, time / 20, WHITE_ONLY))
        # 4,000 time constants know a variance to sqrt(2 / 2000) = 3 %; the grid takes 1 / (1 + 1/40): five
        # of these, where a wrong factor of two or a wrong density would be far outside
        variance = float(np.var(found["y"][2000:])) * (1.0 + 1.0 / 40)
        assert variance == pytest.approx(BOLTZMANN * kelvin(27.0) / capacitance, rel=0.15)


def test_k_t_over_c_of_a_leaking_junction() -> None:
    """The shot noise of both components of a junction without a current is that of its conductance."""
    leaky = replace(AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, junction_leakage=1e-3))
    devices = Transistor("m", "n", "y", "0", "0", "0", 6 * UM, 6 * UM), Capacitor("c", "y", "0", 1e-12)
    bench = Testbench("junction", Circuit("junction", (OUT,), devices), (), 1e-3)
    silicon = Silicon(leaky)
    machine = to_kernel(bench, silicon)
    capacitance = float(linearise(operating_point(machine)).charge[0, 0])
    time = capacitance * silicon.thermal_voltage / (1e-3 * 6 * UM)
    long = to_kernel(replace(bench, stop=4000 * time), silicon)
    found = simulate_noisy(long, NoiseRun(3, time / 20, WHITE_ONLY))
    variance = float(np.var(found["y"][2000:])) * (1.0 + 1.0 / 40)
    assert variance == pytest.approx(BOLTZMANN * kelvin(27.0) / capacitance, rel=0.15)


def test_a_membrane_at_rest_has_the_noise_of_the_noise_analysis() -> None:
    machine = to_kernel(neuron(6e-3, call=None, echo=None))
    found = simulate_noisy(machine, NoiseRun(2, 0.4e-6, WHITE_ONLY), record=("v_mem",))
    point = found.operating_point
    # up to where the grid ends, 1.25 MHz
    expected = noise(point, "v_mem", frequency_grid(1.0, 1.25e6, 10), model=WHITE_ONLY).variance
    # 1,500 time constants of 4 us know a variance to 3.7 %, and the grid takes 5 %: three of the first
    assert np.var(found["v_mem"][500:]) == pytest.approx(expected, rel=0.16)


@pytest.mark.parametrize("step", [8e-6, 4e-6])
def test_a_ramp_has_the_jitter_of_its_shot_noise_whatever_the_grid(step: float) -> None:
    machine = ramp()

    def crossing(found: Result) -> float:
        v, k = found["y"], int(np.argmax(found["y"] < 3.6))
        return float(
            found.time[k - 1] + (v[k - 1] - 3.6) / (v[k - 1] - v[k]) * (found.time[k] - found.time[k - 1])
        )

    times = np.array(map_trials(crossing, machine, NoiseRun(5, step, WHITE_ONLY), range(200), 1)) - 21e-6
    duration = float(times.mean())
    current = linear_current(machine)
    # 200 trials know a deviation to 5 %: four of these. k T / C at the release, 64 uV, adds 1 %
    assert times.std(ddof=1) == pytest.approx(np.sqrt(ELEMENTARY_CHARGE * duration / current), rel=0.2)


def linear_current(machine: Machine) -> float:
    """Current of the sink of `ramp`, A."""
    return float(transistors_at(operating_point(machine)).current[1])


def test_halving_steps_keeps_what_the_coarse_step_saw() -> None:
    """An edge in the middle of a run halves steps there; before it nothing changes, bit for bit."""
    quiet, edged = (
        to_kernel(low_pass(wave, 100e-6))
        for wave in (Constant(0.0), Pulse(0.0, 1.0, (60.3e-6,), 5e-6, 1e-7, 1e-7))
    )
    run = NoiseRun(1, 1e-6, WHITE_ONLY)
    a, b = simulate_noisy(quiet, run), simulate_noisy(edged, run)
    before = a.time < 59.5e-6
    np.testing.assert_array_equal(a["y"][before], b["y"][: before.sum()])
    assert b.steps.rejected > 0 == a.steps.rejected
    # 25 time constants of 1 us after the edge the two have met again: both saw the same currents
    assert b["y"][-1] == pytest.approx(a["y"][-1], abs=1e-9)


def test_trials_are_the_same_on_any_number_of_threads_and_differ_from_each_other() -> None:
    machine = ramp()

    def end(found: Result) -> float:
        return float(found["y"][-1])

    run = NoiseRun(7, 20e-6)
    one = map_trials(end, machine, run, range(6), 1)
    assert map_trials(end, machine, run, range(6), 3) == one
    assert map_trials(end, machine, run, [4, 2], 2) == [one[4], one[2]]
    assert len(set(one)) == 6
    assert end(simulate_noisy(machine, NoiseRun(8, 20e-6))) != one[0]
    again = simulate_noisy(machine, run, 3, record=("y",))
    assert again.nodes == ("y",)
    assert end(again) == one[3]


def test_flicker_is_added_to_the_same_white_noise() -> None:
    machine = ramp()
    white, both, strong = (
        simulate_noisy(machine, NoiseRun(7, 20e-6, model))["y"][-1]
        for model in (WHITE_ONLY, NoiseModel(1e-26, 0.0), NoiseModel(1e-24, 0.0))
    )
    # ten times the amplitude of the flicker moves the end ten times as far, to the first order in both
    assert (strong - white) / (both - white) == pytest.approx(10.0, rel=0.05)


@pytest.mark.parametrize("exponent", [0.8, 1.0, 1.2])
def test_relaxations_add_up_to_a_power_of_frequency(exponent: float) -> None:
    rate, variance = relaxations(NoiseModel(1e-24, 0.0, exponent), 1e-6)
    f = np.geomspace(10.0, 1e4, 50)
    omega = 2.0 * np.pi * f[:, None]
    density = (4.0 * rate / (rate**2 + omega**2) * variance).sum(axis=1)
    # two a decade ripple by 0.2 %; both ends are at least 1.5 decades away and take 2 % at most
    np.testing.assert_allclose(density, f**-exponent, rtol=0.03)


def test_keys_follow_the_path_and_nothing_else() -> None:
    lone = Silicon(AMI_1500_IDEAL, place=(("ranging_chip", ()), ("neuron", (2,))))
    assert noise_place(lone, "rebound_neuron") + ".membrane.m1" == "ranging_chip.neuron[2].membrane.m1"
    assert noise_place(Silicon(AMI_1500_IDEAL), "rebound_neuron") == "rebound_neuron"
    keys = noise_keys(1, 2, ["a.m1", "a.m2"])
    np.testing.assert_array_equal(keys[:, 1:], noise_keys(1, 2, ["a.m2"]))
    others = [noise_keys(0, 2, ["a.m1"]), noise_keys(1, 3, ["a.m1"]), keys[:, 1:]]
    assert len({tuple(k[:, 0]) for k in (keys, *others)}) == 4


def test_grid_steps_divide_the_run() -> None:
    machine = ramp()
    assert grid_step(machine, NoiseRun()) == pytest.approx(4e-3 / 20_000)
    assert grid_step(machine, NoiseRun(step=3e-3)) == pytest.approx(2e-3)
    assert grid_step(machine, NoiseRun(step=1.0)) == pytest.approx(4e-3)
    with pytest.raises(ParameterError, match="must be fewer"):
        grid_step(machine, NoiseRun(step=1e-15))


def test_wrong_runs_are_refused() -> None:
    for wrong in ({"seed": -1}, {"step": 0.0}, {"step": float("nan")}):
        with pytest.raises(ParameterError):
            NoiseRun(**wrong)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="trial: -1"):
        simulate_noisy(ramp(), NoiseRun(), -1)
    with pytest.raises(ParameterError, match="workers: 0"):
        map_trials(lambda found: found, ramp(), NoiseRun(), [0], 0)
