"""Edits of a die held against the devices that there are: a path that means none is refused."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

from circuits.circuit import Circuit
from circuits.errors import UnknownNameError, meant
from circuits.lowering.flatten import flatten
from circuits.lowering.variation import drawn_families
from circuits.registry import BLOCKS
from circuits.silicon.die import Die, Path
from circuits.silicon.edit import SHARED, not_met, unmatched
from circuits.silicon.silicon import Silicon

FIELDS = {"set": "deviate"}  # by which an edit is asked for, where it is not called as its kind
_COPY, _GENERATOR = ".bias copy", ".bias generator"  # what biases stand on, beside devices of the circuit
_PROCESS = "process."  # before what a polarity shares


def check_edits(die: Die, circuits: Iterable[tuple[Circuit, Silicon]]) -> None:
    """Raise `UnknownNameError` for a path of the die's edits that means no device of some circuits.

    A deviation that is set of another block passes beside one of these circuits: a die has more blocks than
    the one that is run.

    Parameters
    ----------
    die
        The die.
    circuits
        Each circuit, and the silicon that has its place.
    """
    if not die.edits:
        return
    circuits = list(circuits)
    families = [each for circuit, on in circuits for each in drawn_families(flatten(circuit), on)]
    own = {circuit.name for circuit, _ in circuits}
    told = {path: edit.parameter for edit in die.edits if edit.kind == "set" for path in edit.paths}
    for path in unmatched(die.edits, families):
        if _COPY not in path and not (path in told and _of_another_block(path, own)):
            asked = told.get(path, "")
            if _GENERATOR in path and not any(_GENERATOR[1:] in str(paths) for _, paths, _ in families):
                raise UnknownNameError(
                    f"{_field(die, path)}: {path}, no bias stands on a generator here; take the bias kind"
                    " generator"
                )
            like = [(p, paths) for p, paths, name in families if asked in {"", name.removeprefix(SHARED)}]
            raise _no_device(die, path, like, f" with {asked}" if asked else "")
    devices = [path for path in told if not path.startswith(_PROCESS)]
    if devices and all(_of_another_block(path, own) for path in devices):
        raise UnknownNameError(
            f"{_field(die, devices[0])}: {devices[0]}, is of another circuit, as all of them; take a die of"
            f" {', '.join(sorted(own))}"
        )


def _of_another_block(path: str, own: Collection[str]) -> bool:
    head = path.partition(".")[0].partition("[")[0]
    return head not in own and head.replace("_", "-") in BLOCKS


def check_known(die: Die, circuits: Iterable[Circuit]) -> None:
    """Raise `UnknownNameError` for a path of edits that begins as some circuits do and means no device.

    Parameters
    ----------
    die
        The die.
    circuits
        What a robot is made of; a path that begins with another name passes, and one of a generator of
        biases, whose lines are known when they are drawn.
    """
    if not die.edits:
        return
    for circuit in circuits:
        own = [replace(e, paths=kept) for e in die.edits if (kept := _of(e.paths, circuit.name))]
        check_edits(replace(die, edits=tuple(own)), [(circuit, Silicon())])


def _of(paths: Iterable[str], name: str) -> tuple[str, ...]:
    return tuple(path for path in paths if path.startswith(f"{name}.") and _GENERATOR not in path)


def check_drawn(die: Die) -> None:
    """Raise `UnknownNameError` for a path of the die's edits that meant nothing of what was drawn for a run.

    What a run draws is known once it was made, in the process that made it.

    Parameters
    ----------
    die
        The die of the run.
    """
    for path, drawn in not_met(die.edits).items():
        raise _no_device(die, path, drawn)


def _no_device(
    die: Die, path: str, drawn: Iterable[tuple[Path, Sequence[Path]]], which: str = ""
) -> UnknownNameError:
    known = dict.fromkeys(name for place, paths in drawn for name in _names(place, paths))
    return UnknownNameError(
        f"{_field(die, path)}: {path}, is the path of no device{which}{meant(path, known)}"
    )


def _field(die: Die, path: str) -> str:
    """By which field the edit of a path is asked for."""
    kind = next(edit.kind for edit in die.edits if path in edit.paths)
    return FIELDS.get(kind, kind)


def _names(place: Path, paths: Sequence[Path]) -> Iterable[str]:
    """Paths of devices and of what is around them, with `*` for each index."""
    for path in paths:
        parts = [f"{name}[{','.join(map(str, index))}]" if index else name for name, index in place]
        for name, shape in path:
            parts.append(f"{name}[*]" if shape else name)
            yield ".".join(parts)
