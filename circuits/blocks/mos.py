"""Transistors and logic gates by their sizes in micrometre, with the bulks at the supplies."""

from __future__ import annotations

from circuits.devices import Transistor
from circuits.silicon.process import Polarity

UM = 1e-6


def mos(
    name: str, polarity: Polarity, drain: str, gate: str, source: str, width: float, length: float
) -> Transistor:
    """A transistor whose bulk is at `vdd` for a pFET and at ground for an nFET.

    Parameters
    ----------
    name
        Name of the device.
    polarity
        `n` or `p`.
    drain, gate, source
        Names of the nodes of its terminals.
    width, length
        Its size, um.
    """
    bulk = "vdd" if polarity == "p" else "0"
    return Transistor(name, polarity, drain, gate, source, bulk, width * UM, length * UM)


def inverter(name: str, gate: str, out: str, *, width: float, length: float) -> tuple[Transistor, Transistor]:
    """An inverter: the pFET `{name}p`, of twice the width, and the nFET `{name}n`; width and length in um."""
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
