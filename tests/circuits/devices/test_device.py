"""Every device type offers what the lowerings rely on, and has every lowering."""

import math
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace
from typing import Any

import pytest

from circuits import devices
from circuits.checks import implausible_allowed
from circuits.circuit import Circuit, Port
from circuits.devices.source import Constant, PiecewiseLinear, Pulse
from circuits.errors import CircuitError, ParameterError
from circuits.lowering import analysis, graph, kernel
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench
from netlists.registry import dialect_names, load_dialect
from tests.circuits.devices.examples import EXAMPLES

# Generic functions of a device's type, the base's implementation being the refusal
LOWERINGS: dict[str, Any] = {
    "kernel": kernel.add_device,
    "graph": graph.describe_device,
    "analysis": analysis.to_equation,
    **{f"{d} {m}": f for d in dialect_names() for m, f in load_dialect(d).devices.items()},
}
REFUSED: list[tuple[Callable[[], object], str]] = [
    (lambda: devices.Capacitor("c", "a", "b", 0.0), "c.capacitance: 0 F, must be > 0"),
    (lambda: devices.Resistor("r", "a", "b", -1.0), "r.resistance: -1 Ohm, must be > 0"),
    (
        lambda: devices.ControlledSource("g", "a", "b", "c", "d", math.nan),
        "g.transconductance: nan S, must be finite",
    ),
    *(
        (
            lambda word=word: devices.Transistor("m", word, "d", "g", "s", "0", 1e-6, 1e-6),
            f"m.polarity: '{word}', must be n or p",
        )
        for word in ("nmos", "N", "nfet", "")
    ),
    (
        lambda: devices.Transistor("m", "n", "d", "g", "s", "0", 3, 1e-6),
        "m.width: 3 m, must be 10nm to 10mm; .*meant",
    ),
    (lambda: devices.Transistor("m", "n", "d", "g", "s", "0", 1e-6, 1e-9), "m.length: 1e-09 m, must be 10nm"),
    (
        lambda: devices.Transistor("m", "n", "d", "g", "s", "0", "3u", 1e-6),
        "m.width: '3u', must be a number in m",
    ),
    (
        lambda: devices.Transistor("m", "n", "d", "g", "s", "0", True, 1e-6),
        "m.width: True, must be a number in m",
    ),
    (lambda: devices.Transistor("m", "n", "d", "g", 0, "0", 1e-6, 1e-6), "m: 0, must be the name of a node"),
    (lambda: devices.Transistor(7, "n", "d", "g", "s", "0", 1e-6, 1e-6), "device.name: 7, must be a name"),
    (lambda: devices.Capacitor("c", "a", "b", 600.0), "c.capacitance: 600 F, must be 1aF to 1mF"),
    (lambda: devices.Capacitor("c", "a", "b", 1e-19), "c.capacitance: 1e-19 F, must be 1aF to 1mF"),
    (lambda: devices.Resistor("r", "a", "b", 1e-9), "r.resistance: 1e-09 Ohm, must be 1uOhm"),
    (
        lambda: devices.OperationalAmplifier("x", "p", "n", "o", "vdd", offset=1e4),
        "x.offset: 10000 V, must be at most 1kV",
    ),
    (lambda: devices.Source("i", "a", Constant(3.0), "current"), "i.waveform: 3 A, must be 1fA to 1A"),
    (lambda: devices.Source("i", "a", Constant(1e-18), "current"), "i.waveform: 1e-18 A, must be 1fA to 1A"),
    (lambda: devices.Source("v", "a", Constant(5e3)), "v.waveform: 5000 V, must be at most 1kV"),
    (
        lambda: devices.Source("v", "a", Constant(1.0), "amps"),
        "v.quantity: 'amps', must be voltage or current",
    ),
    (lambda: devices.Source("v", "a", 5.0), "v.waveform: 5.0, must be a waveform"),
    (lambda: devices.Source("v", "a", Constant("5")), "v: values: .*'5'.*, must be a number in V or A"),
    (
        lambda: devices.Source("v", "a", Pulse(0.0, 5.0, (0.0,), "1us", 1e-9, 1e-9)),
        "v: width, rise, fall: .*1us",
    ),
]


