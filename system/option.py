"""An option of a run, stated once: with the field of the scenario whose value it sets.

`option` makes such a field; its name, unit, help, limits, and whether a study may vary it go with it. From
these come the options of `noctule run` and their `--help`, `montecarlo --param`, the entries of JSON, the
keys of scene files (`system.table`), and the check of every scenario that is made in Python
(`check_options`). A field whose type is a dataclass with options of its own (the bat of a forest) is a part:
its options are the scenario's too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from functools import cache
from inspect import get_annotations
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from circuits.catalogue import later
from circuits.errors import ParameterError, meant
from circuits.units import format_quantity
from system.reader import In, Reader, switch, whole, words

np = later("numpy")

OPTION = "option"  # key of a field's metadata
_METAVARS = {
    "s": "TIME", "m": "LENGTH", "Hz": "FREQUENCY", "V": "VOLTAGE", "m/s": "SPEED", "deg": "ANGLE",
    "degC": "DEGC",
}  # fmt: skip
_KINDS: Mapping[Any, tuple[type, str, str]] = {
    int: (Integral, "a whole number", "whole numbers"), float: (Real, "a number", "numbers"),
    bool: (bool, "True or False", "of True or False"), str: (str, "a text", "texts"),
}  # fmt: skip
_PER = {"m/s": "m_per_s"}  # units as JSON's keys have them


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """What a user is told of an option, and what is taken for it.

    Attributes
    ----------
    help : str
        What it is, as its help has it; the default is added.
    name : str
        Its name with underscores, where users do not say the field's own.
    short : str
        A letter that stands for it where it is given.
    unit : str or None
        Unit of its number, as texts must have it; "" for a plain number, None for what is no number.
    to_field : callable or None
        Makes the field's value, which is in SI units, of a number in `unit`.
    choices : tuple of str
        The words that are taken; those of a field's `Literal` are known without.
    words : mapping of str to float
        Names that may stand in a file for numbers of its field, such as colours for reflectances.
    fewest : int
        How many entries a list in a file must have.
    least, above, most, below : float or None
        Limits of its number in `unit`; the first and the third are allowed themselves.
    read : Reader or None
        Makes a value of a text, where the field's type does not say how.
    write : callable or None
        Makes the text of a value that is data of a kind of its own, which `read` takes: manifests have texts.
    metavar : str
        What stands for the value in its help.
    collect : callable or None
        Makes the field's value of those of all texts, for an option that is given several times.
    run, study : bool
        Whether runs have it, and whether studies have it as a parameter.
    opposite : str
        Option that says no, of one that says yes or no; `no-NAME` unless given.
    silicon : bool
        Whether it says something of a chip, so that it has no sense where no chip is in the loop.
    anywhere : bool
        Whether such an option may be given without a chip, and then changes nothing.
    key : str or None
        Its entry in JSON, empty for none; the field's name with its unit unless given.
    names : str
        Where words that may stand there are, or a function that lists them, as `"module:attribute"`: shells
        complete by it.
    """

    help: str = ""
    name: str = ""
    short: str = ""
    unit: str | None = None
    to_field: Callable[[float], float] | None = None
    choices: tuple[str, ...] = ()
    words: Mapping[str, float] = field(default_factory=dict)
    fewest: int = 0
    least: float | None = None
    above: float | None = None
    most: float | None = None
    below: float | None = None
    read: Reader | None = None
    write: Callable[[Any], str] | None = None
    metavar: str = ""
    collect: Callable[[Iterable[Any]], Any] | None = None
    run: bool = True
    study: bool = False
    opposite: str = ""
    silicon: bool = False
    anywhere: bool = False
    key: str | None = None
    names: str = ""

    @property
    def needs_chip(self) -> bool:
        """Whether it is refused where no chip is in the loop."""
        return self.silicon and not self.anywhere


@dataclass(frozen=True, slots=True)
class Setting:
    """An option of a scenario: the field that it sets, of the scenario itself or of its part.

    kind : type of the field, without None.
    default : of the field; `dataclasses.MISSING` where a value must be given.
    """

    field: str
    part: str | None
    kind: Any  # type of the field, without None
    default: Any  # `dataclasses.MISSING` where a value must be given
    option: Option

    @property
    def name(self) -> str:
        """Name of the option as users say it, with underscores."""
        return self.option.name or self.field

    @property
    def choices(self) -> tuple[str, ...]:
        """Words that are taken; none where the value is not one of a few words."""
        return self.option.choices or (get_args(self.kind) if get_origin(self.kind) is Literal else ())

    @property
    def read(self) -> Reader:
        """The function that makes a value of a text."""
        if self.option.read is not None:
            return self.option.read
        if self.option.unit is not None:
            return In(self.option.unit)
        return {bool: switch, int: whole}.get(self.kind, words)

    @property
    def metavar(self) -> str:
        """What stands for a value in `--help`."""
        if self.kind is bool or self.option.metavar:
            return self.option.metavar
        usual = {int: "COUNT", float: "NUMBER"}.get(self.kind, "WORD")
        return "|".join(self.choices) or _METAVARS.get(self.option.unit or "", usual)

    @property
    def help(self) -> str:
        """What the option is, and its default where that is a number or a word."""
        usual, unit = self.default, self.option.unit
        if usual is None or isinstance(usual, bool) or not isinstance(usual, int | float | str):
            return f"{self.option.help}."
        if not isinstance(usual, str):
            usual = format_quantity(math.degrees(usual) if unit == "deg" else usual, unit or "")
        return f"{self.option.help}; {usual}."

    @property
    def key(self) -> str:
        """Its key in a JSON document, empty where it has none."""
        if self.option.key is not None:
            return self.option.key
        unit = "rad" if self.option.unit == "deg" else self.option.unit
        return f"{self.field}_{_PER.get(unit, unit)}" if unit else self.field

    def check(self, value: Any, path: str = "") -> None:
        """Raise `ParameterError` for a value in the option's unit that its limits do not allow.

        path : what the error calls it, such as its place in a file; the option's name unless given.
        """
        if value is None:
            return
        path = path or self.name
        for word in sorted(value) if self.option.collect is not None else (value,):
            if self.choices and word not in self.choices:
                raise ParameterError(
                    f"{path}: {word}, must be {listed(self.choices)}{meant(str(word), self.choices)}"
                )
        if isinstance(value, tuple) and not all(map(math.isfinite, _numbers(value))):
            raise ParameterError(f"{path}: {value!r:.40}, must be finite numbers")
        rules = rules_of(self.option)
        if isinstance(value, int | float) and rules and not _within(self.option, value):
            unit = f" {self.option.unit}" if self.option.unit else ""
            raise ParameterError(f"{path}: {value:g}{unit}, must be {' and '.join(rules)}")


def option(default: Any, about: str = "", **stated: Any) -> Any:
    """Make a field of a scenario that users can set by an option.

    Parameters
    ----------
    default
        Value of the field, or what makes it.
    about
        What the option is, in the words of its help.
    stated
        The rest of `Option` by name, such as its unit and its limits.
    """
    metadata = {OPTION: Option(help=about, **stated)}
    if callable(default):
        return field(default_factory=default, metadata=metadata)
    return field(default=default, metadata=metadata)


def required(about: str = "", **stated: Any) -> Any:
    """Make a field of a scenario that must be given, and that users set by an option.

    Parameters
    ----------
    about
        What the option is, in the words of its help.
    stated
        The rest of `Option` by name.
    """
    return field(metadata={OPTION: Option(help=about, **stated)})


def _own_first(scenario: type) -> list[Any]:
    """Fields of a scenario, those that it states itself before those of what it derives from."""
    own = get_annotations(scenario)
    return sorted(fields(scenario), key=lambda each: each.name not in own)


@cache
def settings(scenario: type) -> Mapping[str, Setting]:
    """Return the options of a scenario by the names that users have for them, those of its parts too."""
    found: dict[str, Setting] = {}
    hints = get_type_hints(scenario)
    for each in _own_first(scenario):
        kind: Any = without_none(hints[each.name])
        if OPTION in each.metadata:
            one = Setting(each.name, None, kind, _default(each), each.metadata[OPTION])
            found[one.name] = one
        elif is_dataclass(kind) and isinstance(kind, type):
            for inner in settings(kind).values():
                found[inner.name] = Setting(inner.field, each.name, inner.kind, inner.default, inner.option)
    return found


def check_options(
    scenario: Any, no_silicon: str = "", but: Collection[str] = (), loose: Collection[str] = ()
) -> None:
    """Raise `ParameterError` for a field of a scenario that breaks its option's rule, or is of another kind.

    The parts of a scenario check their own fields.

    Parameters
    ----------
    scenario
        The scenario.
    no_silicon
        What puts a chip into the loop where there is none; a field that says something of a chip, and is
        not at its default, is then refused too.
    but
        Names of fields that say something without a chip too.
    loose
        Names of fields that take more than their type says; the scenario looks at them itself.
    """
    kind: Any = type(scenario)
    hints = _hints(kind)
    for one in settings(kind).values():
        if one.part is None:
            value = getattr(scenario, one.field)
            if one.field not in loose:
                check_kind(one.name, hints[one.field], value)
            one.check(value)
    for each in [f for f in fields(scenario) if no_silicon and f.name not in but]:
        stated = each.metadata.get(OPTION)
        value = getattr(scenario, each.name)
        if stated is not None and stated.needs_chip and value != _default(each):
            name = stated.name or each.name
            raise ParameterError(f"{name}: {value}, no chip is in the loop; {no_silicon}, or leave it out")


def tupled(value: Any) -> Any:
    """Return lists and arrays as the tuples that fields have, and all else as it is."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    return tuple(map(tupled, value)) if isinstance(value, list) else value


