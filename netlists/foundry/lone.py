"""Currents of many lone devices of a foundry's: by our draws, and by ngspice's own of the foundry's text.

Many devices stand in one deck, each with its gate at one voltage, its drain at another, source and bulk at
their rail. In the foundry's own deck each is the foundry's sub-circuit, whose `agauss` ngspice draws anew for
each instance; what a die shares is drawn once for a deck.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.errors import DataError
from circuits.silicon.die import Die
from circuits.silicon.silicon import Deviation
from netlists.foundry.deck import format_transistor, header
from netlists.foundry.die import expressions, process_terms, subcircuit
from netlists.foundry.process import DeviceMapping, choose_cards, read_cards
from netlists.ngspice import run as ngspice

_OPTIONS = "gmin=1e-15 abstol=1e-15 reltol=1e-6"
Volts = tuple[float, float, float]  # of a low and a high gate, and the drain
_AT_ONCE = 1000  # devices a deck


def currents(
    device: Transistor,
    mapping: DeviceMapping,
    volts: Volts,
    die: Die,
    deviations: Sequence[Deviation],
) -> F64:
    """Drain currents of equal devices with deviations of their own, on one die, at 27 degC, A, float64[2, n].

    Parameters
    ----------
    device
        With the foundry's size.
    mapping
        The foundry's process.
    volts
        A low and a high gate, and the drain, to the bulk, V, a pFET's mirrored.
    die
        What all devices share.
    deviations
        What each has of its own.
    """
    cards = header(mapping, [device], die)
    elements = [
        format_transistor(_placed(device, k), mapping, own).removeprefix("m")
        for k, own in enumerate(deviations)
    ]
    return _run(device, mapping, volts, cards, [f"m{text}" for text in elements])


def own_currents(
    device: Transistor,
    mapping: DeviceMapping,
    volts: Volts,
    count: int,
    seed: int,
    mismatch: bool = True,  # noqa: FBT001, FBT002 - the foundry's switches
    process: bool = False,  # noqa: FBT001, FBT002
) -> F64:
    """Drain currents of the foundry's sub-circuits, drawn by ngspice, at 27 degC, A, float64[2, count].

    device, mapping, volts: as of `currents`. count: how many devices. seed: of ngspice's draws in the first
    deck of a thousand; each further deck has the next one. mismatch, process: which of the foundry's
    variations are on; what a die shares is drawn once for all devices of a deck. Raises `DataError` where the
    foundry's package has no statistics.
    """
    if mapping.statistics is None:
        raise DataError(f"{mapping.name}: {mapping.package} has no statistics of its own")
    switches = {**mapping.statistics.switches, "sw_stat_mismatch": float(mismatch)}
    given = {**mapping.parameters, **switches, "sw_stat_global": float(process)}
    lines = [f".param {name}={value!r}" for name, value in given.items()]
    lines += [
        f".param {name}={text}" for name, text in {**process_terms(mapping), **expressions(mapping)}.items()
    ]
    size = (device.width, device.length)
    section = mapping.statistics.cards[device.polarity]
    cards = read_cards(mapping, device.polarity, section=section)
    lines += choose_cards(cards, mapping, device.polarity, [size]).splitlines()
    lines += subcircuit(mapping, device.polarity).splitlines()
    model = mapping.models[device.polarity][0]
    words = format_transistor(device, mapping).split(model)[1]
    words = words.replace(" m=", " par=")
    elements = [f"x{k} {' '.join(_placed(device, k).terminals())} {model}{words}" for k in range(count)]
    return _run(device, mapping, volts, lines, elements, seed)


def _placed(device: Transistor, k: int) -> Transistor:
    return Transistor(
        f"{k}", device.polarity, f"d{k}", "g", "0", "0", device.width, device.length, device.multiplicity
    )


def _run(
    device: Transistor,
    mapping: DeviceMapping,
    volts: Volts,
    head: Sequence[str],
    elements: Sequence[str],
    seed: int | None = None,
) -> F64:
    """Magnitudes of the drains' currents, in decks of so many devices; each deck has a seed of its own."""
    sign = 1.0 if device.polarity == "n" else -1.0
    low, high, drain = (sign * v for v in volts)
    found = []
    for start in range(0, len(elements), _AT_ONCE):
        some = range(start, min(start + _AT_ONCE, len(elements)))
        drawn = [] if seed is None else [f".options seed={seed + start // _AT_ONCE}"]
        lines = [f"* lone devices of {mapping.name}", *drawn, *head, f"vg g 0 dc {low!r}"]
        lines += [line for k in some for line in (f"vd{k} d{k} 0 dc {drain!r}", elements[k])]
        lines += [f".options temp=27 {_OPTIONS}", f".dc vg {low!r} {high!r} {high - low!r}", ".end"]
        names = tuple(f"vd{k}#branch" for k in some)
        run = ngspice.run("\n".join(lines) + "\n", vectors=names)
        found.append(np.abs(np.array([run.values[name] for name in names])).T)
    return np.concatenate(found, axis=1)