def test_every_type_has_an_example() -> None:
    assert set(EXAMPLES) == set(devices.DEVICE_TYPES)


@pytest.mark.parametrize("lowering", LOWERINGS)
@pytest.mark.parametrize("kind", devices.DEVICE_TYPES)
def test_every_type_has_every_lowering(kind: type[devices.Device], lowering: str) -> None:
    generic = LOWERINGS[lowering]
    refusal: Callable[..., object] = generic.dispatch(object)
    assert generic.dispatch(kind) is not refusal, f"{kind.__name__} has no lowering to {lowering}"


@pytest.mark.parametrize("kind", devices.DEVICE_TYPES)
def test_examples_are_sound_frozen_and_consistent(kind: type[devices.Device]) -> None:
    device = EXAMPLES[kind]
    device.check()
    attribute = "name"
    with pytest.raises((FrozenInstanceError, TypeError)):
        setattr(device, attribute, "other")
    count = len(device.terminals())
    assert all(-1 <= i < count and -1 <= j < count for i, j in device.conducting())
    for attribute in device.parameters():
        changed: Any = {attribute: 1.5 * device.parameters()[attribute]}
        assert replace(device, **changed).parameters()[attribute] == changed[attribute]


@pytest.mark.parametrize(("construct", "text"), REFUSED)
def test_constructors_refuse_what_they_do_not_know(construct: Callable[[], object], text: str) -> None:
    with pytest.raises(ParameterError, match=f"^{text}") as caught:
        construct()
    assert "\n" not in str(caught.value)


def test_a_size_that_is_meant_is_taken_and_stays_so() -> None:
    large = devices.Capacitor("c", "a", "b", 0.1, allow_implausible=True)
    assert replace(large, capacitance=0.2).capacitance == 0.2
    with implausible_allowed():
        inside = devices.Capacitor("c", "a", "b", 0.1)
    assert replace(inside, a="d").capacitance == 0.1
    with pytest.raises(ParameterError):
        devices.Capacitor("c", "a", "b", 0.1)
    with implausible_allowed(False), pytest.raises(ParameterError):
        devices.Capacitor("c", "a", "b", 0.1)


def test_being_meant_is_no_part_of_what_a_device_is() -> None:
    """Records are found by the text of their circuits."""
    small = devices.Capacitor("c", "a", "b", 1e-12)
    meant = devices.Capacitor("c", "a", "b", 1e-12, allow_implausible=True)
    assert (small, hash(small), repr(small)) == (meant, hash(meant), repr(meant))
    assert repr(small) == "Capacitor(name='c', a='a', b='b', capacitance=1e-12)"


def test_a_source_may_be_at_zero_and_pass_through_any_current() -> None:
    ramp = PiecewiseLinear((0.0, 1.0), (1e-20, 1e-9))
    for waveform in (Constant(0.0), ramp):
        assert devices.Source("i", "a", waveform, "current").waveform == waveform


def test_errors_are_also_builtins() -> None:
    with pytest.raises(ValueError, match="must be > 0") as caught:
        devices.Resistor("r", "a", "b", 0.0)
    assert isinstance(caught.value, CircuitError)


@pytest.mark.parametrize("transconductance", [-1e-3, 0.0, 1e-3])
def test_a_controlled_source_has_its_transconductance_of_either_sign(transconductance: float) -> None:
    parts = (
        devices.ControlledSource("g", "0", "y", "a", "0", transconductance),
        devices.Resistor("r", "y", "0", 1e3),
    )
    circuit = Circuit("gain", (Port("a", "analog"), Port("y", "analog", "out")), parts)
    bench = Testbench("gain", circuit, (devices.Source("a", "a", Constant(2.0)),), 1e-3)
    assert operating_point(bench)["y"] == pytest.approx(2e3 * transconductance)
