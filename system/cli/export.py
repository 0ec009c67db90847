"""The verb `noctule export`: writes a block or chip with its testbench for another simulator."""

from __future__ import annotations

from dataclasses import replace

from chips.model import Cells, load_model, model_names
from circuits.errors import ParameterError, unknown_name
from circuits.lowering.flatten import flatten
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.foundry.deck import format_foundry, map_circuit
from netlists.foundry.engine import RELTOL, deck_of, on_cards
from netlists.foundry.process import process_names, read_mapping
from netlists.registry import Settings, load_dialect
from netlists.verilog_a.cell import CellArray, format_cells
from system.cli.block_choice import choose_block, whole_deck
from system.cli.export_rolls import export_rolls
from system.cli.netlist_output import STDOUT, leave_netlist, settings_of, unwritten
from system.cli.output import print_line
from system.cli.verbs import Export
from system.options.begin import refuse_beginning
from system.options.begun import begun
from system.options.block import ROLLS, Choice, describe_silicon, refuse_bias_file
from system.options.cards import cards_lines, describe_cards
from system.registry import XSCHEM, written_names
from system.schematic.xschem import to_xschem


def export_command(asked: Export) -> None:
    """Write the netlist to the file `output`, where `-` stands for stdout.

    With `--json` a netlist for stdout is part of the JSON document.
    """
    block, mapping = asked.block, asked.mapping
    if block == ROLLS:
        refuse_beginning(asked.begin, block)
        export_rolls(asked)
        return
    refuse_bias_file(block, asked.values.bias_file)
    if asked.program is not None:
        raise ParameterError(f"--program: {asked.program}, of rolls only; leave it out for {block}")
    choice = choose_block(block, asked.values, asked.silicon, asked.stimulus, asked.begin)
    bench = choice.testbench()
    settings = settings_of(asked, choice.circuit)
    text = _text(asked, choice, settings)
    sizes = None if mapping is None else str(read_mapping(mapping).sizes)
    deck = whole_deck(block, choice)
    left = [] if deck is None else [*unwritten(deck)]
    contents = _contents(bench, text) if asked.level == "transistor" else {"cells": text.count("  x")}
    document = {
        "block": choice.block.name, "dialect": asked.dialect, "level": asked.level, "models": asked.models,
        "parasitics": len(settings.parasitics), **contents, "mapping": mapping, "mapped_sizes": sizes,
        "unwritten": left,
        **describe_silicon(choice.silicon), **describe_cards(choice.silicon, asked.dialect), "stimuli":
        choice.stimuli,
    }  # fmt: skip
    leave_netlist(asked, text, document)
    if not asked.as_json and asked.output != STDOUT and mapping is None and asked.level == "transistor":
        for line in cards_lines(choice.silicon, asked.dialect):
            print_line(f"{asked.output}: {line}")
    if left and not asked.as_json and asked.output != STDOUT:
        print_line(f"{asked.output}: not written: {', '.join(left)}; {block} has them")
    if sizes is not None and not asked.as_json and asked.output != STDOUT:
        print_line(f"{asked.output}: on {mapping} sizes of transistors are not those of {block}: {sizes}")


def _text(asked: Export, choice: Choice, settings: Settings) -> str:
    """The netlist that is asked for."""
    mapping = asked.mapping
    if asked.level == "behavioural":
        refuse_beginning(asked.begin, "the behavioural level")
        _refuse_with_behavioural(asked.dialect, mapping, settings)
        return _as_cells(choice)
    if mapping is not None:
        _refuse_with_mapping(asked.dialect, settings)
        return _on_foundry(choice, mapping)
    if choice.silicon.process.cards and asked.dialect == "ngspice":
        _refuse_with_cards(settings)
        return _on_cards(choice, settings)
    if asked.dialect == XSCHEM:
        _refuse_with_schematic(settings)
        _refuse_with_drawing(XSCHEM, choice.silicon)
        return to_xschem(choice.circuit)
    if asked.dialect not in written_names():
        raise unknown_name("dialect", asked.dialect, written_names())
    chosen = load_dialect(asked.dialect)
    if chosen.drawing:
        _refuse_with_drawing(chosen.name, choice.silicon)
    return chosen.write(choice.testbench(), choice.silicon, settings)


def _contents(bench: Testbench, text: str) -> dict[str, int]:
    """How many definitions a netlist has, and devices in all its places."""
    noted = sum(line.lstrip("*/").startswith("% circuit ") for line in text.splitlines())
    plain = text.count("\n.subckt ")
    devices = sum(group.nodes.shape[1] for group in flatten(bench.circuit).groups)
    return {"definitions": noted or plain, "devices": devices}


def _refuse_with_schematic(settings: Settings) -> None:
    for option, refused in (
        ("--models", settings.models != "ekv"),
        ("--parasitics", bool(settings.parasitics)),
    ):
        if refused:
            raise ParameterError(f"{option}: not of a schematic, which names nmos and pmos; leave it out")


def _refuse_with_drawing(dialect: str, silicon: Silicon) -> None:
    """Raise `ParameterError` for a drawing on a die or at a temperature: all are drawn alike."""
    die, nominal = silicon.die, silicon.process.nominal_temperature_c
    for option, value, refused in (
        ("--die", die, die.deviates),
        ("--corner", die.corner, die.corner not in {"random", "typical"}),
        ("--temperature", f"{silicon.temperature_c:g} degC", silicon.temperature_c != nominal),
    ):
        if refused:
            raise ParameterError(
                f"{option}: {value}, {dialect} is the drawing, for LVS, which no {option[2:]} changes;"
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


def _refuse_with_cards(settings: Settings) -> None:
    for option, refused in (
        ("--models", settings.models != "ekv"), ("--parasitics", bool(settings.parasitics)),
    ):  # fmt: skip
        if refused:
            raise ParameterError(f"{option}: not with a foundry's cards, which stay as they are; omit it")


def _on_foundry(choice: Choice, name: str) -> str:
    """Deck of the chosen block on a foundry's process (`netlists.foundry.deck`)."""
    if name in process_names():
        raise ParameterError(
            f"--mapping: {name}, a foundry's process; give --process {name}, or a TOML file of your own"
        )
    die = choice.silicon.die
    mapping = read_mapping(name)
    known = mapping.statistics is not None or mapping.statistics_of
    if not known and (die.deviates or die.corner not in {"random", "typical"}):
        raise ParameterError(f"--mapping: {die}, must be the nominal die; leave --die and --corner out")
    circuit = map_circuit(choice.circuit, mapping, choice.silicon)
    bench = choice.block.testbench(circuit, choice.stimuli, mapping.v_dd)
    return format_foundry(begun(bench, choice.begin), mapping, choice.silicon)


def _on_cards(choice: Choice, settings: Settings) -> str:
    """Deck of the chosen block on its process's cards, in its drawn sizes (`netlists.foundry.engine`)."""
    bench = on_cards(choice.testbench(), choice.silicon)
    return deck_of(bench, choice.silicon, replace(settings, reltol=RELTOL))
