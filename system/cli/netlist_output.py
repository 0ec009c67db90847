"""Output of `noctule export`, for blocks and for rows of ROLLS alike."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from typing import Any

from circuits.circuit import Circuit
from netlists.parasitics import read_parasitics
from netlists.read import Imported
from netlists.read.analysis import NoiseSpectrum, SmallSignals, Sweep
from netlists.registry import Settings
from system.cli.output import print_json
from system.cli.verbs import Export
from system.files.writing import write_text_atomic

STDOUT = "-"
# Analyses that no dialect is written with.
_LEFT = {Sweep: ".dc", SmallSignals: ".ac", NoiseSpectrum: ".noise"}


def settings_of(asked: Export, circuit: Circuit) -> Settings:
    """Give the settings of a netlist: how transistors are written, and which capacitances are merged in."""
    loads = {} if asked.parasitics is None else read_parasitics(asked.parasitics, circuit)
    return Settings(asked.models, parasitics=loads)


def leave_netlist(asked: Export, text: str, document: Mapping[str, Any]) -> None:
    """Write the text of a netlist to its file or to stdout.

    With `--json` the document is printed, which has the text as a member where no file is named.
    """
    to_stdout = asked.output == STDOUT
    if not to_stdout:
        write_text_atomic(asked.output, text)
    if asked.as_json:
        netlist = {"netlist": text} if to_stdout else {}
        file = None if to_stdout else asked.output
        print_json({**document, "file": file, "lines": text.count("\n"), **netlist})
    elif to_stdout:
        sys.stdout.write(text)


def unwritten(read: Imported) -> Iterator[str]:
    """Give what a netlist asks for that is not in one that is written of its circuit and testbench."""
    yield from dict.fromkeys(_LEFT[type(each)] for each in read.analyses if type(each) in _LEFT)
    if read.moved:
        yield f"AC values of {', '.join(read.moved)}"
    if read.measures:
        yield f"{len(read.measures)} of .measure"
    for step in read.steps:
        yield f".step of {step.name}"
