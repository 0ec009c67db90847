"""The fields of a frozen dataclass as words of text, and back: the grammar of a netlist's notes.

    field  = key "=" word | key "=(" word* ")"
    word   = letters, digits and `_ . , [ ] / + -` as they are; other text as a JSON string without spaces

The form of a value follows from the type of its field. Numbers are Python's `repr`, so that they come back
exactly; a shape is `2,3`; lists stand in parentheses; a pair is `key:value`, a place `name:index`. A field at
its default is left out, and so is one that is no part of the value's `repr`.
"""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING, Field, fields
from typing import Any, Literal, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from circuits.arrays import F64
from circuits.brief import stated
from circuits.circuit import Shape
from circuits.errors import DataError
from circuits.silicon.die import Place
from circuits.silicon.size import SizeTerms, from_numbers, to_numbers

Pairs = tuple[tuple[str, str], ...]
NumberPairs = tuple[tuple[str, float], ...]
Words = str | list[str]
T = TypeVar("T")

_BARE = re.compile(r"[A-Za-z0-9_.,\[\]/+-]+")
_SHAPE = re.compile(r"([0-9]{1,9}(,[0-9]{1,9}){0,15})?")


def format_fields(value: Any, *, all_fields: bool = False) -> Iterator[str]:
    """Words of the fields of a dataclass, without those at their default unless all are wanted.

    Those that are marked as optional (`circuits.brief`) are left out at their default in any case.
    """
    kind: Any = type(value)
    said = set(stated(value))
    for key, (codec, default) in _codecs(kind).items():
        own = getattr(value, key)
        if key not in said or (not all_fields and default is not MISSING and own == default):
            continue
        written = codec.write(own)
        if isinstance(written, str):
            yield f"{key}={written}"
        else:
            yield f"{key}=("
            yield from written
            yield ")"


def parse_fields(label: str, kind: type[T], words: Iterable[str]) -> T:
    """Make a dataclass of the words of its fields; `label` is what errors call it.

    Raises
    ------
    DataError
        No such field, a field that is missing or twice there, or a value that is none of its type.
    """
    given = _split(label, words)
    own: Any = kind  # mypy takes no type for hashable
    table = _codecs(own)
    unknown = next((key for key in given if key not in table), None)
    if unknown is not None:
        raise DataError(f"{label}.{unknown[:40]}: no such field; known are {', '.join(table)}")
    values = {}
    for key, (codec, default) in table.items():
        if key in given:
            values[key] = _read(f"{label}.{key}", codec, given[key])
        elif default is MISSING:
            raise DataError(f"{label}.{key}: missing; every field without a default is written")
    return kind(**values)


class _UnreadableError(ValueError):
    """Words that are no value of their field's type."""


class _Codec(NamedTuple):
    """Value to word or words, and back; `read` raises `ValueError` for text that is no such value."""

    write: Callable[[Any], Words]
    read: Callable[[Words], Any]


def _split(label: str, words: Iterable[str]) -> dict[str, Words]:
    found: dict[str, Words] = {}
    rest = iter(words)
    for word in rest:
        key, sign, value = word.partition("=")
        if not sign or key in found:
            raise DataError(f"{label}: {word[:40]!r}, must be a field key=value, each once")
        if value != "(":
            found[key] = value
            continue
        listed = found[key] = []
        for item in rest:
            if item == ")":
                break
            listed.append(item)
        else:
            raise DataError(f"{label}.{key}: no ) at its end")
    return found


def _read(name: str, codec: _Codec, words: Words) -> Any:
    try:
        return codec.read(words)
    except (ValueError, OverflowError):
        shown = words if isinstance(words, str) else f"( {' '.join(words)} )"
        raise DataError(f"{name}: {shown[:40]!r}, no value of its kind; write the netlist again") from None


