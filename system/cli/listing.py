"""The verb `noctule list`: shows all blocks, chips, systems and so on, with a line on each.

Neither what is noctule's own nor what prints tables is loaded for it, so that the list is there at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import typer

from chips.registry import chip_line, chip_names
from circuits.catalogue import loaded
from circuits.errors import CircuitError
from circuits.registry import BLOCKS, block_line, block_names, metric_line, metric_names
from system.cli.exit_status import DONE, NO
from system.cli.verbs import List
from system.notice import say
from system.registry import (
    EXPERIMENTS,
    calibration_line,
    calibration_names,
    experiment_line,
    experiment_names,
    system_line,
    system_names,
    written_line,
    written_names,
)

_BROKEN = "cannot be loaded: "
_OTHERS = "Of other packages"


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of things that have a name.

    title: as JSON's key; names, line: of all of them, and of one; takes: what is done with one; places: where
    each stands, of a kind whose things stand together by the folder that they are in.
    """

    title: str
    names: Callable[[], Sequence[str]]
    line: Callable[[str], str]
    takes: str
    places: Mapping[str, str] = field(default_factory=dict)


KINDS = (
    Kind(
        "blocks",
        block_names,
        block_line,
        "show, op, sweep, simulate, export, montecarlo, centre NAME",
        BLOCKS,
    ),
    Kind("chips", chip_names, chip_line, "show, simulate, export NAME; a block's place: --at NAME/PART[0]"),
    Kind("calibrations", calibration_names, calibration_line, "calibrate NAME --die K -o FILE"),
    Kind("systems", system_names, system_line, "run, montecarlo NAME; options: run NAME --help"),
    Kind("experiments", experiment_names, experiment_line, "reproduce NAME", EXPERIMENTS),
    Kind("metrics", metric_names, metric_line, "montecarlo BLOCK --metric NAME"),
    Kind("dialects", written_names, written_line, "export BLOCK --dialect NAME"),
)


def list_command(asked: List) -> int:
    """Print all that has a name, by its kind; returns `NO` where one of them cannot be loaded."""
    found = {kind.title: {name: _line(name, kind.line) for name in kind.names()} for kind in KINDS}
    if asked.as_json:
        print_json: Any = loaded("system.cli.output:print_json")
        print_json(
            {title: [{"name": n, "summary": s} for n, s in each.items()] for title, each in found.items()}
        )
    else:
        typer.echo("\n\n".join("\n".join(_text(kind, found[kind.title])) for kind in KINDS))
    broken = [name for each in found.values() for name, line in each.items() if line.startswith(_BROKEN)]
    if broken:
        say(f"list: {', '.join(broken)} cannot be loaded; see the summary, mend or uninstall what brings it")
    return NO if broken else DONE


def _line(name: str, line: Callable[[str], str]) -> str:
    """One entry that cannot be loaded must not hide the others."""
    try:
        return line(name)
    except (ImportError, CircuitError) as error:
        return f"{_BROKEN}{error}"


def _text(kind: Kind, lines: Mapping[str, str]) -> Iterator[str]:
    """Lines of a kind: its title, then its things, those of a folder under what the folder is."""
    yield f"{typer.style(kind.title, bold=True)}  (noctule {kind.takes})"
    families: dict[str, list[str]] = {_family(place): [] for place in kind.places.values()}
    for name in lines:
        families.setdefault(_family(kind.places[name]) if name in kind.places else "", []).append(name)
    for family, names in families.items():
        if not names:
            continue
        if kind.places:
            yield f"\n{_heading(family)}"
        width = max(map(len, names))
        yield from (f"  {name:{width}}  {lines[name]}" for name in names)


def _family(place: str) -> str:
    """Package in which the module of a place stands."""
    return place.partition(":")[0].rpartition(".")[0]


def _heading(family: str) -> str:
    """What a package is, as it says itself in its first line."""
    if not family:
        return _OTHERS
    return str(loaded(f"{family}:__doc__") or family).partition("\n")[0].rstrip(".")
