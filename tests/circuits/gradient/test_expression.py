"""Gradients of expressions against those of what they read, and against differences."""

import math
from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Resistor, Source
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.gradient.expression import Expression
from circuits.gradient.gradient import gradients_of
from circuits.gradient.measure import Current, Energy, Extreme, Integral, SpikeTime
from circuits.gradient.stimulus import own_moves
from circuits.lowering.kernel import on_die, to_kernel
from circuits.measure.measure import read_measures
from circuits.measure.scope import TransientRecord, scope_of
from circuits.registry import load_block
from circuits.silicon.die import Die, shared
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from tests.circuits.gradient.differences import RTOL, by_deviations, by_temperatures

R, C = 1e6, 1e-12


@pytest.fixture(scope="module")
def machine():
    block = load_block("rebound-neuron")
    return to_kernel(block.bench(), Silicon(block.process, 27.0, Die(number=1003)))


def expressions(machine, *texts):
    return tuple(Expression(each) for each in read_measures(texts, scope_of(machine)))


def test_functions_of_one_waveform_are_the_measures_that_they_are(machine):
    asked = expressions(
        machine,
        "energy(vdd, from=3ms, to=13ms)", "integral(i(vdd))", "mean(i(vdd), from=1ms, to=9ms)",
        "value(i(vdd), at=5ms)", "max(i(axon.ma8))", "cross(spike, 2.5, rise) - cross(call, 2.5, rise)",
    )  # fmt: skip
    same = (
        Energy("vdd", 3e-3, 13e-3), Integral("i(vdd)"), Integral("i(vdd)", 1e-3, 9e-3), Current("vdd", 5e-3),
        Extreme("i(axon.ma8)"), SpikeTime("spike"),
    )  # fmt: skip
    scale = np.array([1.0, 1.0, 1.0 / 8e-3, 1.0, 1.0, 1.0])
    own, other = gradients_of(machine, asked), gradients_of(machine, same)
    assert own.notes == ("",) * len(asked)
    np.testing.assert_allclose(own.values[:-1], (scale * other.values)[:-1], rtol=1e-4)
    tolerance = 1e-6 * scale * other.spread
    assert (np.abs(own.by - scale[:, None] * other.by) * own.sigma <= tolerance[:, None]).all()


def test_arithmetic_goes_by_the_chain_rule(machine):
    asked = expressions(machine, "energy(vdd, to=9ms) / mean(v_mem)", "max(v_mem)^2 * value(i(vdd), at=5ms)")
    own = gradients_of(machine, asked)
    label = "process.n.shared.v_t0"
    at = own.labels.index(label)
    wanted = by_deviations(machine, asked, label, 0.005 * own.sigma[at])
    assert (np.abs(own.by[:, at] - wanted) * own.sigma[at] < 0.01 * own.spread).all()


@pytest.fixture(scope="module")
def rooted(machine):
    asked = expressions(
        machine, "rms(i(vdd))", "rms(i(axon.ma8), from=2ms)", "rms(i(inhibition.c_inh), to=9ms)",
        "rms(v_mem, from=1ms)", "rms(i(vdd))^2 / rms(v_mem)",
    )  # fmt: skip
    return asked, gradients_of(machine, asked)


@pytest.mark.parametrize("label", ["process.n.shared.v_t0", "process.p.shared.v_t0", "temperature"])
def test_root_mean_squares_have_the_gradients_of_differences(machine, rooted, label):
    asked, own = rooted
    assert own.notes == ("",) * len(asked)
    at = own.labels.index(label)
    if label == "temperature":
        size, wanted = 1.0, by_temperatures(machine, asked, 0.1)
    else:
        size = own.sigma[at]
        wanted = by_deviations(machine, asked, label, 0.005 * size)
    assert (np.abs(own.by[:, at] - wanted) * size < 0.01 * own.spread).all()
    assert (np.abs(wanted) * size > 0.01 * own.spread).any()


def test_root_mean_square_of_what_is_not_there_has_none(machine):
    (asked,) = expressions(machine, "rms(call, to=1us)")
    own = gradients_of(machine, (asked,))
    assert own.values[0] == 0.0
    assert np.isnan(own.by[0]).all()
    assert "can but rise" in own.notes[0]


SPIKE = "cross(spike, 2.5, rise)"
LONGEST = 18e-3  # s, of a run of other neurons: what is asked for lies before
FROM_2MS, LAST = 8, 9  # of what is `moving`: a crossing from 2 ms on, and one of a level that moves by a volt


