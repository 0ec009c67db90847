"""Gradients of small signals: closed forms, and central differences of circuits that are lowered anew."""

import math
from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Diode, Resistor, Source
from circuits.devices.source import Constant
from circuits.errors import ParameterError, UnknownNameError
from circuits.gradient.every import every_gradient
from circuits.gradient.measure import Voltage
from circuits.gradient.small_signal.small_signal import small_signal_gradients
from circuits.gradient.small_signal.spectrum import Spectrum
from circuits.gradient.small_signal.transfer import Corner, OfSpectrum, Transfer
from circuits.gradient.stimulus import own_moves
from circuits.lowering.kernel import to_kernel
from circuits.registry import load_block
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench
from tests.circuits.gradient.differences import by_small_signals

R, C, LOW = 1e6, 1e-12, 10.0
FULL = Die(number=1000, variation="full")
PAIRS = {  # of a block: nodes with sources that reach them
    "differential-pair": (("v_s", "v2"), ("v_s", "v_tail")),
    "wide-range-transamp": (("v_out", "v_plus"), ("v_p2", "v_tail")),
    "envelope-detector": (("envelope", "microphone"), ("envelope", "vdd")),
    "photoreceptor": (("v_sf", "v_pd"), ("v_pr", "v_prb")),
}
CURRENTS = {  # of a block: what is read of the current of a source or a device
    "differential-pair": (
        ("mag", "i(m2)", "v2", 1e4), ("db", "i(i2)", "v2", 1e6), ("db", "i(v1)", "v2", 1e5),
    ),
    "wide-range-transamp": (
        ("mag", "i(vdd)", "v_plus", 1e6), ("phase", "i(m8)", "v_plus", 1e5),
        ("db", "i(v_tail)", "v_tail", 1e4),
    ),
    "envelope-detector": (
        ("mag", "i(vdd)", "microphone", 1e4), ("db", "i(ce)", "microphone", 1e2),
        ("phase", "i(r1n)", "microphone", 1e4), ("mag", "i(mr)", "vdd", 1e4),
    ),
    "photoreceptor": (
        ("db", "i(vdd)", "v_pd", 1e4), ("mag", "i(c_pd)", "v_pd", 1e4), ("phase", "i(m_sf)", "v_prb", 1e5),
        ("mag", "i(v_prb)", "v_prb", 1e6),
    ),
}  # fmt: skip
STEP = 1e-2  # sigma, of a difference


def low_pass(quantity="voltage"):
    devices = [Capacitor("c", "v", "0", C)]
    devices += [Resistor("r", "v_in", "v", R)] if quantity == "voltage" else [Resistor("r", "v", "0", R)]
    port = Port("v_in", "supply") if quantity == "voltage" else Port("v", "analog", "out")
    circuit = Circuit("low_pass", (port,), tuple(devices))
    source = Source("s", port.name, Constant(1e-6), quantity)
    return to_kernel(Testbench("low pass", circuit, (source,), 1.0))


def lowered(name, die=NOMINAL, change=lambda circuit: circuit):
    block = load_block(name)
    return to_kernel(bench_of(block, change), Silicon(block.process, 27.0, die))


def bench_of(block, change=lambda circuit: circuit):
    """Its testbench, an amplifier's with both inputs at one voltage."""
    bench = block.bench()
    sources = [replace(s, waveform=Constant(0.9)) if s.name == "v_plus" else s for s in bench.sources]
    return replace(bench, circuit=change(bench.circuit), sources=tuple(sources))


def measures_of(name):
    found = []
    for node, source in PAIRS[name]:
        found += [Transfer(kind, node, source, 1e4) for kind in ("mag", "db", "phase")]
    return (*found, Corner(*PAIRS[name][0]), *(Transfer(*each) for each in CURRENTS[name]))


def read(machine, measures):
    spectrum = Spectrum(operating_point(machine))
    return np.array([each.read(spectrum).value for each in measures])


