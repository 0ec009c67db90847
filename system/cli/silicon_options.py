"""The options that say which silicon a command runs on, declared once; and commands that run a system.

A command declares a parameter `silicon: SiliconChoice`; the options that it is read from take its place.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any

from circuits.catalogue import loaded
from circuits.errors import ParameterError
from system.cli.command_options import (
    AllowImplausible,
    At,
    BiasKind,
    Corner,
    DieCorner,
    DieNumber,
    Lot,
    Mismatch,
    Process,
    StudyFolder,
    Temperature,
    call,
)
from system.options.silicon import SiliconChoice

Command = Callable[..., None]

PARAMETER = "silicon"
OPTIONS: dict[str, tuple[Any, Any]] = {
    "temperature": (Temperature, "27"),
    "lot": (Lot, "A"),
    "die": (DieNumber, None),
    "study": (StudyFolder, None),
    "corner": (DieCorner, Corner.random),
    "mismatch": (Mismatch, True),
    "process": (Process, True),
    "at": (At, None),
    "allow_implausible": (AllowImplausible, False),
}


def with_silicon(*left_out: str) -> Callable[[Command], Command]:
    """Put the options of a command's parameter `silicon`, but those `left_out`, in the place of that."""
    options = {name: option for name, option in OPTIONS.items() if name not in left_out}

    def decorate(command: Command) -> Command:
        @wraps(command)
        def run(**given: Any) -> None:
            chosen = {name: given.pop(name) for name in options}
            chosen["corner"] = chosen["corner"].value
            if chosen["study"] is not None:
                chosen["study"] = _studied(chosen["study"], chosen["die"])
            command(**given, **{PARAMETER: SiliconChoice(**chosen)})

        signature = inspect.signature(command, eval_str=True)
        parameters: list[inspect.Parameter] = []
        for parameter in signature.parameters.values():
            parameters += _parameters(options) if parameter.name == PARAMETER else [parameter]
        run.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
        run.__annotations__ = {p.name: p.annotation for p in parameters}
        return run

    return decorate


def _studied(folder: str, number: int | None) -> Any:
    """A die under the plan of the study in `folder`."""
    if number is None:
        raise ParameterError("--study: which die, must come with --die")
    return loaded("system.study.replay:die_of")(Path(folder), number)  # which takes a second to import


def _parameters(options: Mapping[str, tuple[Any, Any]]) -> list[inspect.Parameter]:
    kind = inspect.Parameter.KEYWORD_ONLY
    return [
        inspect.Parameter(name, kind, annotation=declared, default=default)
        for name, (declared, default) in options.items()
    ]


def runs(system: str, **called: str) -> Callable[[Command], Command]:
    """Make a declaration of options the command that runs `system`, by `run_SYSTEM` of `system.cli`.

    Options that are given go on, under their own names or those that `called` has for them.
    """

    def decorate(declared: Command) -> Command:
        @wraps(declared)
        def command(
            *, silicon: SiliconChoice, seed: int, plot: str | None, as_json: bool, **given: Any
        ) -> None:
            options = {called.get(name, name): _plain(value) for name, value in given.items()}
            known = {name: value for name, value in options.items() if value is not None}
            call(f"run_{system}:run_{system}", system, silicon, seed, plot, as_json=as_json, **known)

        return with_silicon("at", "allow_implausible")(command)

    return decorate


def _plain(value: Any) -> Any:
    """An enumeration by its value; an empty list is an option that was not given."""
    if isinstance(value, BiasKind):
        return value.value
    return None if value == [] else value