@pytest.fixture(scope="module")
def moving(machine):
    """What has windows and levels that move with other readings, of ends at edges too, and its gradients."""
    asked = expressions(
        machine,
        f"integral(i(vdd), from=cross(call, 2.5, rise), to={SPIKE})", f"energy(vdd, to={SPIKE})",
        f"mean(v_mem, from=1.5ms, to={SPIKE})", f"rms(i(vdd), from=cross(call, 2.5), to={SPIKE})",
        f"rms(v_mem, from={SPIKE} - 1ms)", f"value(i(vdd), at={SPIKE} + 1us)",
        "value(v_mem, at=cross(spike, 0.5 * max(spike), rise))", f"max(v_mem, from=1ms, to={SPIKE})",
        f"integral(v_mem, to=cross(spike, 0.5 * max(spike, to={SPIKE} + 100us), rise, from=2ms))",
        f"mean(i(axon.ma8), from=2ms, to=cross(v_mem, value(v_mem, at={SPIKE} - 1ms), n=last))",
        f"cross(spike, 2.5, fall, from={SPIKE}) - {SPIKE}",
    )  # fmt: skip
    return asked, gradients_of(machine, asked, moves=own_moves(machine))


def values(machine, measures):
    """The measures in one run of their own."""
    record = TransientRecord(simulate(machine, rtol=RTOL))
    return np.array([measure.text.of(record).value for measure in measures])


def with_part(machine, owner, changes):
    """The machine with other parameters of a part's devices, biases held at their voltages."""
    bench = machine.testbench
    given = len(bench.sources)
    lines = [
        Source(n, n, Constant(float(machine.polylines[given + k][1][0])))
        for k, n in enumerate(machine.source_names[given:])
    ]
    instances = tuple(
        replace(i, parameters={**i.parameters, **changes}) if i.name == owner else i
        for i in bench.circuit.instances
    )
    circuit = replace(bench.circuit, instances=instances)
    return to_kernel(replace(bench, circuit=circuit, sources=(*bench.sources, *lines)), machine.silicon)


def moved_by(machine, label, step):
    """The machine with one parameter further by a step."""
    bench, silicon = machine.testbench, machine.silicon
    kind, _, rest = label.partition(".")
    if label == "temperature":
        return to_kernel(bench, replace(silicon, temperature_c=silicon.temperature_c + step))
    if kind == "process":
        path, _, field = label.rpartition(".shared.")
        at = getattr(shared(silicon.die, silicon.process, path.removeprefix("process.")), field)
        return on_die(machine, silicon.die.with_(path, field, float(at) + step))
    if kind == "bias":
        (bias,) = (each for each in bench.circuit.biases if each.name == rest)
        return to_kernel(replace(bench, circuit=rebias(bench.circuit, {rest: bias.value + step})), silicon)
    if kind == "source":
        lines = list(machine.polylines)
        own = machine.source_names.index(rest.removesuffix(".time"))
        lines[own] = (lines[own][0] + step * (lines[own][0] > 0.0), lines[own][1])
        return replace(machine, polylines=tuple(lines))
    part, device, field = rest.split(".")
    value = getattr(bench.circuit.device(f"{part}.{device}"), field)
    return with_part(machine, part, {f"{device}.{field}": value + step})


def size_of(machine, own, label):
    """A sigma of a parameter, or 1 % of it where none is drawn; of the temperature 3 K, of a time 10 us."""
    sigma = float(own.sigma[own.labels.index(label)])
    kind, _, rest = label.partition(".")
    circuit = machine.testbench.circuit
    if sigma > 0.0 or kind in {"temperature", "source"}:
        return sigma or {"temperature": 3.0, "source": 1e-5}[kind]
    if kind == "bias":
        return 0.01 * next(b for b in circuit.biases if b.name == rest).value
    device, _, field = rest.rpartition(".")
    return 0.01 * getattr(circuit.device(device), field)


@pytest.mark.parametrize(
    ("label", "share"),
    [
        ("process.n.shared.v_t0", 0.005), ("process.p.shared.v_t0", 0.005), ("process.n.shared.beta", 0.005),
        ("temperature", 0.003), ("bias.i_inh_tau", 0.02), ("source.call.time", 0.1),
        ("rebound_neuron.membrane.mr1.width", 0.1), ("rebound_neuron.inhibition.mi5.length", 0.1),
        ("rebound_neuron.inhibition.c_inh.capacitance", 0.1),
    ],
)  # fmt: skip
def test_windows_that_move_with_other_readings_have_the_gradients_of_differences(
    machine, moving, label, share
):
    """share: of its size, by which the parameter is moved."""
    asked, own = moving
    # the process moves the spike by milliseconds
    assert {k for k, note in enumerate(own.notes) if note} == {FROM_2MS, LAST}
    assert "one vanishes before crossing 0 0.94 sigma away" in own.notes[LAST]
    assert own.notes[FROM_2MS].startswith("it leaves the window 1.5 sigma away")
    size = size_of(machine, own, label)
    ends = [values(moved_by(machine, label, sign * share * size), asked) for sign in (1.0, -1.0)]
    wanted = (ends[0] - ends[1]) / (2.0 * share)
    found = size * own.by[:, own.labels.index(label)]
    # asked for: 1 %
    assert (np.abs(found - wanted) < 0.001 * own.spread).all()
    assert (np.abs(wanted) > 1e-3 * own.spread).any()


