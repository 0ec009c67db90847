"""JSON documents held against the meanings of their keys: what is untold, and what is of another type."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from system.meaning import ANY_NAME, Meaning, Meanings

SIMPLE: dict[str, tuple[type, ...]] = {
    "boolean": (bool,),
    "integer": (int,),
    "number": (int, float),
    "object": (dict,),
    "string": (str,),
}


def wrong(document: dict[str, Any], meanings: Meanings) -> list[str]:
    """Keys of a document that no meaning tells, and those whose value is not of its type, each once."""
    return sorted(set(_wrong(document, {tuple(key.split(".")): each for key, each in meanings.items()}, ())))


def is_of(value: Any, kind: str) -> bool:
    """Whether a value of JSON is of a type as `system.meaning` has them."""
    if "|" in kind:
        return any(is_of(value, each) for each in kind.split("|"))
    if kind.endswith("?"):
        return value is None or is_of(value, kind.removesuffix("?"))
    if kind.endswith("[]"):
        return isinstance(value, list) and all(is_of(each, kind.removesuffix("[]")) for each in value)
    if kind.endswith("{}"):
        return isinstance(value, dict) and all(
            is_of(each, kind.removesuffix("{}")) for each in value.values()
        )
    if kind == "any":
        return True
    return isinstance(value, SIMPLE[kind]) and (kind == "boolean" or not isinstance(value, bool))


def _wrong(
    value: dict[str, Any], told: dict[tuple[str, ...], Meaning], path: tuple[str, ...]
) -> Iterator[str]:
    for key, each in value.items():
        here, meaning = _meaning((*path, key), told)
        if meaning is None:
            yield f"{'.'.join(here)}: untold"
        elif not is_of(each, meaning.kind):
            yield f"{'.'.join(here)}: {str(each)[:40]}, must be {meaning.kind}"
        elif "object" in meaning.kind:
            inner = (*here, ANY_NAME) if "{}" in meaning.kind else here
            for one in _objects(each, by_name="{}" in meaning.kind):
                yield from _wrong(one, told, inner)


def _meaning(
    path: tuple[str, ...], told: dict[tuple[str, ...], Meaning]
) -> tuple[tuple[str, ...], Meaning | None]:
    """The path and the meaning of a key, whose name may be any."""
    for here in (path, (*path[:-1], ANY_NAME)):
        if here in told:
            return here, told[here]
    return path, None


def _objects(value: Any, *, by_name: bool) -> Iterator[dict[str, Any]]:
    """Objects in a value: itself, those of an array, or those by name."""
    if isinstance(value, dict):
        if by_name:
            yield from value.values()
        else:
            yield value
    elif isinstance(value, list):
        for each in value:
            yield from _objects(each, by_name=by_name)
