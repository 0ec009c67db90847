"""Blocks that a verb of the command line asks for, with their sizes, biases, silicon and stimuli."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, Literal

from circuits.catalogue import loaded
from circuits.checks import implausible_allowed
from circuits.errors import DataError, ParameterError
from circuits.lowering.coupling import coupled
from circuits.silicon.process import AMI_1500, PROCESSES
from circuits.silicon.process_file import foundry_names, measured_names
from system.cli.shared_options import BlockValues
from system.options.begin import FREE, BeginChoice
from system.options.block import Choice, choose
from system.options.code import Code
from system.options.silicon import SiliconChoice
from system.options.target import deck_of, driven

if TYPE_CHECKING:
    from netlists.read import Imported
    from netlists.read.analysis import Stepped


def choose_block(
    name: str,
    values: BlockValues,
    silicon: SiliconChoice,
    stimuli: Iterable[str] = (),
    begin: BeginChoice = FREE,
    steps: Literal["refused", "left"] = "refused",
) -> Choice:
    """Give the block or chip that a verb asks for, with its values on silicon.

    It raises the errors of `system.options.block.choose`, `DataError` for a deck whose steps are refused, and
    `ParameterError` for a coupling in a process whose layout has other figures.

    Parameters
    ----------
    name : name of the block or chip.
    values : sizes, biases and coupling, as texts of the command line.
    silicon : die, temperature and corner that are asked for.
    stimuli : what the testbench applies, as texts `NAME=VALUE`.
    begin : state in which runs begin.
    steps : whether a deck that steps something is refused, or taken as it stands before its steps.
    """
    if steps == "refused":
        refuse_steps(name)
    found = choose(
        target_of(name, values), values.param, values.bias, values.bias_kind, silicon, stimuli,
        values.bias_set, begin,
    )  # fmt: skip
    process = found.silicon.process.name
    if values.coupling != "none" and process in _others():
        raise ParameterError(
            f"coupling: {values.coupling}, its figures are those of the 1.5 um line, and {process} has other"
            " wires; leave it out"
        )
    return replace(found, circuit=coupled(found.circuit, values.coupling))


def _others() -> frozenset[str]:
    """Names of the processes that are known not to be the 1.5 um line; a file of the user's may be one."""
    return frozenset((*PROCESSES, *foundry_names(), *measured_names())) - {AMI_1500.name}


def refuse_steps(name: str) -> None:
    """Raise `DataError` for a whole deck that steps something, of which one run has none."""
    for step in steps_of(name):
        what = f"param {step.name}" if step.is_parameter else step.name
        raise DataError(f"{step.place}: .step {what}: not of one run; noctule sweep {name} runs all")


def steps_of(name: str) -> tuple[Stepped, ...]:
    """Give what a whole deck steps; nothing for any other target."""
    deck = deck_of(name)
    if deck is None or deck.name or not deck.path.is_file():
        return ()
    with implausible_allowed():
        steps: tuple[Stepped, ...] = _read_netlist()(deck.path, foreign="kept").steps
        return steps


def whole_deck(name: str, choice: Choice) -> Imported | None:
    """Read the whole deck that a name is of, as in a choice of it; None for any other target."""
    deck = deck_of(name)
    return None if deck is None or deck.name else read_with(deck, choice)


def read_with(deck: Code, choice: Choice, moved: Mapping[str, float] | None = None) -> Imported:
    """Read a deck with the values that its parameters have in a choice of it, or with other ones."""
    given = {f.name: getattr(choice.params, f.name) for f in fields(choice.params)} | dict(moved or {})
    with implausible_allowed(choice.allow_implausible):
        usual: Imported = _read_netlist()(deck.path)
        changed = {name: value for name, value in given.items() if value != usual.parameters.get(name, value)}
        return _read_netlist()(deck.path, parameters=changed) if changed else usual


def _read_netlist() -> Any:
    """What reads netlists, which is slow to import."""
    return loaded("netlists.read:read_netlist")


def target_of(name: str, values: BlockValues) -> str:
    """Give the text of the block or chip that a verb asks for, with the testbench that its options name."""
    return name if values.testbench is None else driven(name, values.testbench)
