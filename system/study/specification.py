"""What a sample must fulfil: `best_delay in 6.8ms:7.7ms`, `width in 1ms:`, `class is works`.

    specification := metric " in " [low] ":" [high] | "class" (" is " | " in ") word { "|" word }

Limits are numbers as `circuits.units` reads them, in the metric's unit; both belong to the interval. A sample
passes if it did not fail, its metric is defined and inside, and its class is one of the words. Whatever does
not pass counts against the yield and has one cause, the first that applies: failed, then the specifications
in the order in which they were given. A system without any is held against its own definition of success.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, Bools
from circuits.errors import ParameterError, UnknownNameError, unknown_name
from circuits.units import format_quantity, parse_quantity
from system.study.table import FAILED, counted
from system.system import SUCCEEDED

CLASS = "class"
_GRAMMAR = re.compile(r"\s*([\w-]+)\s+(in|is)\s+(.*?)\s*", re.DOTALL)
_COMPARED = re.compile(r"\s*([\w-]+)\s*([<>])=?\s*(\S+)\s*")
_HELP = 'write "best_delay in 6.8ms:7.7ms", "width in 1ms:" or "class is works"'


@dataclass(frozen=True, slots=True)
class Limits:
    """A specification: a metric must be defined, and neither below one value nor above another.

    Attributes
    ----------
    metric : str
        Name of the metric that is limited, as the target's table has it.
    low, high : float
        The values, in SI units; an infinite one is no limit.
    unit : str
        SI unit of the metric.
    """

    metric: str
    low: float
    high: float
    unit: str

    def __str__(self) -> str:
        low, high = (format_quantity(v, self.unit) if math.isfinite(v) else "" for v in (self.low, self.high))
        return f"{self.metric} in {low}:{high}"


@dataclass(frozen=True, slots=True)
class Classes:
    """A sample's class must be one of `words`."""

    words: tuple[str, ...]

    def __str__(self) -> str:
        return f"{CLASS} {'is' if len(self.words) == 1 else 'in'} {'|'.join(self.words)}"


@dataclass(frozen=True, slots=True)
class Success:
    """A run must have succeeded, by the system's own `sentence`."""

    sentence: str

    def __str__(self) -> str:
        return f"{SUCCEEDED} ({self.sentence})"


Specification = Limits | Classes | Success


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a judgement of n samples has found.

    Attributes
    ----------
    causes : tuple of str
        Cause of each sample not to pass; empty for one that does.
    """

    causes: tuple[str, ...]

    @property
    def passed(self) -> Bools:
        """bool[n]."""
        return np.array([not cause for cause in self.causes], dtype=np.bool_)

    @property
    def counts(self) -> dict[str, int]:
        """Samples by cause, the most frequent first; those that pass are not listed."""
        return counted(cause for cause in self.causes if cause)


def parse_spec(
    text: str, known_metrics: Mapping[str, str], known_classes: Collection[str] = ()
) -> Specification:
    """Read a specification.

    Parameters
    ----------
    text
        As the user wrote it.
    known_metrics
        Unit of the limits of each metric that is a number, by name.
    known_classes
        Every word that a sample's class can be; empty if they are not known.

    Raises
    ------
    ParameterError
        The text has another form, or low is above high.
    UnknownNameError
        There is no such metric or class.
    """
    match = _matched(text)
    name, verb, rest = match.group(1).replace("-", "_"), match.group(2), match.group(3)
    if name == CLASS:
        return _classes(text, rest, known_classes)
    if name not in known_metrics:
        raise UnknownNameError(f"spec: {unknown_name('metric', name, [*known_metrics, CLASS])}")
    if verb == "is" or rest.count(":") != 1:
        raise ParameterError(f'spec: "{text}", must be {name} in LOW:HIGH; {_HELP}')
    return _limits(text, name, rest, known_metrics[name])


def check_form(texts: Sequence[str]) -> None:
    """Raise `ParameterError` for a specification of another form."""
    for text in texts:
        _matched(text)


def _matched(text: str) -> re.Match[str]:
    """Return a specification's parts; raises `ParameterError` for a text of another form."""
    match = _GRAMMAR.fullmatch(text)
    if match is None:
        compared = _COMPARED.fullmatch(text)
        advice = _HELP
        if compared is not None:
            name, sign, value = compared.groups()
            advice = f'write "{name} in {f":{value}" if sign == "<" else f"{value}:"}"'
        raise ParameterError(f'spec: "{text}", must be METRIC in LOW:HIGH or class is WORD; {advice}')
    return match


def limited_metrics(texts: Sequence[str]) -> tuple[str, ...]:
    """Metrics that specifications limit, each once in their order; texts of another form name none."""
    found = [match.group(1).replace("-", "_") for match in map(_GRAMMAR.fullmatch, texts) if match]
    return tuple(dict.fromkeys(name for name in found if name != CLASS))


def judge(
    specifications: Sequence[Specification], outcomes: Sequence[str], values: Mapping[str, F64]
) -> Verdict:
    """Judge n samples by all specifications.

    Parameters
    ----------
    specifications
        The specifications.
    outcomes
        Class of each sample, `failed` for one that has none.
    values
        Value of each sample in SI units, float64[n] by metric, NaN where not defined. With no specification
        only failed samples do not pass.
    """
    causes = [FAILED if outcome == FAILED else "" for outcome in outcomes]
    for each in specifications:
        found = _causes(each, outcomes, values)
        causes = [cause or new for cause, new in zip(causes, found, strict=True)]
    return Verdict(tuple(causes))


def _causes(each: Specification, outcomes: Sequence[str], values: Mapping[str, F64]) -> list[str]:
    if isinstance(each, Classes):
        return ["" if outcome in each.words else f"{CLASS} {outcome}" for outcome in outcomes]
    if isinstance(each, Success):
        return ["" if value == 1.0 else "did not succeed" for value in values[SUCCEEDED]]
    x = values[each.metric]
    causes = np.full(len(x), "", dtype=object)
    causes[x < each.low] = f"{each.metric} below {format_quantity(each.low, each.unit)}"
    causes[x > each.high] = f"{each.metric} above {format_quantity(each.high, each.unit)}"
    causes[np.isnan(x)] = f"{each.metric} not defined"
    return list(causes)


def _limits(text: str, name: str, rest: str, unit: str) -> Limits:
    low, high = (part.strip() for part in rest.split(":"))
    if not low and not high:
        raise ParameterError(f'spec: "{text}", must have a limit; {_HELP}')
    least = parse_quantity(low, unit, f"spec: {name}") if low else -math.inf
    most = parse_quantity(high, unit, f"spec: {name}") if high else math.inf
    if least > most:
        raise ParameterError(f'spec: "{text}", must have low <= high; write {name} in {high}:{low}')
    return Limits(name, least, most, unit)


def _classes(text: str, rest: str, known: Collection[str]) -> Classes:
    words = tuple(dict.fromkeys(word.strip() for word in rest.split("|")))
    if not all(words):
        raise ParameterError(f'spec: "{text}", must have a word on each side of "|"; {_HELP}')
    for word in words:
        if known and word not in known:
            raise UnknownNameError(f"spec: {unknown_name('class', word, known)}")
    return Classes(words)