def check_kind(path: str, hint: Any, value: Any) -> None:
    """Raise `ParameterError` for a value of another type than a field's; words are left to `Setting.check`.

    Parameters
    ----------
    path
        What the error calls it.
    hint
        The type that the field is said to have.
    value
        What is given for it.
    """
    if not _fits(hint, value):
        raise ParameterError(f"{path}: {value!r:.40}, must be {_noun(hint)}")


def _numbers(value: Any) -> Iterator[float]:
    """The numbers in a tuple, those of tuples in it too."""
    for each in value:
        if isinstance(each, tuple):
            yield from _numbers(each)
        elif isinstance(each, Real):
            yield float(each)


def _fits(hint: Any, value: Any) -> bool:
    """Whether a value is of a type; a number is no yes or no, and None is one of few words only if stated."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return any(_fits(kind, value) for kind in inner)
    if origin is Literal:
        return value is not None or None in inner
    if origin is tuple:
        each = inner[:1] * len(value) if isinstance(value, tuple) and inner[1:] == (...,) else inner
        return isinstance(value, tuple) and len(value) == len(each) and all(map(_fits, each, value))
    if hint in _KINDS:
        return isinstance(value, _KINDS[hint][0]) and (hint is bool or not isinstance(value, bool))
    plain = hint if origin is None else origin
    return not isinstance(plain, type) or isinstance(value, plain)


def _noun(hint: Any) -> str:
    """What a value of a type is called in an error."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return " or ".join(_noun(kind) for kind in inner)
    if origin is Literal:
        return listed(tuple(map(str, inner)))
    if origin is tuple:
        count = "" if inner[1:] == (...,) else f"{len(inner)} "
        return f"a tuple of {count}{_nouns(inner[0])}"
    if hint is NoneType:
        return "None"
    return _KINDS[hint][1] if hint in _KINDS else f"a {getattr(origin or hint, '__name__', hint)}"


