"""How a dialect is put together, from a formatter of its devices and what writes its netlists."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from circuits.devices import Transistor
from circuits.devices.device import Device
from circuits.silicon.die import NOMINAL
from circuits.silicon.silicon import NO_DEVIATION, Deviation, Silicon
from circuits.testbench import Testbench
from netlists.registry import DeviceFormatter, Dialect, Settings
from netlists.write.deck import Writer, format_deck
from netlists.write.traversal import Design

Transistors = Callable[[Transistor, Silicon, Deviation], list[str]]
Cards = Callable[[Silicon, Design], list[str]]


def no_cards(silicon: Silicon, design: Design) -> list[str]:
    """Write no models: the devices need none."""
    return []


def make_formatter(
    dialect: str,
    transistors: Transistors,
    others: Mapping[type[Device], Callable[[Any], list[str]]],
) -> DeviceFormatter:
    """Make a dialect's formatter of devices, a generic function of the device's type.

    Parameters
    ----------
    dialect
        Name of the dialect, for the refusal of a type that is not there.
    transistors
        Gives the lines of a transistor on a silicon, deviating by what its place on the die adds.
    others
        Gives the lines of a device of each other type.
    """

    @functools.singledispatch
    def format_device(device: Device, silicon: Silicon, deviation: Deviation = NO_DEVIATION) -> list[str]:
        raise TypeError(f"{type(device).__name__}: no lowering to {dialect} text")

    def transistor(device: Transistor, silicon: Silicon, deviation: Deviation = NO_DEVIATION) -> list[str]:
        return transistors(device, silicon, deviation)

    def other(write: Callable[[Any], list[str]]) -> Callable[..., list[str]]:
        return lambda device, *_: write(device)

    format_device.register(Transistor, transistor)
    for kind, write in others.items():
        format_device.register(kind, other(write))
    formatter: Any = format_device
    typed: DeviceFormatter = formatter
    return typed


def make_dialect(
    writer: Writer,
    summary: str,
    models: Mapping[str, tuple[DeviceFormatter, Cards]],
    *,
    drawing: bool = False,
    syntax: Callable[[Dialect], Any] | None = None,
) -> Dialect:
    """Make the dialect of a writer.

    Parameters
    ----------
    writer
        How definitions, calls, sources and the run are written.
    summary
        What the list of dialects says about it.
    models
        By what transistors are (`ekv`, `bsim3`): the formatter of devices, and the cards that they name.
    drawing
        Whether the text says the same at every temperature and on every die; then the nominal die is written.
    syntax
        How a netlist is read back by its notes; as one of the SPICE family unless given.
    """

    def write(testbench: Testbench, silicon: Silicon, settings: Settings, title: str | None = None) -> str:
        formatter = dialect.formatter(settings.models)
        cards = functools.partial(models[settings.models][1], silicon)
        on = replace(silicon, die=NOMINAL) if drawing else silicon
        return format_deck(writer, formatter, cards, testbench, on, settings, title)

    dialect = Dialect(
        writer.dialect, summary, not writer.remark, writer.comment, writer.naming,
        {name: formatter for name, (formatter, _) in models.items()}, write, drawing, syntax,
    )  # fmt: skip
    return dialect
