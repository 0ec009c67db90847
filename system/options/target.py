"""What a command is about: a registered name, a file of the user's, or an object.

Every command and every function that takes a block or chip finds it here. It is one of

- the name of a registered block or chip;
- `my_circuit.py:follower`, a name in a file of Python: a circuit, a testbench, a block, a circuit of PySpice,
  or a function that returns one of these (`system.options.code`);
- `deck.cir` or `deck.cir:subcircuit`, a netlist (`netlists.read.bench`), or `deck.cir:subcircuit@bench.toml`
  with what drives its ports (`netlists.read.bench_file`);
- from Python, such an object itself.

A circuit or testbench becomes a block by declared defaults (`circuits.blocks.plain`).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from keyword import iskeyword
from pathlib import Path
from typing import Any

from chips.registry import Chip
from circuits.blocks.arguments import Arguments, arguments_of, no_arguments, numbers_as_arguments
from circuits.blocks.block import Block, Values
from circuits.blocks.plain import Made, block_of
from circuits.catalogue import loaded
from circuits.circuit import Circuit
from circuits.errors import DataError, ParameterError
from circuits.silicon.process import AMI_1500, Process
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.registry import SUFFIXES
from system.options.code import Code, code_of, guarded, load_code, process_of, told_in_a_line
from system.registry import load_block_or_chip

Found = Block | Chip
Target = Any  # a text as above, a block, chip, circuit or testbench, one of PySpice, or a function of one

_DECK = re.compile(rf"(?P<path>.+(?:{'|'.join(map(re.escape, SUFFIXES))}))(?::(?P<name>.*))?", re.IGNORECASE)
_READ = "netlists.read.netlist:read_netlist"  # what reads netlists is slow to import
_BENCH = "@"  # before a testbench's file
_OURS = (Block, Chip, Circuit, Testbench)
_WANTED = "must be a Circuit, Testbench, Block or PySpice circuit, or a function that returns one"


def load_target(target: Target) -> Found:
    """Give the block or chip that a target is.

    Raises `UnknownNameError` for a name that nobody registered or that a file does not have, `DataError` for
    a file that cannot be read, and `ParameterError` for code that fails or makes something else.
    """
    if not isinstance(target, str):
        return _made_of(target, getattr(target, "__name__", None) or _name_of(target))
    code = code_of(target)
    if code is not None:
        return _of_code(code)
    deck = deck_of(target)
    return load_block_or_chip(target) if deck is None else _of_deck(deck)


def deck_of(text: str) -> Code | None:
    """Give the file and the sub-circuit of a text `deck.cir` or `deck.cir:subcircuit`; None for another.

    A file whose name does not end as those of netlists do must be there. Raises `ParameterError` for one of
    Python without a name in it.
    """
    found = _DECK.fullmatch(text)
    if found is None:
        path = Path(text)
        if path.suffix == ".py" and path.is_file():
            raise ParameterError(f"{text}: a file of Python, must come with a name in it; write {text}:NAME")
        return Code(path, "") if path.suffix and path.is_file() else None
    return Code(Path(found["path"]), found["name"] or "")


def driven(text: str, testbench: str) -> str:
    """Give the target of the sub-circuit that `deck.cir:subcircuit` names under a testbench's TOML file.

    Raises `ParameterError` for another target.
    """
    deck = deck_of(text)
    if deck is None or not deck.name or _BENCH in deck.name:
        raise ParameterError(f"testbench: {testbench}, is for deck.cir:SUBCIRCUIT; leave it out for {text}")
    return f"{text}{_BENCH}{testbench}"


def bench_of(deck: Code) -> tuple[str, Path | None]:
    """Give the sub-circuit that a netlist's target names, and the file of its testbench where it has one."""
    name, sign, testbench = deck.name.partition(_BENCH)
    return name, Path(testbench) if sign else None


def own_silicon(target: Target) -> tuple[float | None, Silicon | None]:
    """Give the temperature, degC, that a netlist states, and the silicon that our notes in it are of.

    Both are None for any other target.
    """
    deck = deck_of(target) if isinstance(target, str) else None
    if deck is None:
        return None, None
    found = loaded(_READ)(deck.path)
    return found.temperature_c, found.silicon


def file_of(target: Target) -> Path | None:
    """Give the file of the user's that a target names; None where it is no such text."""
    return next(iter(files_of(target)), None)


