"""Testbenches whose runs begin in the state that the command line asks for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from circuits.lowering.flatten import flatten
from circuits.testbench import Testbench
from circuits.units import parse_quantity
from system.options.assignment import split_assignment
from system.options.begin import FREE, BeginChoice


def begun(testbench: Testbench, choice: BeginChoice) -> Testbench:
    """Give the testbench with the chosen state in the place of its own.

    Raises `UnknownNameError` for a node that its circuit does not have, `ParameterError` for no voltage.
    """
    if choice == FREE:
        return testbench
    voltages = read_voltages(choice.held, "ic")
    flat = flatten(testbench.circuit)
    for node in voltages:
        flat.node(node)
    begin = testbench.begin if choice.begin == "disturbed" else choice.begin
    return replace(testbench, initial={**testbench.initial, **voltages}, begin=begin)


def read_voltages(texts: Iterable[str], option: str) -> dict[str, float]:
    """Read texts `NODE=V` as voltages, V, by the path of their node; `option` is named in errors."""
    pairs = (split_assignment(text, option, keep=True) for text in texts)
    return {name: parse_quantity(value, "V", name) for name, value in pairs}
