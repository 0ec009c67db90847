"""Every device type offers what the lowerings rely on, and has every lowering."""

import math
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace
from typing import Any

import pytest

from circuits.devices import (
    DEVICE_TYPES,
    Capacitor,
    ControlledSource,
    Device,
    OperationalAmplifier,
    Resistor,
    Source,
    Transistor,
)
from circuits.devices.source import Constant
from circuits.errors import CircuitError, ParameterError
from circuits.lowering import analysis, graph, kernel
from netlists.dialect import dialect_names, load_dialect

EXAMPLES: dict[type[Device], Device] = {
    Transistor: Transistor("m", "n", "d", "g", "s", "0", 1e-6, 1e-6),
    Capacitor: Capacitor("c", "a", "b", 1e-12),
    Resistor: Resistor("r", "a", "b", 1e3),
    ControlledSource: ControlledSource("g", "a", "b", "c", "d", 1e-3),
    OperationalAmplifier: OperationalAmplifier("x", "p", "n", "o", "vdd"),
    Source: Source("v", "a", Constant(1.0)),
}
# Generic functions of a device's type, the base's implementation being the refusal
LOWERINGS: dict[str, Any] = {
    "kernel": kernel.add_device,
    "graph": graph.describe_device,
    "analysis": analysis.to_equation,
    **{f"{d} {m}": f for d in dialect_names() for m, f in load_dialect(d).devices.items()},
}
NAMED: list[tuple[Device, str]] = [
    (Capacitor("c", "a", "b", 0.0), "c.capacitance: 0 F, must be > 0"),
    (Resistor("r", "a", "b", -1.0), "r.resistance: -1 ohm, must be > 0"),
    (ControlledSource("g", "a", "b", "c", "d", math.nan), "g.transconductance: nan S, must be finite"),
]


def test_every_type_has_an_example() -> None:
    assert set(EXAMPLES) == set(DEVICE_TYPES)


@pytest.mark.parametrize("lowering", LOWERINGS)
@pytest.mark.parametrize("kind", DEVICE_TYPES)
def test_every_type_has_every_lowering(kind: type[Device], lowering: str) -> None:
    generic = LOWERINGS[lowering]
    refusal: Callable[..., object] = generic.dispatch(object)
    assert generic.dispatch(kind) is not refusal, f"{kind.__name__} has no lowering to {lowering}"


@pytest.mark.parametrize("kind", DEVICE_TYPES)
def test_examples_are_sound_frozen_and_consistent(kind: type[Device]) -> None:
    device = EXAMPLES[kind]
    device.check()
    attribute = "name"
    with pytest.raises((FrozenInstanceError, TypeError)):
        setattr(device, attribute, "other")
    count = len(device.terminals())
    assert all(-1 <= i < count and -1 <= j < count for i, j in device.conducting())
    for attribute in device.parameters():
        changed: Any = {attribute: 2.5}
        assert replace(device, **changed).parameters()[attribute] == 2.5  # type: ignore[type-var]


@pytest.mark.parametrize(("device", "text"), NAMED)
def test_bad_values_are_named(device: Device, text: str) -> None:
    with pytest.raises(ParameterError, match=f"^{text}"):
        device.check()


def test_errors_are_also_builtins() -> None:
    with pytest.raises(ValueError, match="must be > 0") as caught:
        Resistor("r", "a", "b", 0.0).check()
    assert isinstance(caught.value, CircuitError)


def test_a_controlled_source_of_negative_transconductance_is_allowed() -> None:
    ControlledSource("g", "a", "b", "c", "d", -1e-3).check()
