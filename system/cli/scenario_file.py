"""Scenario files: options of `noctule run SYSTEM` in TOML, for its `--scenario FILE`.

    ping_rate = 12               # a number in the option's unit
    vmax = "0.1m/s"              # or a text, as the option takes it
    forest = "dense"
    soft_pings = false           # yes or no
    transistors = ["hearing"]    # texts of an option that may be given again and again
    seed = 1003
    die = 1003

A key is the name of an option, of the system's own or of seed and silicon, with `_` or `-`. What the command
line says goes over what the file says.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from circuits.catalogue import loaded
from circuits.errors import CircuitError, DataError, ParameterError, nearest
from system.cli.option_names import field_named
from system.option import Setting, listed, without_none
from system.options.silicon import SiliconChoice
from system.system import System

_SILICON: Mapping[str, Any] = {
    name: without_none(hint)
    for name, hint in {**get_type_hints(SiliconChoice), "seed": int, "study": str}.items()
    if name not in {"at", "allow_implausible", "process", "law"}
}  # types of the options that all systems have


@dataclass(frozen=True, slots=True)
class ScenarioFile:
    """What a file says, as the command line reads it.

    path : of the file.
    values : by the names of options.
    options : the option that sets each field of a scenario, by the field's name.
    """

    path: str
    values: Mapping[str, Any]
    options: Mapping[str, str]

    def told(self, error: CircuitError, given: Mapping[str, Any]) -> CircuitError:
        """Return an error that names the file too where it is of a value that the file gave.

        given: the values that were taken, by the names of options.
        """
        field = field_named(str(error))
        name = self.options.get(field, field)
        if name in self.values and given.get(name) == self.values[name]:
            return ParameterError(f"{self.path}: {error}")
        return error


def read_scenario_file(path: str, system: System[Any, Any]) -> ScenarioFile:
    """Read options of a system's runs.

    Raises
    ------
    DataError
        The file cannot be read or is no TOML, a key is no option, or a value is not what its option takes:
        one line of file, key, value and rule.
    """
    own = {name: one for name, one in system.settings.items() if one.option.run}
    known = {**_SILICON, **own}
    found: dict[str, Any] = {}
    content = loaded("system.files.document:toml_file")(Path(path))  # which numerical libraries come with
    for key, value in content.items():
        name = key.replace("-", "_")
        if name not in known:
            near = nearest(name, known)
            guess = f"did you mean {near}?" if near else f"options of {system.name} are {', '.join(known)}"
            raise DataError(f"{path}: {key}: unknown; {guess}")
        if name in found:
            raise DataError(f"{path}: {key}: is given twice, must be given once; leave one out")
        try:
            found[name] = _own(own[name], value) if name in own else _of_silicon(name, value)
        except ParameterError as error:
            raise DataError(f"{path}: {error}") from None
    return ScenarioFile(path, found, {one.field: name for name, one in own.items()})


def _own(one: Setting, value: Any) -> Any:
    """A value of a system's own option as the command line has it: yes or no, a text, or a list of texts."""
    if one.kind is bool:
        return _checked(one.name, value, bool)
    if one.option.collect is None:
        text = _text(one, value)
        one.check(one.read(text, one.name))
        return text
    texts = [_text(one, each) for each in _checked(one.name, value, list)]
    one.check(one.option.collect(one.read(text, one.name) for text in texts))
    return texts


def _text(one: Setting, value: Any) -> str:
    """A text as it is, or that of a number in the option's unit."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ParameterError(f"{one.name}: {value!r}, must be a text or a number; write it as --help says")
    return f"{value!r}{one.option.unit or ''}"


def _of_silicon(name: str, value: Any) -> Any:
    """A value of an option that all systems have."""
    kind = _SILICON[name]
    if name == "die":  # whose option is a text, since the nominal die has no number
        return value if isinstance(value, str) else repr(_checked(name, value, int))
    if name == "temperature" and isinstance(value, int | float) and not isinstance(value, bool):
        return repr(value)
    if get_origin(kind) is Literal:
        if value not in get_args(kind):
            raise ParameterError(f"{name}: {value!r}, must be {listed(get_args(kind))}")
        return value
    if get_origin(kind) is tuple:
        return [_checked(name, each, str) for each in _checked(name, value, list)]
    return _checked(name, value, kind)


def _checked(name: str, value: Any, kind: type) -> Any:
    """A value of this type; of no other, so that true is no number."""
    nouns = {bool: "true or false", int: "a whole number", str: "a text", list: "a list of texts"}
    if type(value) is not kind:
        raise ParameterError(f"{name}: {value!r}, must be {nouns[kind]}; write it so")
    return value
