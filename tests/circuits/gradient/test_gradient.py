"""Gradients by the adjoint run against central differences and closed forms.

A difference is in order where, times the parameter's sigma, it is 1 % of what the measure moves by over dies.
"""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor, OperationalAmplifier, Resistor, Source
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import ParameterError, UnknownNameError
from circuits.gradient.gradient import gradients_of
from circuits.gradient.measure import (
    Crossing,
    Current,
    Energy,
    Extreme,
    Integral,
    Measured,
    SpikeTime,
    Voltage,
)
from circuits.gradient.reading import Passage, nears_of
from circuits.gradient.small_signal.small_signal import small_signal_gradients
from circuits.gradient.small_signal.spectrum import Spectrum
from circuits.gradient.small_signal.transfer import Transfer
from circuits.gradient.stimulus import own_moves
from circuits.gradient.way import Way
from circuits.lowering.bias_moves import behind_bias
from circuits.lowering.kernel import on_die, to_kernel
from circuits.registry import load_block
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from tests.circuits.gradient.differences import by_deviation, by_deviations, by_temperature, read

OWN = "rebound_neuron.inhibition.mi5.v_t0"  # the device that sets the first spike's time
RATE = "rebound_neuron.membrane.mr2.v_t0"  # of the device by whose current the rebound ends
R, C, V, STOP = 1e6, 1e-12, 2.0, 4e-6


def neuron(die=NOMINAL, kind=None, **stimuli):
    block = load_block("rebound-neuron")
    known = {s.name: s.default for s in block.stimuli}
    bench = block.testbench(rebias(block.build(), kind=kind), {**known, **stimuli}, block.process.v_dd)
    return to_kernel(bench, Silicon(block.process, 27.0, die))


def measured(name):
    return Measured(name, lambda result: load_block("rebound-neuron").measures(result)[name], name[-1])


def low_pass():
    ports = (Port("v_in", "supply"), Port("v", "analog", "out"))
    circuit = Circuit("low_pass", ports, (Resistor("r", "v_in", "v", R), Capacitor("c", "v", "0", C)))
    step = PiecewiseLinear((0.0, 1e-9), (0.0, V))
    return to_kernel(Testbench("low pass", circuit, (Source("in", "v_in", step),), STOP))


def by(found, metric, label):
    return found.by[metric, found.labels.index(label)]


def test_low_pass_has_the_gradients_of_its_closed_form():
    # v = V (1 - e^(-t/RC)) from the middle of the edge on; rtol of the run is 5e-7, here 1e-8
    at, level, tau = 1.5e-6, 1.0, R * C
    measures = (Voltage("v", at), Crossing("v", level), Integral("v"), Extreme("v"))
    found = gradients_of(low_pass(), measures, rtol=1e-8)
    t = at - 0.5e-9
    wanted = (
        -V * t / tau**2 * math.exp(-t / tau) * R,
        R * math.log(V / (V - level)),
        R * V * (math.exp(-STOP / tau) * (1.0 + STOP / tau) - 1.0),
        -V * STOP / tau**2 * math.exp(-STOP / tau) * R,
    )
    for k, by_c in enumerate(wanted):
        assert by(found, k, "low_pass.c.capacitance") == pytest.approx(by_c, rel=3e-3)
        assert by(found, k, "low_pass.r.resistance") == pytest.approx(by_c * C / R, rel=3e-3)
    assert found.notes == ("",) * 4