@functools.cache
def _codecs(kind: Any) -> dict[str, tuple[_Codec, Any]]:
    """Codec and default (or MISSING) of each field of a dataclass, in its order."""
    hints = get_type_hints(kind)
    return {f.name: (_codec(hints[f.name]), _default(f)) for f in fields(kind) if f.repr}


def _default(field: Field[Any]) -> Any:
    return field.default_factory() if field.default_factory is not MISSING else field.default


def _codec(hint: Any) -> _Codec:
    if get_origin(hint) is Literal:
        return _Codec(_text, functools.partial(_choice, get_args(hint)))
    return _CODECS[hint]


def _one(words: Words) -> str:
    if not isinstance(words, str):
        raise _UnreadableError
    return words


def _many(words: Words) -> list[str]:
    if isinstance(words, str):
        raise _UnreadableError
    return words


def _text(text: str) -> str:
    if _BARE.fullmatch(text):
        return text
    # JSON's own escape of a space keeps the text one word
    return json.dumps(text).replace(" ", "\\u0020")


def _read_text(words: Words) -> str:
    word = _one(words)
    if not word.startswith('"'):
        return word
    text = json.loads(word)
    if not isinstance(text, str):
        raise _UnreadableError
    return text


def _choice(known: tuple[str, ...], words: Words) -> str:
    text = _read_text(words)
    if text not in known:
        raise _UnreadableError
    return text


def _read_flag(words: Words) -> bool:
    return _choice(("true", "false"), words) == "true"


def _shape(shape: Shape) -> str:
    return ",".join(map(str, shape))


def _read_shape(words: Words) -> Shape:
    text = _one(words)
    if not _SHAPE.fullmatch(text):
        raise _UnreadableError
    return tuple(int(n) for n in text.split(",")) if text else ()


def _list(item: _Codec) -> _Codec:
    """A tuple of values, in parentheses."""
    return _Codec(
        lambda values: [str(item.write(v)) for v in values],
        lambda words: tuple(item.read(word) for word in _many(words)),
    )


def _pair(first: _Codec, second: _Codec) -> _Codec:
    """Two values with a colon between them; the second has none."""

    def read(words: Words) -> tuple[Any, Any]:
        key, _, value = _one(words).rpartition(":")
        return first.read(key), second.read(value)

    return _Codec(lambda pair: f"{first.write(pair[0])}:{second.write(pair[1])}", read)


_TEXT = _Codec(_text, _read_text)
_REFERENCE = _Codec(str, _one)
_WHOLE = _Codec(str, lambda words: int(_one(words)))
_NUMBER = _Codec(lambda value: repr(float(value)), lambda words: float(_one(words)))
_NUMBERS = _list(_NUMBER)
_EXTENT = _Codec(_shape, _read_shape)
_CODECS: Mapping[Any, _Codec] = {
    str: _TEXT,
    str | None: _TEXT,
    int: _WHOLE,
    int | None: _WHOLE,
    bool: _Codec(lambda flag: "true" if flag else "false", _read_flag),
    float: _NUMBER,
    float | None: _NUMBER,
    Shape: _EXTENT,
    tuple[float, ...]: _NUMBERS,
    tuple[str, ...]: _list(_TEXT),
    float | tuple[float, ...]: _Codec(
        lambda value: (_NUMBERS if np.ndim(value) else _NUMBER).write(value),
        lambda words: (_NUMBER if isinstance(words, str) else _NUMBERS).read(words),
    ),
    SizeTerms | None: _Codec(
        lambda terms: _NUMBERS.write(to_numbers(terms)), lambda words: from_numbers(_NUMBERS.read(words))
    ),
    F64: _Codec(_NUMBERS.write, lambda words: np.array(_NUMBERS.read(words))),
    Place | None: _list(_pair(_TEXT, _EXTENT)),
    Pairs: _list(_pair(_REFERENCE, _REFERENCE)),
    NumberPairs: _list(_pair(_TEXT, _NUMBER)),
}
