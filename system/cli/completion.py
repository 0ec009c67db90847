"""Completion of commands, options and names in bash, zsh and fish.

A shell's script asks by calling `noctule` with the variable `VARIABLE`, and typer answers. Words of a value
come from tables, so that nothing heavy is loaded for them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import StrEnum
from typing import Any

import typer
from typer import completion

from circuits.errors import CircuitError

VARIABLE = "_NOCTULE_COMPLETE"
_NAME = "noctule"
_typers: Any = completion  # which names what it shares, but not as its own


class Shell(StrEnum):
    """A shell that asks."""

    BASH = "bash"
    ZSH = "zsh"
    FISH = "fish"


def answer(app: typer.Typer) -> None:
    """Print the words that may stand at the cursor, and end the process; none where the line is wrong."""
    _typers.completion_init()
    try:
        typer.main.get_command(app).main(prog_name=_NAME, complete_var=VARIABLE)
    except (CircuitError, ImportError) as error:  # it is told when the command is run
        raise SystemExit(0) from error


def script_of(shell: Shell) -> str:
    """Give the script by which a shell asks."""
    text: str = _typers.get_completion_script(prog_name=_NAME, complete_var=VARIABLE, shell=shell.value)
    return text


def install(shell: Shell) -> str:
    """Write that script where the shell finds it; returns a line that says where.

    Raises `OSError` where the user's home cannot be written.
    """
    _, path = _typers.install(shell=shell.value, prog_name=_NAME, complete_var=VARIABLE)
    return f"{path}: completion for {shell.value}, which takes effect in a new terminal"


def words_from(listed: Callable[[], Iterable[str]]) -> Callable[[str], list[str]]:
    """Give the completion of a value by the words that a function lists, as typer takes it."""

    def complete(incomplete: str) -> list[str]:
        return [word for word in listed() if word.startswith(incomplete)]

    return complete
