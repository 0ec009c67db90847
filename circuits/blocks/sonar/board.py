"""Parts of the boards beside the ranging chip: logic gates, amplifiers, strays and a transmission gate.

All numbers are ours, and the same on every board. The compensation sets an amplifier's unity-gain frequency,
`gain / (2 pi R_o C) = 1.6 MHz`.
"""

from __future__ import annotations

from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, event_in
from circuits.circuit import Circuit
from circuits.devices import Capacitor, Device, OperationalAmplifier

STRAY = 5e-12  # F, at every board node
GAIN = 1e4  # V/V
AMPLIFIER_RESISTANCE = 10e3  # ohm
COMPENSATION = 100e-9  # F
LENGTH = 1.5  # um, of a transistor that switches
GATE_WIDTH = 100.0  # um, of both pass transistors of a transmission gate


def inverter(name: str, a: str, y: str, width: float = 30.0) -> tuple[Device, ...]:
    """An inverter from `a` to `y`; its nFET is `width` (um) wide, and its pFET twice as much."""
    return (
        mos(f"{name}_p", "p", y, a, "vdd", 2 * width, LENGTH),
        mos(f"{name}_n", "n", y, a, "0", width, LENGTH),
    )


def nor(name: str, a: str, b: str, y: str, width: float = 30.0) -> tuple[Device, ...]:
    """A NOR gate, `y = not (a or b)`; its nFETs are `width` (um) wide, and its pFETs four times as much."""
    return (
        mos(f"{name}_pa", "p", f"{name}_mid", a, "vdd", 4 * width, LENGTH),
        mos(f"{name}_pb", "p", y, b, f"{name}_mid", 4 * width, LENGTH),
        mos(f"{name}_na", "n", y, a, "0", width, LENGTH),
        mos(f"{name}_nb", "n", y, b, "0", width, LENGTH),
    )


def amplifier(name: str, positive: str, negative: str, output: str) -> tuple[Device, ...]:
    """An operational amplifier that a capacitor at its output compensates."""
    return (
        OperationalAmplifier(name, positive, negative, output, "vdd", "0", GAIN, AMPLIFIER_RESISTANCE),
        Capacitor(f"c_{name}", output, "0", COMPENSATION),
    )


def strays(*nodes: str) -> tuple[Device, ...]:
    """A stray capacitance from each of `nodes` to ground."""
    return tuple(Capacitor(f"c_stray_{n}", n, "0", STRAY) for n in nodes)


def transmission_gate() -> Circuit:
    """A gate that joins a and b while control is high: an nFET and a pFET, whose gate an inverter drives."""
    return Circuit(
        "transmission_gate",
        (SUPPLY, *event_in("control"), *analog_in("a"), *analog_out("b")),
        (
            *inverter("i", "control", "complement"),
            mos("m_n", "n", "a", "control", "b", GATE_WIDTH, LENGTH),
            mos("m_p", "p", "a", "complement", "b", GATE_WIDTH, LENGTH),
        ),
    )
