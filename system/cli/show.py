"""The verb `noctule show`: the ports, devices, parameters, biases and stimuli of a block or chip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from chips.record import content
from chips.registry import Chip
from circuits.arrays import F64
from circuits.bias import bias_voltages
from circuits.catalogue import loaded
from circuits.circuit import Bias, Circuit, Port
from circuits.errors import ParameterError
from circuits.lowering.flatten import DeviceGroup, flatten
from circuits.lowering.graph import describe_device
from system.cli.block_choice import choose_block
from system.cli.output import print_json, print_line, print_table, quantity_cell
from system.cli.verbs import Show
from system.files.kept import kept
from system.options.block import (
    ROLLS,
    Choice,
    bias_unit,
    describe_silicon,
    parameters,
    refuse_bias_file,
    silicon_line,
)
from system.options.silicon import SiliconChoice
from system.options.target import load_target
from system.study.metrics.listed import Listed, listed

_SIZE_UNITS = {
    "capacitance": "F",
    "length": "m",
    "offset": "V",
    "output_resistance": "Ohm",
    "resistance": "Ohm",
    "transconductance": "S",
    "width": "m",
}


def show_command(asked: Show) -> None:
    """Print what a block is made of, and draw its graph where a picture is asked for."""
    if asked.block.endswith(".toml"):
        _show_program(asked)
        return
    _check(asked)
    if asked.block == ROLLS:
        loaded("system.cli.show_rolls:show_rolls")(asked)
        return
    values, silicon = asked.values, asked.silicon
    refuse_bias_file(asked.block, values.bias_file)
    _check_pictures(asked)
    found = load_target(asked.block)
    if isinstance(found, Chip):
        given = {
            "--param": values.param, "--bias": values.bias, "--bias-set": values.bias_set,
            "--bias-kind": values.bias_kind, "--plot": asked.plot, "--metrics": asked.metrics,
            "--schematic": asked.schematic,
            "--die and --temperature": silicon != SiliconChoice(),
        }  # fmt: skip
        show_chip = loaded("system.cli.show_chip:show_chip")
        show_chip(found, [option for option, value in given.items() if value], as_json=asked.as_json)
        return
    choice = choose_block(asked.block, values, silicon, asked.stimulus)
    document = _describe(choice, listed(choice, run=asked.metrics))
    if asked.plot is not None:
        draw = loaded("system.plot:draw_circuit")
        loaded("system.plot:save_picture")(asked.plot, lambda figure: draw(choice.circuit, figure))
    if asked.schematic is not None:
        save_schematic = loaded("system.cli.schematic_file:save_schematic")
        save_schematic(asked.schematic, asked.block, choice, solved=asked.op)
    if asked.as_json:
        print_json({**document, "devices": _devices(choice.circuit)})
    else:
        _print(choice, document)


def _check(asked: Show) -> None:
    """Raise `ParameterError` for options that do not go together."""
    if asked.block == ROLLS and asked.metrics:
        raise ParameterError(f"--metrics: {ROLLS} has no testbench as one circuit; leave it out")
    if asked.op and asked.schematic is None:
        raise ParameterError("--op: no schematic to write into; add --schematic FILE, or see noctule op")
    if asked.stimulus and not (asked.op or asked.metrics):
        raise ParameterError("--stimulus: nothing is solved; add --op with --schematic FILE, or --metrics")
    if asked.block == ROLLS and asked.schematic is not None:
        raise ParameterError(f"--schematic: {ROLLS} is no single circuit; name a block, as rolls-neuron")


def _check_pictures(asked: Show) -> None:
    for picture in (asked.plot, asked.schematic):
        if picture is not None:  # what draws is slow to import
            loaded("system.plot:check_picture")(picture)


def _show_program(asked: Show) -> None:
    """Print a mapped network, which has none of a block's options."""
    values = asked.values
    given = {
        "--param": values.param, "--bias": values.bias, "--bias-set": values.bias_set,
        "--bias-kind": values.bias_kind, "--bias-file": values.bias_file, "--metrics": asked.metrics,
        "--schematic": asked.schematic, "--op": asked.op, "--stimulus": asked.stimulus,
        "--die and --temperature": asked.silicon != SiliconChoice(),
    }  # fmt: skip
    show_program = loaded("system.cli.map:show_program")
    refused = [option for option, value in given.items() if value]
    show_program(asked.block, refused, asked.plot, as_json=asked.as_json)


def _describe(choice: Choice, metrics: Sequence[Listed]) -> dict[str, Any]:
    flat = flatten(choice.circuit)
    return {
        "block": choice.block.name,
        "summary": choice.block.summary,
        **describe_silicon(choice.silicon),
        "node_count": flat.count - 1,
        "device_count": sum(g.nodes.shape[1] for g in flat.groups),
        "ports": [_port(p) for p in choice.circuit.ports],
        "parameters": [asdict(p) for p in parameters(choice.params)],
        "biases": [_bias(b, v) for b, v in zip(choice.circuit.biases, _voltages(choice).values, strict=True)],
        "stimuli": [asdict(s) for s in choice.block.stimuli],
        "metrics": [asdict(m) for m in metrics],
        "closed_forms": _closed_forms(choice),
        "equations": [asdict(e) for e in choice.block.equations],
    }


def _devices(circuit: Circuit) -> list[dict[str, Any]]:
    """Every device, which JSON alone has one by one."""
    flat = flatten(circuit)
    names = flat.node_names()
    return [_device(g, k, names) for g in flat.groups for k in range(g.nodes.shape[1])]


def _closed_forms(choice: Choice) -> list[dict[str, Any]]:
    forms = choice.block.closed_forms
    return [] if forms is None else [asdict(f) for f in forms(choice.circuit, choice.silicon)]


