"""Transistors of a whole ROLLS chip on a die, one kind of part at a time.

The draws are those of the chip's circuit (`chips.rolls.circuit`), which is never flattened as a whole: of its
three million devices only those are drawn that a model needs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from chips.rolls.circuit import NAME, bias_ports
from circuits.arrays import F64
from circuits.bias import lone_voltages
from circuits.blocks.rolls import dpi_synapse
from circuits.circuit import Circuit, Shape
from circuits.lowering.capacitors_on_die import with_capacitors
from circuits.lowering.on_die import DieDevices, on_die
from circuits.silicon.die import Path
from circuits.silicon.silicon import Silicon


def gate_voltages(chip: Circuit, silicon: Silicon) -> dict[str, float]:
    """Return the voltages of the chip's scalar bias ports by port, V, with its supply and ground."""
    return lone_voltages(chip, chip.biases, silicon) | {"vdd": silicon.process.v_dd, "0": 0.0}


def devices_at(
    circuit: Circuit, place: Path, silicon: Silicon, gates: Mapping[str, F64 | float],
    wanted: Sequence[str] | None = None, prefix: str = "",
) -> DieDevices:  # fmt: skip
    """Return the transistors of `circuit`, which stands in the arrays of `place` below the chip.

    gates: voltages by bias port of `circuit`, V; wanted: devices by path, all unless given; prefix: put
    before the names. Copies are counted with the last index of `place` running fastest.
    """
    on_chip, at = replace(silicon, place=((NAME, ()),)), ((NAME, ()), *place)
    found = on_die(circuit, on_chip, wanted, at, gates).flat()
    return with_capacitors(found, circuit, on_chip, at).renamed("", prefix)


def extenders_at(
    sizes: dpi_synapse.Params, place: Path, silicon: Silicon, gates: Mapping[str, F64 | float]
) -> DieDevices:
    """Return the transistors of the pulse extenders in the arrays of `place`, called `extender.NAME`.

    sizes: of the synapse's circuits; gates: voltages by bias port of an extender, V.
    """
    return devices_at(dpi_synapse.pulse_extender(sizes), place, silicon, gates, None, "extender.")


def part_gates(part: str, gates: Mapping[str, float]) -> dict[str, float]:
    """Return the voltages of the bias ports of a part of a row, V, from those of the row."""
    return {port: gates[outer] for port, outer in bias_ports(part).items() if outer in gates}


def row_place(rows: int, *parts: tuple[str, Shape]) -> Path:
    """Return the path of a part of every row."""
    return (("row", (rows,)), *parts)