@pytest.mark.parametrize("die", [Die(), Die(number=1003)], ids=str)
def test_spike_of_the_rebound_neuron(die):
    machine, spike = neuron(die), SpikeTime("spike")
    found = gradients_of(machine, (spike,))
    total = float(np.sqrt(((found.by[0] * found.sigma)[found.sigma > 0.0] ** 2).sum()))
    moved = np.abs(found.by[0] * found.sigma)
    local = [k for k in np.argsort(-moved) if "process" not in found.labels[k] and moved[k] > 0.0]
    for k in [*local[:2], local[len(local) // 2]]:
        other = by_deviation(machine, spike, found.labels[k], 0.02 * found.sigma[k])
        assert abs(other - found.by[0, k]) * found.sigma[k] < 0.01 * total


def test_the_spread_is_that_of_what_varies_on_the_dies():
    spike = (SpikeTime("spike"),)
    local, process = (
        float(gradients_of(neuron(replace(NOMINAL, **{off: False})), spike).spread[0])
        for off in ("process", "mismatch")
    )
    found = gradients_of(neuron(), spike)
    moved = np.abs(found.by[0] * found.sigma)
    shared = np.array(["process" in label for label in found.labels])
    assert local == pytest.approx(float(np.linalg.norm(moved[~shared])), rel=1e-9)
    assert process == pytest.approx(float(np.linalg.norm(moved[shared])), rel=1e-9)
    slow = gradients_of(neuron(replace(NOMINAL, corner="ss")), spike)
    assert {float(x) for x, own in zip(slow.sigma, shared, strict=True) if own} == {0.0}


@pytest.mark.parametrize("kind", ["ideal", "generator"])
def test_devices_behind_biases_move_a_spike_and_are_in_its_spread(kind):
    machine, spike = neuron(kind=kind), SpikeTime("spike")
    found = gradients_of(machine, (spike,))
    moved = found.by[0] * found.sigma
    behind = [k for k, label in enumerate(found.labels) if behind_bias(label)]
    first = max(behind, key=lambda k: abs(moved[k]))
    path, _, parameter = found.labels[first].rpartition(".")
    step = 0.02 * found.sigma[first]
    ends = [read(on_die(machine, NOMINAL.with_(path, parameter, s)), spike) for s in (step, -step)]
    other = (ends[0] - ends[1]) / (2.0 * step)
    assert abs(other - found.by[0, first]) * found.sigma[first] < 0.01 * found.spread[0]
    local = math.sqrt(sum(moved[k] ** 2 for k, x in enumerate(found.labels) if "process" not in x))
    own = math.sqrt(local**2 - sum(moved[k] ** 2 for k in behind))
    assert local > 1.3 * own  # a copy is as large as what it biases
    if kind == "ideal":
        assert moved[first] == pytest.approx(-moved[found.labels.index(OWN)], rel=0.02)


def test_temperature_of_a_spike_and_of_an_operating_point():
    machine = neuron()
    for measure, step in ((SpikeTime("spike"), 0.01), (Voltage("v_mem"), 0.05)):
        found = gradients_of(machine, (measure,))
        assert by(found, 0, "temperature") == pytest.approx(by_temperature(machine, measure, step), rel=0.01)


@pytest.mark.parametrize("name", ["membrane.mr1", "inhibition.mi5"])
@pytest.mark.parametrize("size", ["width", "length"])
def test_sizes_of_the_rebound_neuron(name, size):
    # a circuit with other sizes, biases held at their voltages
    machine, spike = neuron(Die(number=1000)), SpikeTime("spike")
    found = gradients_of(machine, (spike,))
    bench = machine.testbench
    given = len(bench.sources)
    lines = [
        Source(n, n, Constant(float(machine.polylines[given + k][1][0])))
        for k, n in enumerate(machine.source_names[given:])
    ]
    ends, owner, device = [], *name.split(".")
    length = getattr(bench.circuit.device(name), size)
    for step in (1e-3, -1e-3):
        instances = tuple(
            replace(i, parameters={**i.parameters, f"{device}.{size}": length * (1.0 + step)})
            if i.name == owner
            else i
            for i in bench.circuit.instances
        )
        circuit = replace(bench.circuit, instances=instances)
        moved = replace(bench, circuit=circuit, sources=(*bench.sources, *lines))
        ends.append(read(to_kernel(moved, machine.silicon), spike))
    wanted = (ends[0] - ends[1]) / (2e-3 * length)
    assert by(found, 0, f"rebound_neuron.{name}.{size}") == pytest.approx(wanted, rel=0.02)


def test_number_of_a_run_has_the_gradient_of_what_it_reads():
    machine = neuron()
    own = Measured("gap", lambda result: float(result.spikes["spike"][0] - 1e-3), "s")
    found = gradients_of(machine, (own, SpikeTime("spike"), measured("t_inh_s"), measured("t_reb_s")))
    np.testing.assert_allclose(found.by[0], found.by[1], rtol=1e-5, atol=1e-12)
    # from the call on to the release, and from there to the spike that ends the rise
    np.testing.assert_allclose(found.by[2] + found.by[3], found.by[1], rtol=1e-5, atol=1e-12)


def test_a_number_that_is_an_extreme_has_the_gradient_of_one():
    """Its neighbours are within a millionth of a volt of it: the spread was told 2,600 times too large."""
    peak = Measured("peak", lambda result: float(result["v_mem"].max()), "V")
    found = gradients_of(neuron(), (peak, Extreme("v_mem")))
    assert found.spread[0] == pytest.approx(found.spread[1], rel=1e-4)
    np.testing.assert_allclose(
        found.by[0] * found.sigma, found.by[1] * found.sigma, atol=1e-4 * found.spread[1]
    )


@pytest.mark.parametrize("off", [5e-3, 6e-3, 7e-3])
def test_the_time_of_a_peak_and_its_height_have_gradients(off):
    """Where no spike ends the rise. Samples that are moved alike leave the time of a peak where it is."""
    die = NOMINAL.with_("rebound_neuron.membrane.mr1", "v_t0", off)
    machine = neuron(die, echo=None)
    measures = (measured("t_reb_s"), measured("v_mem_peak_V"))
    assert (off_by(machine, measures, (OWN, RATE), 0.1) <= 0.01).all()


def test_measures_without_a_gradient_say_why():
    machine = neuron(echo=None)
    whole = Measured("mean", lambda result: float(result.voltage.mean()), "V")
    step = Measured("step", lambda result: float(result.time[np.argmax(result["v_mem"])]), "s")
    wanted = (SpikeTime("spike"), SpikeTime("spike", 5), whole, Voltage("v_mem", 1.0), step)
    found = gradients_of(machine, wanted)
    assert np.isnan(found.by).all()
    assert "spikes; spike comes to" in found.notes[1]
    assert "depends on the whole run" in found.notes[2]
    assert "the run ends at" in found.notes[3]
    assert "reads the time of a step" in found.notes[4]
    with pytest.raises(ParameterError, match="no measure"):
        gradients_of(machine, ())


def off_by(machine, measures, labels, step):
    """Largest difference to a central difference, times sigma, in the spread of each measure."""
    found = gradients_of(machine, measures)
    assert found.notes == ("",) * len(measures)
    worst = np.zeros(len(measures))
    for label in labels:
        sigma = found.sigma[found.labels.index(label)]
        other = by_deviations(machine, measures, label, step * sigma)
        own = found.by[:, found.labels.index(label)]
        worst = np.maximum(worst, np.abs(other - own) * sigma / found.spread)
    return worst


def spiking(name, die):
    block = load_block(name)
    return to_kernel(block.bench(), Silicon(block.process, 27.0, Die(number=die)))


def test_currents_of_a_low_pass_have_the_gradients_of_their_closed_forms():
    # i = V/R e^(-t/RC) from the middle of the edge on, into the capacitor and out of the source
    at, tau = 1.5e-6, R * C
    measures = (
        Current("r", at), Current("c", at), Current("in", at),
        Integral("i(r)", at), Energy("in"), Crossing("i(r)", 1e-6, rising=False), Current("r"),
    )  # fmt: skip
    found = gradients_of(low_pass(), measures, rtol=1e-9)
    t, end, edge = at - 0.5e-9, STOP - 0.5e-9, 1e-9
    now, last = (V / R * math.exp(-x / tau) for x in (t, end))
    lost = V**2 / R * edge / 6.0  # of the energy of a step, within the edge
    energy = V * tau * (V / R - last) - lost
    wanted = [now, now, -now, tau * (now - last), energy, 0.5e-9 + tau * math.log(V / R / 1e-6), 0.0]
    np.testing.assert_allclose(found.values, wanted, rtol=2e-5, atol=1e-18)
    by_r = (t / tau - 1.0) * now
    wanted_r = [by_r, by_r, -by_r, now * t - last * end, lost - V * last * end]
    wanted_r += [tau * math.log(V / R / 1e-6) - tau]
    by_c = now * t / tau
    wanted_c = [by_c, by_c, -by_c, tau * (now - last) + now * t - last * end]
    wanted_c += [V * tau * (V / R - last) - V * last * end, tau * math.log(V / R / 1e-6)]
    for label, one, wanted in (("r.resistance", R, wanted_r), ("c.capacitance", C, wanted_c)):
        own = one * found.by[:, found.labels.index(f"low_pass.{label}")]
        np.testing.assert_allclose(own, [*wanted, 0.0], rtol=1e-3, atol=1e-18)


def test_currents_of_the_rebound_neuron_are_those_of_differences():
    measures = (
        Current("vdd"), Current("vdd", 5e-3), Integral("i(vdd)"), Energy("vdd", 3e-3, 13e-3),
        Extreme("i(inhibition.c_inh)"), Integral("i(inhibition.mi1)", 1.6e-3, 11.2e-3),
    )  # fmt: skip
    machine = neuron(Die(number=1000))
    assert off_by(machine, measures, ("process.p.shared.v_t0",), 0.01).max() < 0.01
    wanted = by_temperature(machine, measures[1], 0.01)
    assert by(gradients_of(machine, measures), 1, "temperature") == pytest.approx(wanted, rel=2e-3)


def test_currents_that_are_none_are_named():
    for measure, text in (
        (Current("nothing"), "rebound_neuron current nothing: unknown"),
        (Integral("i(v_mem)"), "rebound_neuron current v_mem: unknown"),
        (Energy("v_mem"), "rebound_neuron source of voltage v_mem: unknown"),
    ):
        with pytest.raises(UnknownNameError, match=text):
            gradients_of(neuron(), (measure,))
    found = gradients_of(neuron(), (Current("vdd", 1.0), Energy("vdd", 1.0)))
    assert "the run ends at" in found.notes[0]
    assert "must be rising times of the run" in found.notes[1]


def test_what_lies_behind_fast_edges_is_that_of_differences():
    """With steps that stand still, edges lost half of what moves the third spike and all behind it."""
    measures = (
        *(SpikeTime("spike", number) for number in range(3)),
        Crossing("spike", 0.9, rising=False, number=1),
        *(Voltage(node, 4.6) for node in ("v_mem", "low", "v_o")),
        Extreme("v_o", begin=2.3, end=3.0),
        Extreme("v_mem", highest=False, begin=2.3, end=4.6),
        Integral("v_mem", 2.3, 4.6),
        Integral("spike"),
    )
    found = off_by(
        spiking("axon-hillock", 3000), measures, ("process.n.shared.v_t0", "axon_hillock.m1n.v_t0"), 0.005
    )
    assert found.max() < 0.01


def test_fourth_spike_of_an_adaptive_neuron_is_that_of_differences():
    """It was wrong by 22 % of its spread."""
    measures = (SpikeTime("spike", 3), Voltage("v_mem", 0.0183), Voltage("soma.back", 0.0183))
    assert off_by(spiking("adaptive-neuron", 3000), measures, ("process.n.shared.v_t0",), 0.01).max() < 0.01


def test_integral_whose_edges_move_by_far_more_is_that_of_differences():
    """Spikes that come later leave an integral as it is: mk5 was told to move it by 76 times as much."""
    machine = spiking("nef-neuron", 3002)
    own = next(x for x in gradients_of(machine, (SpikeTime("spike"),)).labels if x.endswith("mk5.v_t0"))
    spikes, whole = Integral("spike"), Integral("spike", end=1e-3)
    assert off_by(machine, (spikes, whole, SpikeTime("spike")), (own,), 0.02).max() < 0.01


def test_extreme_behind_an_edge_that_moves_far_is_that_of_differences():
    # the spike lasts microseconds, and comes milliseconds earlier or later on other dies
    measures = (Extreme("inhibition.callb", highest=False), Integral("spike"), Voltage("v_mem"))
    assert off_by(neuron(Die(number=1003)), measures, ("process.n.shared.v_t0", OWN), 0.02).max() < 0.01


def test_what_follows_a_sine_keeps_the_times_of_its_steps():
    """With steps that moved there an integral was wrong by 10 % of its spread."""
    measures = (Integral("envelope"), Crossing("envelope", 1.556, rising=False), Voltage("v_e", 0.00075))
    assert off_by(spiking("envelope-detector", 3000), measures, ("process.n.shared.v_t0",), 0.02).max() < 0.01


def test_extreme_of_a_window_is_that_of_its_end_where_it_goes_on_beyond():
    found = gradients_of(low_pass(), (Extreme("v", end=1.5e-6), Voltage("v", 1.5e-6)))
    assert found.values[0] == found.values[1]
    np.testing.assert_allclose(found.by[0], found.by[1], rtol=1e-12)


@pytest.mark.parametrize(
    "label", ["process.n.shared.v_t0", "process.p.shared.v_t0", "onset_neuron.generator.comparator.mc7.v_t0"]
)
def test_energy_beside_an_amplifier_that_sources_drive_is_that_of_differences(label):
    # its gain is 1e4, so that 1e-5 V at its inputs is no small step
    block, measure = load_block("onset-neuron"), Energy("vdd")
    machine = to_kernel(block.bench(), Silicon(block.process))
    found = gradients_of(machine, (measure,))
    k = found.labels.index(label)
    other = by_deviation(machine, measure, label, 0.01 * found.sigma[k])
    assert abs(other - found.by[0, k]) * found.sigma[k] < 1e-4 * found.spread[0]


def comparator(v_ref=0.6, ramp=1e-4):
    """An amplifier of a gain of 1e4 without feedback, whose reference is a bias's line."""
    parts = (
        OperationalAmplifier("a", "v_in", "v_ref", "out", "v_dd", gain=1e4, output_resistance=1e4),
        Capacitor("c", "out", "0", 1e-9),
    )
    ports = (
        Port("v_dd", "supply"), Port("v_in", "analog"), Port("v_ref", "bias"), Port("out", "analog", "out")
    )  # fmt: skip
    biases = (Bias("v_ref", "v_ref", "voltage", v_ref),)
    rising = PiecewiseLinear((0.0, 1e-3), (0.6 + 4e-5 - ramp, 0.6 + 4e-5 + ramp))
    sources = (Source("v_dd", "v_dd", Constant(1.8)), Source("v_in", "v_in", rising))
    return to_kernel(
        Testbench("comparator", Circuit("comparator", ports, parts, biases=biases), sources, 1e-3)
    )


def test_bias_at_an_amplifier_moves_a_run_as_differences_do():
    measures = (Voltage("out", 0.4e-3), Voltage("out", 0.2e-3), Integral("out"), Energy("v_dd", 0.0, 0.5e-3))
    found = gradients_of(comparator(), measures)
    for k, measure in enumerate(measures):
        wanted = (read(comparator(0.6 + 1e-7), measure) - read(comparator(0.6 - 1e-7), measure)) / 2e-7
        assert by(found, k, "bias.v_ref") == pytest.approx(wanted, rel=2e-3)


def test_source_and_bias_at_an_amplifier_move_small_signals_as_differences_do():
    measure = Transfer("mag", "out", "v_in", 100.0)

    def at(v_ref):
        return measure.read(Spectrum(operating_point(comparator(v_ref, ramp=0.0)))).value

    machine = comparator(ramp=0.0)
    found = small_signal_gradients(machine, (measure,), moves=own_moves(machine))
    wanted = (at(0.6 + 1e-7) - at(0.6 - 1e-7)) / 2e-7
    assert by(found, 0, "bias.v_ref") == pytest.approx(wanted, rel=1e-4)
    assert by(found, 0, "source.v_in.value") == pytest.approx(-wanted, rel=1e-4)


def test_voltage_of_a_bias_line_is_moved_by_what_sets_it():
    machine = neuron(kind="ideal")
    measures = (Voltage("v_inh_tau", 5e-3), Integral("v_inh_tau"))
    found, stop = gradients_of(machine, measures), machine.testbench.stop
    value = machine.testbench.circuit.bias("i_inh_tau").value
    share = 1e-3 * value
    wanted = difference_of_bias(share) / (2.0 * share)
    assert by(found, 0, "bias.i_inh_tau") == pytest.approx(wanted, rel=1e-4)
    assert by(found, 1, "bias.i_inh_tau") == pytest.approx(wanted * stop, rel=1e-4)
    kelvin = by_temperature(machine, measures[0], 0.1)
    assert by(found, 0, "temperature") == pytest.approx(kelvin, rel=1e-3)
    assert by(found, 0, "process.n.shared.v_t0") == pytest.approx(
        by_deviation(machine, measures[0], "process.n.shared.v_t0", 1e-4), rel=1e-3
    )


def difference_of_bias(step):
    block = load_block("rebound-neuron")
    circuit, stimuli = block.build(), {s.name: s.default for s in block.stimuli}
    ends = []
    for value in (circuit.bias("i_inh_tau").value + s for s in (step, -step)):
        moved = rebias(circuit, {"i_inh_tau": value}, kind="ideal")
        machine = to_kernel(block.testbench(moved, stimuli, block.process.v_dd), Silicon(block.process))
        ends.append(read(machine, Voltage("v_inh_tau", 5e-3)))
    return ends[0] - ends[1]


def told(values, level, sign=1.0, **how):
    """What comes near a level before the last time at which a waveform passes it, and how near."""
    y = np.array(values)[:, None]
    rows, none = len(y), np.zeros(len(y))
    way = Way(np.arange(float(rows)), y, np.zeros((rows, 3)), none, y, none, none)
    over = sign * (y[:, 0] - level) >= 0.0
    row = int(np.flatnonzero(over[1:] & ~over[:-1])[-1]) + 1
    found = nears_of(Passage(way, 0, level, sign, row, None), "it", "A from the level", **how)
    return [(near.what, round(near.margin, 6)) for near in found]


RISES = [0.0, 0.8, 0.2, 0.95, 0.949, 0.95, 0.5, 1.6, 1.2, 1.3, 0.7, 1.1, 2.0, 1.0]


def test_what_comes_near_a_level_is_told_with_how_near():
    """A ripple and what lies behind the crossing are no events."""
    vanishes, comes, goes = "it vanishes", "another one appears before it", "one vanishes before it"
    assert told(RISES, 1.0) == [(vanishes, 1.0), (comes, 0.05), (goes, 0.3)]
    # before a spike no dip counts
    assert told(RISES, 1.0, arms=True) == [(vanishes, 1.0), (comes, 0.05), (goes, 0.6)]
    assert told([-x for x in RISES], -1.0, -1.0) == told(RISES, 1.0)
    assert told([0.0, 0.9, 0.8996, 1.2, 0.0], 1.0) == [(vanishes, 0.2)]


def test_a_crossing_near_its_peak_says_that_it_vanishes():
    machine = neuron()
    peak = gradients_of(machine, (Extreme("v_mem"),))
    level = float(peak.values[0] - 2.0 * peak.spread[0])
    found = gradients_of(machine, (Crossing("v_mem", level), Crossing("v_mem", level - 0.1)))
    assert re.search(r"crossing 0 vanishes (1\.9|2) sigma away", found.notes[0])
    assert "vanishes" not in found.notes[1]


def test_an_extreme_says_how_near_another_one_is():
    """Behind the spike the membrane rebounds once more, below its threshold on the nominal die."""
    machine = neuron()
    found = gradients_of(machine, (Extreme("v_mem"), Extreme("v_mem", end=1e-2)))
    assert "another extreme is the highest 1.7 sigma away, 0.261 V from it" in found.notes[0]
    assert found.notes[1] == ""
    again = gradients_of(machine, (Extreme("v_mem", begin=1e-2),))
    rate = again.by[0, again.labels.index(RATE)]
    die = NOMINAL.with_(*RATE.rsplit(".", 1), 0.3 / rate)
    runs = [simulate(on_die(machine, each), rtol=1e-6) for each in (NOMINAL, die)]
    late = [run["v_mem"][run.time > 1e-2].max() for run in runs]
    assert late[0] < found.values[0] - 0.2
    assert late[1] > found.values[0] - 1e-3
    assert [run.spikes["spike"].size > 1 for run in runs] == [False, True]


def test_a_current_that_hardly_passes_a_level_says_so():
    machine = neuron()
    peak = gradients_of(machine, (Extreme("i(excitation.me5)"),))
    level = float(peak.values[0] - peak.spread[0])
    found = gradients_of(machine, (Crossing("i(excitation.me5)", level),))
    assert "one vanishes before crossing 0 1.1 sigma away" in found.notes[0]
    assert "A from the level" in found.notes[0]