def difference(at, step):
    """Central difference of what `at` gives, without its error of second order."""
    one, two = ((at(s) - at(-s)) / (2.0 * s) for s in (step, 2.0 * step))
    return (4.0 * one - two) / 3.0


def by(found, metric, label):
    return found.by[metric, found.labels.index(label)]


def test_low_pass_has_the_gradients_of_its_closed_form():
    f, corner = 2e5, 1.0 / (2.0 * math.pi * R * C)
    measures = [Transfer(kind, "v", "s", f) for kind in ("mag", "db", "phase")]
    found = small_signal_gradients(low_pass(), [*measures, Corner("v", "s", low=LOW)])
    ratio = f / corner
    size, at = 1.0 / math.hypot(1.0, ratio), math.hypot(corner, math.sqrt(2.0) * LOW)
    np.testing.assert_allclose(
        found.values, (size, 20.0 * math.log10(size), -math.degrees(math.atan(ratio)), at), rtol=1e-9
    )
    by_log = (  # by ln of R, or of C
        -(ratio**2) * size**3, -20.0 / math.log(10.0) * (ratio * size) ** 2,
        -math.degrees(ratio * size**2), -(corner**2) / at,
    )  # fmt: skip
    for k, wanted in enumerate(by_log):
        assert by(found, k, "low_pass.r.resistance") * R == pytest.approx(wanted, rel=1e-9)
        assert by(found, k, "low_pass.c.capacitance") * C == pytest.approx(wanted, rel=1e-9)
    assert found.units == ("", "dB", "deg", "Hz")
    assert found.notes == ("",) * 4


def test_currents_of_a_low_pass_have_the_gradients_of_their_closed_form():
    # into the source, and through the capacitor: 2 pi f C / root(1 + ratio^2), and half a turn apart
    f, corner = 2e5, 1.0 / (2.0 * math.pi * R * C)
    ratio, size = f / corner, 2.0 * math.pi * 2e5 * C
    kinds = [Transfer(kind, f"i({name})", "s", f) for kind in ("mag", "phase") for name in ("c", "r", "s")]
    found = small_signal_gradients(low_pass(), [*kinds, Transfer("mag", "v", "s", f)])
    part = 1.0 / math.hypot(1.0, ratio)
    turn = 90.0 - math.degrees(math.atan(ratio))
    np.testing.assert_allclose(found.values[:6], (*[size * part] * 3, turn, turn, turn - 180.0), rtol=1e-9)
    assert found.units[:6] == ("S", "S", "S", "deg", "deg", "deg")
    for k in range(3):
        assert by(found, k, "low_pass.c.capacitance") * C == pytest.approx(size * part**3, rel=1e-9)
        assert by(found, k, "low_pass.r.resistance") * R == pytest.approx(
            -size * ratio**2 * part**3, rel=1e-9
        )
        for label in ("low_pass.c.capacitance", "low_pass.r.resistance"):
            assert by(found, 3 + k, label) == pytest.approx(by(found, 4, label), rel=1e-9)
    assert by(found, 4, "low_pass.c.capacitance") * C == pytest.approx(
        -math.degrees(ratio * part**2), rel=1e-9
    )


def test_share_of_a_current_has_the_gradients_of_its_closed_form():
    # what a source of current gives comes to r below the corner, and to c above it
    corner = 1.0 / (2.0 * math.pi * R * C)
    asked = (
        Corner("i(r)", "s"), Corner("i(r)", "s", 0.1, 1.0, 1e12), Transfer("mag", "i(c)", "s", corner),
        Transfer("mag", "i(s)", "s", corner), Transfer("mag", "v", "s", corner),
    )  # fmt: skip
    found = small_signal_gradients(low_pass("current"), asked)
    assert found.units == ("Hz", "Hz", "", "", "Ohm")
    at = math.hypot(corner, math.sqrt(2.0))
    np.testing.assert_allclose(
        found.values, (at, corner * math.sqrt(99.0), math.sqrt(0.5), 1.0, R * math.sqrt(0.5)), rtol=1e-9
    )
    for label, value in (("low_pass.c.capacitance", C), ("low_pass.r.resistance", R)):
        wanted = (-(corner**2) / at, -corner * math.sqrt(99.0), math.sqrt(0.5) / 2.0, 0.0)
        np.testing.assert_allclose(
            [by(found, k, label) * value for k in range(4)], wanted, rtol=1e-9, atol=1e-12
        )