def _port(port: Port) -> dict[str, Any]:
    return {"name": port.name, "kind": port.kind, "direction": port.direction, "shape": port.shape}


@dataclass(frozen=True, slots=True)
class _Voltages:
    """values: gate voltages of each bias, V."""

    values: tuple[F64, ...]


def _voltages(choice: Choice) -> _Voltages:
    """Voltages of all biases, V; those that the generator's circuit gives are kept."""
    circuit, silicon = choice.circuit, choice.silicon

    def solved() -> _Voltages:
        return _Voltages(tuple(np.asarray(bias_voltages(circuit, b, silicon)) for b in circuit.biases))

    if all(bias.kind != "generator" for bias in circuit.biases):
        return solved()
    return kept("bias-voltages", (content(circuit), silicon), _Voltages, solved)


def _bias(bias: Bias, voltages: F64) -> dict[str, Any]:
    return {
        "name": bias.name,
        "port": bias.port,
        "kind": bias.kind,
        "value": bias.value,
        "unit": bias_unit(bias),
        "device": bias.device,
        "reference_temperature_C": bias.reference_temperature_c,
        "voltage_V": voltages,
    }


def _device(group: DeviceGroup, k: int, names: list[str]) -> dict[str, Any]:
    description = describe_device(group.device)
    nodes = (names[int(node)] for node in group.nodes[:, k])
    return {
        "path": group.label(k),
        "type": description.type,
        **description.attributes,
        "terminals": dict(zip(description.terminals, nodes, strict=True)),
        "sizes": {name: float(value[k]) for name, value in group.parameters.items()},
    }


def _print(choice: Choice, document: dict[str, Any]) -> None:
    print_line(f"{document['block']}: {document['summary']}")
    counts = f"{document['device_count']} devices, {document['node_count']} nodes"
    print_line(f"{counts}, at {silicon_line(choice.silicon)}\n")
    ports = [(p["name"], p["kind"], p["direction"], _shape(p["shape"])) for p in document["ports"]]
    print_table("ports", ("name", "kind", "direction", "shape"), ports)
    numbers = [(p["name"], quantity_cell(p["value"], p["unit"])) for p in document["parameters"]]
    print_table("parameters (--param)", ("name", "value:"), numbers)
    columns = ("name", "kind", "value:", "voltage:", "port")
    print_table("biases (--bias)", columns, [_bias_row(b) for b in document["biases"]])
    stimuli = [(s["name"], quantity_cell(s["default"], s["unit"]), s["summary"]) for s in document["stimuli"]]
    print_table("stimuli (--stimulus)", ("name", "default:", "summary"), stimuli)
    _print_metrics(document["metrics"])
    forms = [
        (f"({f['equation']})", f["name"], f"{f['printed']:.4g}", _corrected(f["corrected"]))
        for f in document["closed_forms"]
    ]
    if forms:
        print_table("closed forms (SI)", ("equation", "quantity", "as printed:", "corrected:"), forms)
    equations = [
        (f"({e.number})", e.name, e.printed, e.corrected or "as printed") for e in choice.block.equations
    ]
    if equations:
        print_table("equations of the paper", ("number", "name", "as printed", "corrected"), equations)
    flat = flatten(choice.circuit)
    names = flat.node_names()
    rows = [_device_row(group, names) for group in flat.groups]
    print_table("devices", ("path", "type", "terminals", "sizes"), rows)


def _print_metrics(metrics: Sequence[Mapping[str, Any]]) -> None:
    rows = [
        (m["name"], "" if m["nominal"] is None else quantity_cell(m["nominal"], m["unit"]), m["summary"])
        for m in metrics
    ]
    if rows:
        print_table("metrics (--metric)", ("name", "nominal:", "summary"), rows)
    if all(m["nominal"] is None for m in metrics):
        print_line("what a run of the testbench measures besides: --metrics\n")


def _corrected(value: float | None) -> str:
    return "as printed" if value is None else f"{value:.4g}"


def _bias_row(bias: dict[str, Any]) -> tuple[str, ...]:
    value, voltage = quantity_cell(bias["value"], bias["unit"]), quantity_cell(bias["voltage_V"], "V")
    return bias["name"], bias["kind"], value, voltage, bias["port"]


def _device_row(group: DeviceGroup, names: list[str]) -> tuple[str, str, str, str]:
    """One row for all copies of a device: copies in an array differ in their indices only."""
    copies = group.nodes.shape[1]
    description = describe_device(group.device)
    path = ".".join((*(name + _slices(shape) for name, shape in group.path), group.device.name))
    kind = f"{description.attributes.get('polarity', '')}FET" if "polarity" in description.attributes else ""
    first, last = (_terminals(group, k, names) for k in (0, copies - 1))
    terminals = [
        f"{t}={a}" if a == b else f"{t}={a} .. {b}"
        for t, a, b in zip(description.terminals, first, last, strict=True)
    ]
    sizes = [
        f"{name}={quantity_cell(value, _SIZE_UNITS.get(name, ''))}"
        for name, value in group.parameters.items()
        if name != "multiplicity" or (value != 1.0).any()
    ]
    return path, kind or description.type, " ".join(terminals), " ".join(sizes)


def _terminals(group: DeviceGroup, k: int, names: list[str]) -> list[str]:
    return [names[int(node)] for node in group.nodes[:, k]]


def _slices(shape: Sequence[int]) -> str:
    return f"[{','.join(f'0:{n}' for n in shape)}]" if shape else ""


def _shape(shape: Sequence[int]) -> str:
    return "×".join(map(str, shape)) if len(shape) else "scalar"
