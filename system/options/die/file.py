"""A die as a file in TOML, which every command takes for `die`, and what edits it.

    lot = "A"
    die = 1003                     # its number; left out for the nominal die
    corner = "random"
    mismatch = true
    process_variation = true
    variation = "plain"
    only = ["ranging_chip/*"]      # these alone deviate
    heal = ["ranging_chip/neuron[12]"]

    [[deviation]]
    path = "ranging_chip/neuron[2].membrane.mr1"
    parameter = "v_t0"             # or beta, capacitance, resistance, saturation_current
    value = "12mV"                 # of the others relative, as "3%" or "0.03"

A die that was identified from measurements has the table `posterior` too
(`circuits.extraction.coach.posterior`).

Every key may be left out; it then is as `circuits.silicon.die.Die` has it. `circuits.silicon.edit` says what
paths are.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec

from circuits.errors import DataError, ParameterError
from circuits.extraction.coach.posterior import PosteriorTable, read_table
from circuits.silicon.components import Extent
from circuits.silicon.die import Corner, Die
from circuits.silicon.edit import DEVIATIONS, Edit
from circuits.units import parse_quantity
from system.files.document import document_bytes, from_toml
from system.files.writing import write_bytes_atomic
from system.options.assignment import split_assignment
from system.options.silicon import SiliconChoice
from system.reader import whole

_REMEDY = "must be a die as the reference of files has it"


class _Deviation(msgspec.Struct, forbid_unknown_fields=True):
    """A deviation that is set by hand.

    Attributes
    ----------
    path : str
        Path of the devices.
    parameter : str
        `v_t0`, `beta`, `capacitance`, `resistance` or `saturation_current`.
    value : str
        What it deviates by: V_T0's magnitude with its unit, the others relative, as `3%` or `0.03`.
    """

    path: str
    parameter: str
    value: str


class DieFile(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """What a file says of a die.

    Attributes
    ----------
    lot : str
        Name of the lot.
    die : int or None
        Number in the lot; left out for the nominal die.
    corner : str
        Process corner, or `random` for the die's own draw.
    mismatch, process_variation : bool
        Whether local deviations, and those that all devices of a die share, are drawn.
    variation : str
        Components of variation it has beside: `plain`, `transistors` or `full`.
    only : list of str
        Paths of the devices that alone deviate; all where there is none.
    heal : list of str
        Paths of devices that do not deviate.
    deviation : list
        Deviations that are set by hand.
    posterior : table or None
        What measurements left of the die, where it was identified from some.
    """

    lot: str = "A"
    die: int | None = None
    corner: Corner = "random"
    mismatch: bool = True
    process_variation: bool = True
    variation: Extent = "plain"
    only: list[str] = []
    heal: list[str] = []
    deviation: list[_Deviation] = []
    posterior: PosteriorTable | None = None


def edits_of(only: Iterable[str], heal: Iterable[str], deviate: Iterable[str]) -> tuple[Edit, ...]:
    """Make edits of a die from texts.

    Parameters
    ----------
    only, heal
        Paths of devices.
    deviate
        Deviations, as `PATH.v_t0=12mV`.

    Raises
    ------
    ParameterError
        A text is no path, or no deviation.
    """
    only, heal = tuple(only), tuple(heal)
    found = [Edit("only", only)] if only else []
    found += [Edit("heal", heal)] if heal else []
    for text in deviate:
        name, value = split_assignment(text, "deviate")
        path, _, parameter = name.rpartition(".")
        found.append(_set(path, parameter, value))
    return tuple(found)


def _set(path: str, parameter: str, value: str) -> Edit:
    if parameter not in DEVIATIONS or not path:
        known = ", ".join(DEVIATIONS)
        raise ParameterError(f"deviate: {path}.{parameter}, must end with one of {known}; as PATH.v_t0=12mV")
    unit, percent = DEVIATIONS[parameter], value.strip().endswith("%")
    number = parse_quantity(
        value.strip().removesuffix("%") if not unit else value, unit, f"{path}.{parameter}"
    )
    return Edit("set", (path,), parameter, number / 100.0 if percent and not unit else number)


def read_die_file(path: Path) -> Die:
    """Read the die that a file states.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataError
        It cannot be read, or is no die: one line of file, key, value and rule.
    """
    found = _document(path)
    try:
        edits = (
            *edits_of(found.only, found.heal, ()),
            *(_set(each.path, each.parameter, each.value) for each in found.deviation),
        )
        return Die(
            found.lot, found.die, found.corner, found.mismatch, found.process_variation,
            variation=found.variation, edits=edits,
        )  # fmt: skip
    except ParameterError as error:
        raise DataError(f"{path}: {error}") from None


def _document(path: Path) -> DieFile:
    try:
        text = document_bytes(path, _REMEDY)
    except FileNotFoundError:
        raise DataError(f"{path}: no such file, must be a die's number or its file") from None
    found = from_toml(text, DieFile, str(path), _REMEDY)
    if found == DieFile() and not msgspec.toml.decode(text):
        raise DataError(f'{path}: states nothing, must state a die; lot = "A" alone is the nominal die')
    return found


def read_posterior(path: Path) -> PosteriorTable:
    """Read what measurements left of the die that a file states.

    Raises `DataError` as `read_die_file` does, and for a die that was not identified.
    """
    return _document(path).posterior or read_table(path)


def write_die_file(path: Path, die: Die, posterior: PosteriorTable | None = None) -> None:
    """Write a die, whole or not at all.

    Parameters
    ----------
    path
        The file.
    die
        The die, with its own draws.
    posterior
        What measurements left of it.

    Raises
    ------
    ParameterError
        The die is one of a plan, whose draws the file has no place for.
    DataError
        The file cannot be written.
    """
    if die.sampling is not None:
        raise ParameterError(f"{path}: {die}, must be a die of its own draws; name its study instead")
    stated = _stated(die)
    stated.posterior = posterior
    document: dict[str, Any] = {"lot": die.lot, **msgspec.to_builtins(stated)}  # never an empty file
    write_bytes_atomic(path, msgspec.toml.encode(document))


def _stated(die: Die) -> DieFile:
    paths = {kind: [p for e in die.edits if e.kind == kind for p in e.paths] for kind in ("only", "heal")}
    return DieFile(
        die.lot, die.number, die.corner, die.mismatch, die.process, die.variation, paths["only"],
        paths["heal"],
        [
            _Deviation(e.paths[0], e.parameter, f"{e.value!r}{DEVIATIONS[e.parameter]}")
            for e in die.edits
            if e.kind == "set"
        ],
    )  # fmt: skip


def with_die(chosen: SiliconChoice) -> SiliconChoice:
    """Return the silicon with the die that its text names: a number, or a file.

    Parameters
    ----------
    chosen
        The silicon, whose `die` is a text.

    Raises
    ------
    DataError
        The file cannot be read, or is no die.
    ParameterError
        The text is neither, or another option says what the file does.
    """
    text = str(chosen.die)
    if not _is_file(text):
        return replace(chosen, die=whole(text, "die"))
    usual = SiliconChoice()
    for name in ("lot", "corner", "mismatch", "process_variation", "variation"):
        if getattr(chosen, name) != getattr(usual, name):
            raise ParameterError(f"{name}: {getattr(chosen, name)}, {text} states the die; leave one out")
    die = read_die_file(Path(text))
    told = _stated(die)
    return replace(
        chosen, lot=die.lot, die=die.number, corner=die.corner, mismatch=die.mismatch,
        process_variation=die.process, variation=die.variation,
        only=(*told.only, *chosen.only), heal=(*told.heal, *chosen.heal),
        deviate=(*(f"{d.path}.{d.parameter}={d.value}" for d in told.deviation), *chosen.deviate),
    )  # fmt: skip


def identified_file(text: str) -> Path | None:
    """The file that a text names, where it is that of a die that was identified; None of another die.

    Raises `DataError` as `read_die_file` does.
    """
    if not _is_file(text):
        return None
    return None if _document(Path(text)).posterior is None else Path(text)


def _is_file(text: str) -> bool:
    """Whether a text names a die's file, and not its number."""
    return text.endswith(".toml") or Path(text).is_file()