def test_impedance_falls_to_an_ohm_where_its_closed_form_does():
    # |Z| = 1 where (2 pi f R C)^2 = R^2 - 1, beyond 1 GHz
    found = small_signal_gradients(
        low_pass("current"), (Corner("v", "s", 1.0, 1.0, 1e12), Transfer("mag", "v", "s", 1.0))
    )
    at = math.sqrt(R**2 - 1.0) / (2.0 * math.pi * R * C)
    assert found.values[0] == pytest.approx(at, rel=1e-9)
    assert by(found, 0, "low_pass.c.capacitance") == pytest.approx(-at / C, rel=1e-9)
    assert by(found, 0, "low_pass.r.resistance") == pytest.approx(at / (R * (R**2 - 1.0)), rel=1e-3)
    assert found.units == ("Hz", "Ohm")
    assert by(found, 1, "low_pass.r.resistance") == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "die"), [("differential-pair", NOMINAL), *((name, FULL) for name in PAIRS)], ids=str
)
def test_of_every_deviation_is_that_of_differences(name, die):
    machine, measures = lowered(name, die), measures_of(name)
    found = small_signal_gradients(machine, measures)
    assert np.isfinite(found.by).all()
    assert (found.spread > 0.0).all()
    start = operating_point(machine).voltage
    for k in np.flatnonzero(found.sigma):
        label, sigma = found.labels[k], float(found.sigma[k])
        if not label.endswith("capacitance"):
            off = np.abs(by_small_signals(machine, measures, label, STEP * sigma, start) - found.by[:, k])
            assert (off * sigma < 1e-4 * found.spread).all(), label


@pytest.mark.parametrize("name", PAIRS)
def test_of_the_temperature_is_that_of_differences(name):
    measures = measures_of(name)
    block = load_block(name)

    def at(kelvin):
        return read(to_kernel(bench_of(block), Silicon(block.process, 27.0 + kelvin, FULL)), measures)

    found = small_signal_gradients(lowered(name, FULL), measures)
    wanted = difference(at, 0.1)
    own = found.by[:, found.labels.index("temperature")]
    # 1 % of the temperature is 3 K
    assert (np.abs(own - wanted) < np.maximum(1e-3 * np.abs(wanted), 1e-5 * found.spread)).all()


def test_of_the_temperature_of_a_line_that_moves_and_stands_on_the_die():
    """The line's voltage follows the temperature, and is the source too."""
    measures = (Transfer("mag", "v_s", "v_tail", 1e4), Corner("v_s", "v_tail"))
    block = load_block("differential-pair")

    def machine(kelvin):
        bench = bench_of(block, lambda circuit: rebias(circuit, kind="ideal"))
        return to_kernel(bench, Silicon(block.process, 27.0 + kelvin, FULL))

    found = small_signal_gradients(machine(0.0), measures)
    wanted = difference(lambda kelvin: read(machine(kelvin), measures), 0.1)
    np.testing.assert_allclose(found.by[:, found.labels.index("temperature")], wanted, rtol=1e-4)


def sized(field, share):
    def changed(device):
        return replace(device, **{field: getattr(device, field) * (1.0 + share)})

    return changed


