"""`noctule export`: a block or chip with its testbench as text for another simulator."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from chips.model import Cells, load_model, model_names
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.lowering.flatten import flatten
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.foundry.deck import format_foundry, map_circuit
from netlists.foundry.process import read_mapping
from netlists.parasitics import read_parasitics
from netlists.registry import Dialect, Settings, load_dialect
from netlists.verilog_a.cell import CellArray, format_cells
from system.cli.export_rolls import export_rolls
from system.cli.output import print_json, print_line
from system.files.writing import write_text_atomic
from system.options.begin import FREE, BeginChoice, refuse_beginning
from system.options.begun import begun
from system.options.block import Choice, choose, describe_silicon
from system.options.silicon import SiliconChoice
from system.rolls.options import NAME as ROLLS
from system.rolls.options import refuse_bias_file


def export_command(
    block: str,
    *,
    params: Sequence[str],
    biases: Sequence[str],
    bias_set: str | None,
    bias_kind: BiasKind | None,
    silicon: SiliconChoice,
    stimuli: Sequence[str],
    mapping: str | None,
    level: str,
    dialect: str,
    models: str,
    parasitics: str | None,
    output: str,
    as_json: bool,
    bias_file: str | None = None,
    program: str | None = None,
    begin: BeginChoice = FREE,
) -> None:
    """Write the netlist to the file `output`, `-` being stdout (with `--json` inside the document)."""
    if block == ROLLS:
        refuse_beginning(begin, block)
        export_rolls(
            bias_file=bias_file, program=program, params=params, biases=biases, bias_set=bias_set,
            bias_kind=bias_kind, silicon=silicon, stimuli=stimuli, mapping=mapping, level=level,
            dialect=dialect, models=models, parasitics=parasitics, output=output, as_json=as_json,
        )  # fmt: skip
        return
    refuse_bias_file(block, bias_file)
    if program is not None:
        raise ParameterError(f"--program: {program}, of rolls only; leave it out for {block}")
    choice = choose(block, params, biases, bias_kind, silicon, stimuli, bias_set=bias_set, begin=begin)
    bench = choice.testbench()
    loads = {} if parasitics is None else read_parasitics(parasitics, choice.circuit)
    settings = Settings(models, parasitics=loads)
    if level == "behavioural":
        refuse_beginning(begin, "the behavioural level")
        _refuse_with_behavioural(dialect, mapping, settings)
        text = _as_cells(choice)
    elif mapping is not None:
        _refuse_with_mapping(dialect, settings)
        text = _on_foundry(choice, mapping)
    else:
        chosen = load_dialect(dialect)
        _refuse_with_drawing(chosen, choice.silicon)
        text = chosen.write(bench, choice.silicon, settings)
    sizes = None if mapping is None else str(read_mapping(mapping).sizes)
    to_stdout = output == "-"
    if not to_stdout:
        write_text_atomic(output, text)
    if as_json:
        print_json(
            {
                "block": choice.block.name,
                "dialect": dialect,
                "level": level,
                "models": models,
                "parasitics": len(loads),
                **(_contents(bench, text) if level == "transistor" else {"cells": text.count("  x")}),
                "mapping": mapping,
                "mapped_sizes": sizes,
                **describe_silicon(choice.silicon),
                "stimuli": choice.stimuli,
                "file": None if to_stdout else output,
                "lines": text.count("\n"),
                **({"netlist": text} if to_stdout else {}),
            }
        )
    elif to_stdout:
        sys.stdout.write(text)
    elif sizes is not None:
        print_line(f"{output}: on {mapping} sizes of transistors are not those of {block}: {sizes}")


def _contents(bench: Testbench, text: str) -> dict[str, int]:
    """How many definitions a netlist has, and devices in all its places."""
    noted = sum(line.lstrip("*/").startswith("% circuit ") for line in text.splitlines())
    plain = text.count("\n.subckt ")
    devices = sum(group.nodes.shape[1] for group in flatten(bench.circuit).groups)
    return {"definitions": noted or plain, "devices": devices}


def _refuse_with_drawing(dialect: Dialect, silicon: Silicon) -> None:
    """Raise `ParameterError` for a drawing on a die or at a temperature: all are drawn alike."""
    if not dialect.drawing:
        return
    die, nominal = silicon.die, silicon.process.nominal_temperature_c
    for option, value, refused in (
        ("--die", die.number, die.number is not None),
        ("--corner", die.corner, die.corner not in {"random", "typical"}),
        ("--temperature", f"{silicon.temperature_c:g} degC", silicon.temperature_c != nominal),
    ):
        if refused:
            raise ParameterError(
                f"{option}: {value}, {dialect.name} is the drawing, for LVS, which no {option[2:]} changes;"
                " leave it out, or choose another --dialect"
            )


def _refuse_with_behavioural(dialect: str, mapping: str | None, settings: Settings) -> None:
    for option, refused in (
        ("--dialect", dialect != "verilog-a"),
        ("--models", settings.models != "ekv"),
        ("--parasitics", bool(settings.parasitics)),
        ("--mapping", mapping is not None),
    ):
        if refused:
            remedy = "give --dialect verilog-a" if option == "--dialect" else "leave it out"
            raise ParameterError(f"{option}: the behavioural level comes as verilog-a text alone; {remedy}")


def _as_cells(choice: Choice) -> str:
    """Behavioural cells of the chosen block, in Verilog-A (`netlists.verilog_a.cell`)."""
    circuit, name = choice.circuit, choice.block.name
    sheet = _cells_of(name).sheet(circuit, choice.silicon)
    cells = CellArray(circuit.name, sheet.shape, sheet.figures, sheet.remarks)
    return format_cells(cells, choice.silicon, name)


def _cells_of(name: str) -> Cells:
    """How the cells of a block are written down; raises `ParameterError` where no model has any."""
    known: list[str] = []
    for model in map(load_model, model_names()):
        if model.cells is not None:
            if name in model.cells.blocks:
                return model.cells
            known += model.cells.blocks
    raise ParameterError(
        f"--level: {name} has no behavioural cell, {', '.join(known)} have; leave --level out"
    )


def _refuse_with_mapping(dialect: str, settings: Settings) -> None:
    for option, refused in (
        ("--dialect", dialect != "ngspice"),
        ("--models", settings.models != "ekv"),
        ("--parasitics", bool(settings.parasitics)),
    ):
        if refused:
            raise ParameterError(f"{option}: a foundry's process comes as ngspice text alone; leave it out")


def _on_foundry(choice: Choice, name: str) -> str:
    """Deck of the chosen block on a foundry's process (`netlists.foundry.deck`)."""
    die = choice.silicon.die
    if die.number is not None or die.corner not in {"random", "typical"}:
        raise ParameterError(f"--mapping: {die}, must be the nominal die; leave --die and --corner out")
    mapping = read_mapping(name)
    circuit = map_circuit(choice.circuit, mapping, choice.silicon)
    bench = choice.block.testbench(circuit, choice.stimuli, mapping.v_dd)
    return format_foundry(begun(bench, choice.begin), mapping, choice.silicon.temperature_c)
