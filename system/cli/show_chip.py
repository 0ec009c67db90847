"""The verb `noctule show` for a chip that runs as a behavioural model alone, which shows its circuits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from chips.registry import Chip
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.lowering.flatten import flatten
from system.cli.output import print_json, print_line, print_table, quantity_cell
from system.options.block import bias_unit


def show_chip(chip: Chip, given: Sequence[str], *, as_json: bool) -> None:
    """Print the circuits of a chip with their ports, biases and numbers of devices.

    given: options of a block that were given. Raises `ParameterError` for any of them.
    """
    if given:
        raise ParameterError(f"{given[0]}: {chip.name} is shown as it is built; leave it out")
    circuits = [_describe(circuit) for circuit in chip.circuits()]
    if as_json:
        print_json({"chip": chip.name, "summary": chip.summary, "circuits": circuits})
        return
    print_line(f"{chip.name}: {chip.summary}")
    print_line(f"it has no testbench as one circuit; {chip.remedy}\n")
    for circuit in circuits:
        _print(circuit)


def _describe(circuit: Circuit) -> dict[str, Any]:
    flat = flatten(circuit)
    return {
        "name": circuit.name,
        "instances": [{"name": i.name, "shape": i.shape} for i in circuit.instances],
        "node_count": flat.count - 1,
        "device_count": sum(group.nodes.shape[1] for group in flat.groups),
        "ports": [
            {"name": p.name, "kind": p.kind, "direction": p.direction, "shape": p.shape}
            for p in circuit.ports
        ],
        "biases": [
            {"name": b.name, "port": b.port, "kind": b.kind, "value": b.value, "unit": bias_unit(b)}
            for b in circuit.biases
        ],
    }


def _print(circuit: dict[str, Any]) -> None:
    parts = ", ".join(f"{i['name']}{list(i['shape']) or ''}" for i in circuit["instances"])
    counts = f"{circuit['device_count']} devices, {circuit['node_count']} nodes"
    print_line(f"{circuit['name']}: {parts}; {counts}")
    rows = [
        (b["name"], b["kind"], quantity_cell(b["value"], b["unit"]), b["port"]) for b in circuit["biases"]
    ]
    print_table("biases", ("name", "kind", "value:", "port"), rows)