@pytest.mark.parametrize(
    ("name", "device", "field"),
    [
        ("envelope-detector", "re", "resistance"), ("envelope-detector", "r2n", "resistance"),
        ("envelope-detector", "c2p", "capacitance"), ("envelope-detector", "ce", "capacitance"),
        ("photoreceptor", "c_pd", "capacitance"),
    ],
)  # fmt: skip
def test_of_passive_devices_is_that_of_differences(name, device, field):
    measures = measures_of(name)

    def at(share):
        def change(circuit):
            own = [sized(field, share)(d) if d.name == device else d for d in circuit.devices]
            return replace(circuit, devices=tuple(own))

        return read(lowered(name, change=change), measures)

    machine = lowered(name)
    found, value = (
        small_signal_gradients(machine, measures),
        getattr(machine.testbench.circuit.device(device), field),
    )
    label = f"{machine.testbench.circuit.name}.{device}.{field}"
    own = found.by[:, found.labels.index(label)] * value
    # 1 % of it moves a measure by less than 1e-4 of the measure's sigma
    assert (0.01 * np.abs(difference(at, 1e-3) - own) < 1e-4 * found.spread).all()


@pytest.mark.parametrize("name", ["differential-pair", "wide-range-transamp", "photoreceptor"])
def test_of_biases_is_that_of_differences(name):
    measures, machine = measures_of(name), lowered(name)
    found = small_signal_gradients(machine, measures)
    labels = [label for label in found.labels if label.startswith("bias.")]
    assert labels
    for label in labels:
        bias = next(b for b in machine.testbench.circuit.biases if f"bias.{b.name}" == label)

        def at(share, bias=bias):
            values = {bias.name: bias.value * (1.0 + share)}
            return read(lowered(name, change=lambda circuit: rebias(circuit, values)), measures)

        own = found.by[:, found.labels.index(label)] * bias.value
        assert (0.01 * np.abs(difference(at, 1e-3) - own) < 1e-4 * found.spread).all(), label


@pytest.mark.parametrize("name", ["wide-range-transamp", "photoreceptor", "envelope-detector"])
def test_of_what_sources_give_is_that_of_differences(name):
    measures, machine = measures_of(name), lowered(name)
    bench, moves = machine.testbench, own_moves(machine)
    found = small_signal_gradients(machine, measures, moves=moves)
    assert [label for label in found.labels if label.startswith("source.")] == [m.step.label for m in moves]
    for source in bench.sources:
        value = np.interp(0.0, *machine.polylines[bench.sources.index(source)])
        scale = 1e-6 if source.quantity == "voltage" else 1e-3 * abs(value)

        def at(step, source=source, value=value):
            moved = replace(source, waveform=Constant(float(value + step)))
            sources = tuple(moved if s is source else s for s in bench.sources)
            return read(to_kernel(replace(bench, sources=sources), machine.silicon), measures)

        wanted = difference(at, scale)
        own = found.by[:, found.labels.index(f"source.{source.name}.value")]
        # 1 mV moves a measure by less than 1e-6 of its sigma more or less
        least = 1e-3 * found.spread * (1.0 if source.quantity == "voltage" else 1e-6 / scale)
        assert (np.abs(own - wanted) < 1e-4 * np.abs(wanted) + least).all(), source.name
        if f"source.{source.name}.time" in found.labels:  # it begins to move at 0 s, or later
            assert not found.by[:, found.labels.index(f"source.{source.name}.time")].any()


@pytest.mark.parametrize("size", ["width", "length"])
def test_of_sizes_is_that_of_differences(size):
    # biases are held at their voltages
    name, device = "photoreceptor", "m_n"
    measures, machine = measures_of(name), lowered(name, Die(number=1000))
    bench = machine.testbench
    given = len(bench.sources)
    lines = [
        Source(n, n, Constant(float(machine.polylines[given + k][1][0])))
        for k, n in enumerate(machine.source_names[given:])
    ]

    def at(share):
        own = [sized(size, share)(d) if d.name == device else d for d in bench.circuit.devices]
        circuit = replace(bench.circuit, devices=tuple(own))
        moved = replace(bench, circuit=circuit, sources=(*bench.sources, *lines))
        return read(to_kernel(moved, machine.silicon), measures)

    found = small_signal_gradients(machine, measures)
    value = getattr(bench.circuit.device(device), size)
    own = found.by[:, found.labels.index(f"{bench.circuit.name}.{device}.{size}")] * value
    assert (0.01 * np.abs(difference(at, 1e-3) - own) < 1e-4 * found.spread).all()