def files_of(target: Target) -> tuple[Path, ...]:
    """Give the files of the user's that a target names, a testbench's behind the netlist's."""
    code = code_of(target) if isinstance(target, str) else None
    if code is not None:
        return (code.path,)
    deck = deck_of(target) if isinstance(target, str) else None
    bench = None if deck is None else bench_of(deck)[1]
    return (*(() if deck is None else (deck.path,)), *(() if bench is None else (bench,)))


def split_place(text: str) -> tuple[str, list[str]]:
    """Split `CHIP/INSTANCE/...` into the chip, which may be in a file, and the instances inside it."""
    folder, python, rest = text.rpartition(".py:")
    chip, *parts = rest.split("/")
    return f"{folder}{python}{chip}", parts


def _of_code(code: Code) -> Found:
    thing, process = load_code(code), process_of(code)
    made = guarded(thing, code.path) if callable(thing) else thing
    name = f"{code.path.name}:{code.name}"
    found = _made_of(made, name, str(code), process)
    return replace(_told(found, code.path), name=name) if isinstance(found, Block) else found


def _told(block: Block, path: Path) -> Block:
    """A block of a user's file, all of whose functions tell file and line of an error."""
    with told_in_a_line(path):
        _ = block.sizes
    names = ("build", "testbench", "measures", "outcome", "closed_forms")
    given = {name: function for name in names if (function := getattr(block, name)) is not None}
    told: dict[str, Any] = {name: guarded(function, path) for name, function in given.items()}
    return replace(block, **told)


def _of_deck(deck: Code) -> Found:
    if not deck.path.is_file():
        raise DataError(f"{deck.path}: no such file; name a netlist that is there")
    part, testbench = bench_of(deck)
    imported = loaded(_READ)(deck.path)
    usual = {
        name: v for name, v in imported.parameters.items() if name.isidentifier() and not iskeyword(name)
    }
    first = _driven_part(loaded("netlists.read.bench:bench_in")(imported, deck.path, part), testbench)
    name = f"{deck.path.name}:{part}" if part else deck.path.name

    @lru_cache(1)
    def other(changed: tuple[tuple[str, float], ...]) -> Made:
        made: Made = loaded("netlists.read.bench:read_bench")(deck.path, part, dict(changed))
        return _driven_part(made, testbench)

    def make(params: Any, knobs: Values, v_dd: float) -> Made:
        changed = tuple(
            (name, getattr(params, name)) for name, v in usual.items() if getattr(params, name) != v
        )
        return other(changed) if changed else first

    return block_of(name, make, numbers_as_arguments(usual), "a netlist")


def _driven_part(made: Made, testbench: Path | None) -> Made:
    """A sub-circuit under the file of its testbench, where it has one."""
    if testbench is None or not isinstance(made, Circuit):
        return made
    driven_by: Made = loaded("netlists.read.bench_file:read_bench_file")(testbench, made)
    return driven_by


def _name_of(thing: Any) -> str:
    return str(getattr(thing, "name", None) or getattr(thing, "title", None) or type(thing).__name__)


def _made_of(thing: Any, name: str, place: str = "", process: Process = AMI_1500) -> Found:
    """The block or chip that an object is, or that a function makes. place: where it stands, for errors."""
    if isinstance(thing, Block | Chip):
        return thing
    where = place or name
    if not callable(thing):
        made = _ours(thing, where)
        return block_of(name, lambda *_: made, no_arguments(), process=process)
    arguments = _read(lambda: arguments_of(thing, knobs=False), where)
    first = _ours(thing(), where, chips=True)
    if isinstance(first, Block | Chip):
        return first
    if isinstance(first, Testbench):
        arguments = _read(lambda: arguments_of(thing, knobs=True), where)

    def make(params: Any, knobs: Values, v_dd: float) -> Made:
        made: Made = _ours(thing(**arguments.keywords(params, knobs, v_dd)), where)
        return made

    about = (thing.__doc__ or "").strip().partition("\n")[0].rstrip(".")
    return block_of(name, make, arguments, about, process)


def _read(read: Callable[[], Arguments], where: str) -> Arguments:
    try:
        return read()
    except ParameterError as error:
        raise ParameterError(f"{where}: {error}") from None


def _ours(made: Any, where: str, *, chips: bool = False) -> Any:
    """A circuit or testbench that was made, one of PySpice taken over; with `chips` a block or chip too."""
    if type(made).__module__.partition(".")[0] == "PySpice":
        return loaded("netlists.pyspice.read:from_pyspice")(made)
    if not isinstance(made, _OURS if chips else (Circuit, Testbench)):
        raise ParameterError(f"{where}: is of type {type(made).__name__}, {_WANTED}")
    return made
