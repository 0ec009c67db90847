"""`noctule export`: a block or chip with its testbench as text for another simulator."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.lowering.flatten import flatten
from circuits.testbench import Testbench
from netlists.dialect import Settings, load_dialect
from netlists.foundry import read_mapping
from netlists.foundry_deck import format_foundry, map_circuit
from netlists.parasitics import read_parasitics
from system.commands.output import print_json
from system.files import write_text_atomic
from system.options import Choice, choose, describe_silicon
from system.silicon_choice import SiliconChoice


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
    dialect: str,
    models: str,
    parasitics: str | None,
    output: str,
    as_json: bool,
) -> None:
    """Write the netlist to the file `output`, `-` being stdout (with `--json` inside the document)."""
    choice = choose(block, params, biases, bias_kind, silicon, stimuli, bias_set=bias_set)
    bench = choice.testbench()
    loads = {} if parasitics is None else read_parasitics(parasitics, choice.circuit)
    settings = Settings(models, parasitics=loads)
    if mapping is None:
        text = load_dialect(dialect).write(bench, choice.silicon, settings)
    else:
        _refuse_with_mapping(dialect, settings)
        text = _on_foundry(choice, mapping)
    to_stdout = output == "-"
    if not to_stdout:
        write_text_atomic(output, text)
    if as_json:
        print_json(
            {
                "block": choice.block.name,
                "dialect": dialect,
                "models": models,
                "parasitics": len(loads),
                **_contents(bench, text),
                "mapping": mapping,
                **describe_silicon(choice.silicon),
                "stimuli": choice.stimuli,
                "file": None if to_stdout else output,
                "lines": text.count("\n"),
                **({"netlist": text} if to_stdout else {}),
            }
        )
    elif to_stdout:
        sys.stdout.write(text)


def _contents(bench: Testbench, text: str) -> dict[str, int]:
    """How many definitions a netlist has, and devices in all its places."""
    noted = sum(line.lstrip("*/").startswith("% circuit ") for line in text.splitlines())
    plain = text.count("\n.subckt ")
    devices = sum(group.nodes.shape[1] for group in flatten(bench.circuit).groups)
    return {"definitions": noted or plain, "devices": devices}


def _refuse_with_mapping(dialect: str, settings: Settings) -> None:
    for option, refused in (
        ("--dialect", dialect != "ngspice"),
        ("--models", settings.models != "ekv"),
        ("--parasitics", bool(settings.parasitics)),
    ):
        if refused:
            raise ParameterError(f"{option}: a foundry's process comes as ngspice text alone; leave it out")


def _on_foundry(choice: Choice, name: str) -> str:
    """Deck of the chosen block on a foundry's process (`netlists.foundry_deck`)."""
    die = choice.silicon.die
    if die.number is not None or die.corner not in {"random", "typical"}:
        raise ParameterError(f"--mapping: {die}, must be the nominal die; leave --die and --corner out")
    mapping = read_mapping(name)
    circuit = map_circuit(choice.circuit, mapping, choice.silicon)
    bench = choice.block.testbench(circuit, choice.stimuli, mapping.v_dd)
    return format_foundry(bench, mapping, choice.silicon.temperature_c)