def _nouns(hint: Any) -> str:
    """What values of a type are called together."""
    if get_origin(hint) is tuple:
        return _noun(hint).replace("a tuple", "tuples", 1)
    return _KINDS[hint][2] if hint in _KINDS else f"{getattr(hint, '__name__', hint)}s"


@cache
def _hints(scenario: type) -> Mapping[str, Any]:
    return get_type_hints(scenario)


class Checked:
    """A dataclass whose fields are options, all of which are checked when one is made."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self)


def listed(choices: tuple[str, ...]) -> str:
    """Return words as a sentence has them: `a, b or c`."""
    return f"{', '.join(choices[:-1])} or {choices[-1]}" if len(choices) > 1 else choices[0]


def without_none(hint: Any) -> Any:
    """Return the type that a field has where its value is not None."""
    if get_origin(hint) not in (Union, UnionType):
        return hint
    kinds = [kind for kind in get_args(hint) if kind is not NoneType]
    return kinds[0] if len(kinds) == 1 else hint


def _default(each: Any) -> Any:
    if each.default is not MISSING:
        return each.default
    return each.default_factory() if each.default_factory is not MISSING else MISSING


def rules_of(stated: Option) -> list[str]:
    """Return what a number must be by its option's limits, a rule each, as `> 0`."""
    limits = (("> ", stated.above), (">= ", stated.least), ("< ", stated.below), ("<= ", stated.most))
    return [f"{sign}{limit:g}" for sign, limit in limits if limit is not None] + _finite(stated)


def _finite(stated: Option) -> list[str]:
    bounded = stated.most is not None or stated.below is not None
    return [] if stated.unit is None or bounded else ["finite"]


def _within(stated: Option, value: float) -> bool:
    return (
        math.isfinite(value)
        and (stated.above is None or value > stated.above)
        and (stated.least is None or value >= stated.least)
        and (stated.below is None or value < stated.below)
        and (stated.most is None or value <= stated.most)
    )


def seed_option() -> Any:
    """Make the field of a scenario's seed: of noise, worlds and whatever else is drawn, but of no die."""
    return option(0, run=False, least=0)


def die_option(usual: Any) -> Any:
    """Make the field of the die on which a scenario runs; `usual` is its default."""
    return option(usual, run=False, silicon=True)


def temperature_option(usual: float) -> Any:
    """Make the field of a scenario's temperature; `usual` is its default, degC."""
    return option(usual, run=False, silicon=True, key="temperature_C")


def course_option() -> Any:
    """Make the field of a course of temperature: pairs of time, s, and degC (`circuits.silicon.course`).

    Where it has any, the temperature follows them instead of being the scenario's one.
    """
    return option((), run=False, silicon=True, key="")


def bias_kind_option(usual: Any, **stated: Any) -> Any:
    """Make the field of the kind of a chip's biases.

    Parameters
    ----------
    usual
        Its default, `gate`, `ideal` or `generator`.
    stated
        The rest of `Option` by name.
    """
    about = "Fixed gates, ideal PTAT currents, or the bias generator"
    return option(usual, about, choices=("gate", "ideal", "generator"), silicon=True, **stated)
