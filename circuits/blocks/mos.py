"""Transistors and logic gates by their sizes in micrometre, with the bulks at the supplies."""

from __future__ import annotations

from circuits.devices import Transistor
from circuits.silicon.process import Polarity

UM = 1e-6


def mos(
    name: str, polarity: Polarity, drain: str, gate: str, source: str, width: float, length: float
) -> Transistor:
    """Make a transistor whose size is in micrometre and whose bulk is at its rail.

    The rail is `vdd` for a pFET and ground for an nFET.

    Parameters
    ----------
    name
        Name of the device.
    polarity
        `n` or `p`.
    drain, gate, source
        Names of its nodes.
    width, length
        Size, um.
    """
    bulk = "vdd" if polarity == "p" else "0"
    return Transistor(name, polarity, drain, gate, source, bulk, width * UM, length * UM)


def current_mirror(
    diode: str, copy: str, polarity: Polarity, node: str, out: str, size: tuple[float, float]
) -> tuple[Transistor, Transistor]:
    """A current mirror of two transistors, whose sources are at the rail.

    Parameters
    ----------
    diode, copy
        Names of the transistors: the diode-connected one, and the one that copies its current.
    polarity
        `n` or `p`.
    node, out
        Node of the diode, and of the copy's drain.
    size
        Width and length of both, um.
    """
    rail = "vdd" if polarity == "p" else "0"
    return mos(diode, polarity, node, node, rail, *size), mos(copy, polarity, out, node, rail, *size)


def inverter(name: str, gate: str, out: str, *, width: float, length: float) -> tuple[Transistor, Transistor]:
    """Make the two transistors of an inverter: the pFET `{name}p`, twice as wide, and the nFET `{name}n`.

    Parameters
    ----------
    name
        How their names begin.
    gate, out
        Nodes of the input and of the output.
    width, length
        Size of the nFET, um.
    """
    return (
        mos(f"{name}p", "p", out, gate, "vdd", 2.0 * width, length),
        mos(f"{name}n", "n", out, gate, "0", width, length),
    )


def nor(name: str, gates: tuple[str, ...], out: str, *, width: float, length: float) -> list[Transistor]:
    """A NOR gate: nFETs in parallel and pFETs in series, that of the first gate at the supply.

    width, length: um. An nFET is `width` wide, and a pFET is wider by twice the number of gates. The nodes
    between the pFETs are called `{name}_k`.
    """
    stack = ["vdd", *(f"{name}_{k}" for k in range(1, len(gates))), out]
    pulls = [mos(f"{name}n{k}", "n", out, g, "0", width, length) for k, g in enumerate(gates)]
    return pulls + [
        mos(f"{name}p{k}", "p", stack[k + 1], g, stack[k], 2.0 * width * len(gates), length)
        for k, g in enumerate(gates)
    ]


def nand(name: str, gates: tuple[str, ...], out: str, *, width: float, length: float) -> list[Transistor]:
    """A NAND gate: pFETs in parallel and nFETs in series, that of the first gate at ground.

    width, length: um. A pFET is twice `width` wide, and an nFET is wider than `width` by the number of gates.
    The nodes between the nFETs are called `{name}_k`.
    """
    stack = ["0", *(f"{name}_{k}" for k in range(1, len(gates))), out]
    pulls = [mos(f"{name}p{k}", "p", out, g, "vdd", 2.0 * width, length) for k, g in enumerate(gates)]
    return pulls + [
        mos(f"{name}n{k}", "n", stack[k + 1], g, stack[k], width * len(gates), length)
        for k, g in enumerate(gates)
    ]
