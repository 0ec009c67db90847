"""Transistors and logic of blocks whose sizes are given in micrometre, bulks at the supplies."""

from __future__ import annotations

from circuits.devices import Transistor
from circuits.silicon.process import Polarity

UM = 1e-6


def mos(
    name: str, polarity: Polarity, drain: str, gate: str, source: str, width: float, length: float
) -> Transistor:
    """A transistor of `width` by `length` in um, its bulk at `vdd` or ground."""
    bulk = "vdd" if polarity == "p" else "0"
    return Transistor(name, polarity, drain, gate, source, bulk, width * UM, length * UM)


def inverter(name: str, gate: str, out: str, *, width: float, length: float) -> tuple[Transistor, Transistor]:
    """PFET `{name}p` of twice the width and nFET `{name}n`, um."""
    return (
        mos(f"{name}p", "p", out, gate, "vdd", 2.0 * width, length),
        mos(f"{name}n", "n", out, gate, "0", width, length),
    )


def nor(name: str, gates: tuple[str, ...], out: str, *, width: float, length: float) -> list[Transistor]:
    """NFETs side by side and pFETs in series, the first gate's at the supply, um; inner nodes `{name}_k`."""
    stack = ["vdd", *(f"{name}_{k}" for k in range(1, len(gates))), out]
    pulls = [mos(f"{name}n{k}", "n", out, g, "0", width, length) for k, g in enumerate(gates)]
    return pulls + [
        mos(f"{name}p{k}", "p", stack[k + 1], g, stack[k], 2.0 * width * len(gates), length)
        for k, g in enumerate(gates)
    ]


def nand(name: str, gates: tuple[str, ...], out: str, *, width: float, length: float) -> list[Transistor]:
    """PFETs side by side and nFETs in series, the first gate's at ground, um; inner nodes `{name}_k`."""
    stack = ["0", *(f"{name}_{k}" for k in range(1, len(gates))), out]
    pulls = [mos(f"{name}p{k}", "p", out, g, "vdd", 2.0 * width, length) for k, g in enumerate(gates)]
    return pulls + [
        mos(f"{name}n{k}", "n", stack[k + 1], g, stack[k], width * len(gates), length)
        for k, g in enumerate(gates)
    ]