def diode_pass(change=lambda diode: diode, temperature=27.0):
    diode = Diode(
        "d", "v", "0", saturation_current=1e-15, emission=1.2, junction_capacitance=1e-12, transit_time=1e-8
    )
    circuit = Circuit("clamp", (Port("v_in", "supply"),), (Resistor("r", "v_in", "v", 1e5), change(diode)))
    bench = Testbench("clamp", circuit, (Source("s", "v_in", Constant(1.2)),), 1.0)
    return to_kernel(bench, Silicon(temperature_c=temperature))


FIGURES = ("saturation_current", "emission", "area", "junction_capacitance", "transit_time", "grading")


def test_of_a_diode_that_stores_charge_is_that_of_differences():
    measures = (
        Transfer("mag", "v", "s", 1e5), Transfer("phase", "v", "s", 1e6), Corner("v", "s"),
        Transfer("mag", "i(d)", "s", 1e5), Transfer("phase", "i(s)", "s", 1e6),
    )  # fmt: skip
    found = small_signal_gradients(diode_pass(), measures)
    for figure in FIGURES:

        def at(share, figure=figure):
            return read(diode_pass(sized(figure, share)), measures)

        own = found.by[:, found.labels.index(f"clamp.d.{figure}")] * getattr(
            Diode("d", "a", "c"), figure, 0.0
        )
        value = getattr(diode_pass().testbench.circuit.device("d"), figure)
        own = found.by[:, found.labels.index(f"clamp.d.{figure}")] * value
        np.testing.assert_allclose(
            own, difference(at, 1e-4), rtol=1e-4, atol=1e-9 * np.abs(found.values).max()
        )
    wanted = difference(lambda kelvin: read(diode_pass(temperature=27.0 + kelvin), measures), 0.1)
    np.testing.assert_allclose(found.by[:, found.labels.index("temperature")], wanted, rtol=1e-4)


def value_at(at):
    def of(frequency, transfer):
        return float(np.interp(at, frequency, np.abs(transfer["v"]))), ""

    return of


def of_spectrum(of, grid=(1e4, 1e5, 1e6, 1e7)):
    return OfSpectrum("own", (("s", 1.0),), ("v",), grid, of)


def test_number_of_a_grid_has_the_gradient_of_the_points_that_it_reads():
    ends = [Transfer("mag", "v", "s", f) for f in (1e5, 1e6)]
    found = small_signal_gradients(low_pass(), (of_spectrum(value_at(4e5)), *ends))
    np.testing.assert_allclose(
        found.by[0], found.by[1] * 2.0 / 3.0 + found.by[2] / 3.0, rtol=1e-6, atol=1e-12
    )
    turned = OfSpectrum("own", (("s", 2.0j),), ("v",), (1e5, 1e6), value_at(1e6))
    twice = small_signal_gradients(low_pass(), (turned, ends[1]))
    np.testing.assert_allclose(twice.by[0], 2.0 * twice.by[1], rtol=1e-6, atol=1e-12)


