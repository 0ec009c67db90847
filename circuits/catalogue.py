"""A catalogue of things that are loaded by name: blocks, metrics, chips, dialects and others.

What belongs to noctule stands in a literal table, which says where each thing is as `"module:attribute"`.
Users register their own under an entry point of their package. Nothing is imported before it is asked for, so
that names can be listed at once. Libraries that are slow to import, and that many a run does not reach, are
named likewise, and so are the optional extras. Few others import a module by its name.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, final

from circuits.errors import ParameterError, SimulatorError, unknown_name

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, EntryPoints

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Catalogue(Generic[T]):
    """Things of one kind that are loaded by name.

    kind: the word for one of them in an error. table: where each of noctule's own stands, by its name. group:
    the entry-point group under which users register theirs. contracts: classes one of which a user's own must
    be an instance of, as `"module:attribute"`; without any, every object is accepted.
    lines: the summaries of noctule's own, by name, so that they can be shown without loading anything.
    """

    kind: str
    table: Mapping[str, str]
    group: str
    contracts: tuple[str, ...] = ()
    lines: Mapping[str, str] = field(default_factory=dict)

    def __contains__(self, name: object) -> bool:
        return name in self.table or name in self._users()

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def names(self) -> list[str]:
        """Names of all things of this kind: noctule's own in their order, then the users' own, sorted."""
        return [*self.table, *sorted(self._users().keys() - self.table.keys())]

    def load(self, name: str) -> T:
        """Load the thing that is called `name`.

        Raises
        ------
        UnknownNameError
            Nobody registered the name; the text suggests near ones.
        ParameterError
            A user's own cannot be loaded, or is not of the kind that the catalogue asks for.
        """
        if name in self.table:
            found: T = loaded(self.table[name])
            return found
        users = self._users()
        if name not in users:
            raise unknown_name(self.kind, name, [*self.table, *users])
        return self._checked(users[name])

    def line(self, name: str) -> str:
        """Give its summary; what has one in `lines` is not loaded for it. Raises as `load` does."""
        if name in self.lines:
            return self.lines[name]
        found: Any = self.load(name)
        return str(found.summary)

    def _users(self) -> dict[str, EntryPoint]:
        return {entry.name: entry for entry in entry_points(group=self.group)}

    def _checked(self, entry: EntryPoint) -> T:
        """What a user registered, if it is of the kind."""
        where = f"{self.group}.{entry.name}: {entry.value}"
        try:
            found: T = entry.load()
        except Exception as error:
            told = f"{type(error).__name__}: {error}"
            raise ParameterError(f"{where}, cannot be loaded, {told}; mend or uninstall it") from error
        classes = tuple(loaded(contract) for contract in self.contracts)
        if classes and not isinstance(found, classes):
            wanted = " or ".join(each.__name__ for each in classes)
            raise ParameterError(f"{where} is of type {type(found).__name__}, must be a {wanted}; mend it")
        return found


def entry_points(group: str) -> EntryPoints:
    """Entry points of all packages in a group, looked for again where a package came or went."""
    return _entry_points(tuple((path, _changed(path)) for path in sys.path)).select(group=group)


@lru_cache(maxsize=4)
def _entry_points(folders: tuple[tuple[str, int], ...]) -> EntryPoints:
    """Entry points of all groups; what finds them is slow to import, and reads every package."""
    found: EntryPoints = loaded("importlib.metadata:entry_points")()
    return found


def _changed(folder: str) -> int:
    """When a package last came to a folder or went, ns; 0 where there is no such folder."""
    try:
        return Path(folder).stat().st_mtime_ns
    except OSError:
        return 0


def loaded(place: str) -> Any:
    """The object at `"module:attribute"`; raises `ImportError` where there is no such module."""
    module, _, attribute = place.partition(":")
    return getattr(import_module(module), attribute)


def later(module: str) -> Any:
    """A library that is imported when something of it is asked for, and not before.

    It is for libraries of others that take long to import (`scipy`, `networkx`), in modules that are imported
    by runs that do not need them.
    """
    return _Later(module)


def extra(module: str, missing: str) -> Any:
    """An optional library; raises `SimulatorError` with the text `missing` where it is not installed."""
    try:
        return import_module(module)
    except ImportError:
        raise SimulatorError(missing) from None


@final
class _Later:
    """A module that has not been imported yet."""

    def __init__(self, module: str) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):  # asked for by who looks what kind of object this is
            raise AttributeError(name)
        found = self.__dict__[name] = getattr(import_module(self._module), name)
        return found
