"""`noctule export`: a block or chip with its testbench as text for another simulator."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from circuits.circuit import BiasKind
from netlists.ngspice_text import format_testbench
from system.commands.output import print_json
from system.files import write_text_atomic
from system.options import choose, describe_silicon
from system.silicon_choice import SiliconChoice

FORMATS = {"ngspice": format_testbench}


def export_command(
    block: str,
    *,
    params: Sequence[str],
    biases: Sequence[str],
    bias_kind: BiasKind | None,
    silicon: SiliconChoice,
    stimuli: Sequence[str],
    dialect: str,
    output: str,
    as_json: bool,
) -> None:
    """Write the netlist to the file `output`, `-` being stdout (with `--json` inside the document)."""
    choice = choose(block, params, biases, bias_kind, silicon, stimuli)
    text = FORMATS[dialect](choice.testbench(), choice.silicon)
    to_stdout = output == "-"
    if not to_stdout:
        write_text_atomic(output, text)
    if as_json:
        print_json(
            {
                "block": choice.block.name,
                "dialect": dialect,
                **describe_silicon(choice.silicon),
                "stimuli": choice.stimuli,
                "file": None if to_stdout else output,
                "lines": text.count("\n"),
                **({"netlist": text} if to_stdout else {}),
            }
        )
    elif to_stdout:
        sys.stdout.write(text)