def test_what_has_no_gradient_says_why():
    def place(frequency, transfer):
        return float(frequency[1] + frequency[2]), ""

    def last(frequency, transfer):
        return float(frequency[-1]), ""

    def missing(frequency, transfer):
        return math.nan, "v does not pass 5"

    grid = tuple(np.geomspace(1.0, 1e9, 300).tolist())
    whole = of_spectrum(lambda _, transfer: (float(np.abs(transfer["v"]).sum()), ""), grid)
    wanted = {
        Transfer("mag", "0", "s", 1.0): "nothing of s comes to 0: a transfer of 0 has no gradient",
        Transfer("db", "0", "s", 1.0): "nothing of s comes to 0: a transfer of 0 has no decibels",
        Transfer("phase", "0", "s", 1.0): "nothing of s comes to 0: a transfer of 0 has no phase",
        Corner("0", "s"): "nothing of s comes to 0 at 1 Hz",
        Corner("v", "s", 1.0): "begins with 1 at 1 Hz, which is not above 1",
        Corner("v", "s", high=1e5): "never falls to 0.7071; it is lowest at 1e+05 Hz, 0.8467",
        of_spectrum(place): "reads the frequency of a point, which nothing moves on a grid",
        of_spectrum(last): "reads no transfer, as where it is an end of the grid",
        of_spectrum(missing): "v does not pass 5",
        whole: "depends on the whole spectrum, must be of few points of it",
    }
    found = small_signal_gradients(low_pass(), list(wanted))
    assert found.notes == tuple(wanted.values())
    assert np.isnan(found.by).all()
    np.testing.assert_array_equal(np.isnan(found.values), [False, *[True] * 5, False, False, True, False])


def test_a_transfer_that_is_lost_beside_others_has_no_gradient():
    """Its value is a product along the chain, what moves it is rounding."""
    asked = [Transfer("db", f"v_ex_tau[{k}]", "v_ex_start", 1e4) for k in (12, 0)]
    found = small_signal_gradients(lowered("bias-chain", Die(number=1002)), asked)
    assert found.notes[0] == ""
    assert np.isfinite(found.by[0]).all()
    assert found.notes[1].startswith("a transfer 2e-46 of the largest at a device, whose gradient is not ")
    assert found.values[1] < -900.0
    assert np.isnan(found.by[1]).all()


def test_a_phase_near_its_jump_tells_how_far_it_is():
    pairs = (("v_p2", "v_tail"), ("v_out", "v_plus"))
    found = small_signal_gradients(
        lowered("wide-range-transamp"), [Transfer("phase", node, source, 1e4) for node, source in pairs]
    )
    assert found.notes[0].startswith("it jumps by 360 deg ")
    assert found.notes[1] == ""


def test_what_cannot_be_asked_is_refused():
    machine = low_pass()
    for measure, text in (
        (Transfer("mag", "v", "s", 0.0), r"mag\(v,s,0Hz\): 0 Hz, must be a frequency above 0; as 1kHz"),
        (Corner("v", "s", low=-1.0), "must be a frequency above 0"),
        (Corner("v", "s", low=2.0, high=1.0), "2 to 1 Hz, must be rising frequencies"),
    ):
        with pytest.raises(ParameterError, match=text):
            small_signal_gradients(machine, (measure,))
    with pytest.raises(UnknownNameError, match="source v_in: unknown; known are s"):
        small_signal_gradients(machine, (Corner("v", "v_in"),))
    with pytest.raises(UnknownNameError, match="node x: unknown"):
        small_signal_gradients(machine, (Corner("x", "s"),))
    with pytest.raises(ParameterError, match="no measure"):
        small_signal_gradients(machine, ())


def test_measures_of_a_run_and_of_small_signals_keep_their_order():
    machine = lowered("photoreceptor")
    moves = own_moves(machine)
    asked = (Voltage("v_sf"), Corner("v_sf", "v_pd"), Voltage("v_pr"), Transfer("db", "v_sf", "v_pd", 1e3))
    found = every_gradient(machine, asked, moves=moves)
    assert found.measures == tuple(each.name for each in asked)
    assert found.units == ("V", "Hz", "V", "dB")
    for k, each in enumerate(asked):
        alone = every_gradient(machine, (each,), moves=moves)
        assert alone.labels == found.labels
        np.testing.assert_allclose(alone.by[0], found.by[k], rtol=1e-9, atol=1e-12 * np.abs(alone.by).max())
        assert alone.values[0] == found.values[k]