@pytest.mark.parametrize(
    ("name", "die", "texts"),
    [
        (
            "onset-neuron", 1001,
            (
                f"energy(vdd, to={SPIKE})", f"integral(i(vdd), from={SPIKE} - 100us, to={SPIKE})",
                f"rms(v_amp, to={SPIKE})", f"max(i(vdd), from={SPIKE} - 50us, to={SPIKE} - 20us)",
            ),
        ),
        (
            "adaptive-neuron", 3000,
            (
                "energy(vdd, from=cross(spike, 0.9, rise, 2), to=cross(spike, 0.9, rise, 3))",
                "mean(v_mem, from=cross(spike, 0.9, fall), to=cross(spike, max(spike, to=6ms) / 2, rise, 2))",
                "value(i(vdd), at=cross(spike, 0.9, rise, from=cross(spike, 0.9, fall)) - 1ms)",
            ),
        ),
    ],
)  # fmt: skip
def test_windows_of_other_neurons_have_the_gradients_of_differences(name, die, texts):
    block = load_block(name)
    bench = replace(block.bench(), stop=min(block.bench().stop, LONGEST))
    machine = to_kernel(bench, Silicon(block.process, 27.0, Die(number=die)))
    asked = expressions(machine, *texts)
    own = gradients_of(machine, asked)
    assert own.notes == ("",) * len(asked)
    for label in ("process.n.shared.v_t0", "process.p.shared.beta"):
        size = size_of(machine, own, label)
        ends = [values(moved_by(machine, label, sign * 0.005 * size), asked) for sign in (1.0, -1.0)]
        found = size * own.by[:, own.labels.index(label)]
        # asked for: 1 %
        assert (np.abs(found - (ends[0] - ends[1]) / 0.01) < 0.001 * own.spread).all()


def test_windows_of_a_low_pass_have_the_gradients_of_their_closed_forms():
    # 0 to 2 V at once: 1 V is passed at ln 2 tau, with tau = R C
    ports = (Port("v_in", "supply"), Port("v", "analog", "out"))
    circuit = Circuit("low_pass", ports, (Resistor("r", "v_in", "v", R), Capacitor("c", "v", "0", C)))
    step = Source("in", "v_in", PiecewiseLinear((0.0, 1e-12), (0.0, 2.0)))
    machine = to_kernel(Testbench("low pass", circuit, (step,), 4e-6))
    to = "to=cross(v, 1, rise)"
    asked = expressions(
        machine, f"integral(v, {to})", f"energy(in, {to})", f"integral(i(c), {to})", f"mean(v, {to})",
        "max(i(r), from=cross(v, 1, rise))", "cross(v, max(v) / 2)", f"rms(v, {to})",
    )  # fmt: skip
    own, log = gradients_of(machine, asked, rtol=1e-9), math.log(2.0)
    tau, last = R * C, 1.0 - math.exp(-4.0)
    square = 4.0 * (log - 2.0 * 0.5 + 0.5 * 0.75) / log
    wanted = (2.0 * tau * (log - 0.5), 2.0 * C, C, 2.0 - 1.0 / log, 1.0 / R)
    half = -tau * math.log(1.0 - 0.5 * last)
    np.testing.assert_allclose(own.values, (*wanted, half, math.sqrt(square)), rtol=3e-5)
    by_end = -0.5 * 4.0 * math.exp(-4.0) * tau / (1.0 - 0.5 * last)  # the run ends at 4 tau
    for label, value, by_log in (
        ("r.resistance", R, (wanted[0], 0.0, 0.0, 0.0, -1.0 / R, half + by_end, 0.0)),
        ("c.capacitance", C, (wanted[0], wanted[1], C, 0.0, 0.0, half + by_end, 0.0)),
    ):
        found = value * own.by[:, own.labels.index(f"low_pass.{label}")]
        assert (np.abs(found - by_log) < 1e-5 * np.abs(by_log) + 1e-6 * np.abs(own.values)).all()


def test_what_is_read_otherwise_is_a_number_of_the_voltages(machine):
    asked = expressions(
        machine, "max(v_mem * v_ax)", "slope(i(vdd))", "value(i(vdd), at=cross(v_mem - v_ax, 0, rise))"
    )
    own = gradients_of(machine, asked)
    assert np.isfinite(own.by[0]).all()
    assert not own.notes[0]
    for k in (1, 2):
        assert np.isnan(own.by[k]).all()
        assert "reads devices beside the run's voltages" in own.notes[k]


def test_an_expression_without_a_value_says_why(machine):
    (asked,) = expressions(machine, "cross(spike, 2.5, rise, 7) * 2")
    own = gradients_of(machine, (asked,))
    assert np.isnan(own.values[0])
    assert "does not rise through 2.5V 7 times" in own.notes[0]
