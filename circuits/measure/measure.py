"""Measures: numbers of a run that a user asks for by an expression.

    t_delay = cross(v_out, 0.9, rise, 2) - cross(v_in, 0.9)

The text is parsed and never evaluated as Python; names and units are checked before any run. What does not
occur in a run has no value, and says why.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from circuits.errors import ParameterError
from circuits.measure.formula import Reader, Run, Typed
from circuits.measure.function import Absent
from circuits.measure.grammar import MeasureError, column_of, parse
from circuits.measure.scope import Record, Scope, TransientRecord, scope_of
from circuits.measure.unit import value_text
from circuits.solver.transient import Result


@dataclass(frozen=True, slots=True)
class Reading:
    """A measure of a run.

    name: what it is called. value: its value in SI units; NaN where it does not occur. unit: unit that its
    expression has; empty for a plain number. reason: why it has no value; empty where it has one.
    """

    name: str
    value: float
    unit: str
    reason: str = ""

    def __str__(self) -> str:
        return f"{self.name}: {self.reason or value_text(self.value, self.unit)}"


@dataclass(frozen=True, slots=True)
class Measure:
    """An expression that has been read: its name, text and unit, and how it is found in a run."""

    name: str
    text: str
    unit: str
    _run: Run = field(repr=False, compare=False)

    def of(self, record: Record) -> Reading:
        """Find the measure in a run."""
        try:
            value = float(self._run(record))
        except Absent as absent:
            return Reading(self.name, math.nan, self.unit, str(absent))
        if not math.isfinite(value):
            return Reading(self.name, math.nan, self.unit, "its value is not finite")
        return Reading(self.name, value, self.unit)


def read_measures(texts: Iterable[str], scope: Scope) -> tuple[Measure, ...]:
    """Read measures, each of which may use those before it by name.

    Parameters
    ----------
    texts
        `NAME = EXPRESSION`, or an expression alone, which is called `measure_1` if it is the first text.
    scope
        Names that they can use.

    Raises
    ------
    ParameterError
        A text is no measure, or a name stands twice; the text of the error has the column.
    """
    known: dict[str, Typed] = {}
    found = []
    for k, text in enumerate(texts):
        tree = parse(text)
        name = str(tree.children[0]) if tree.data == "named" else f"measure_{k + 1}"
        if not name.isidentifier() or name in known:
            rule = (
                "stands twice, must be once" if name in known else "must be a name without dots and brackets"
            )
            raise MeasureError(text, 1, f"{name}: {rule}")
        body: Any = tree.children[-1]
        typed = Reader(text, scope, known).read(body)
        if typed.kind == "signal":
            what = "a waveform, must be a number; write max(...), mean(...) or value(..., at=...)"
            raise MeasureError(text, column_of(body), what)
        known[name] = typed
        found.append(Measure(name, text, str(typed.unit), typed.run))
    return tuple(found)


def measure(result: Result, *texts: str) -> dict[str, Reading]:
    """Measure a run by expressions, as `"t = cross(v_out, 0.9, rise) - 1ms"`.

    Parameters
    ----------
    result
        A transient run that recorded every node.
    texts
        Expressions, each with a name before `=`; a later one can use an earlier one by its name.

    Returns
    -------
    A reading of each, by its name: its value in SI units, its unit, and the reason where it has no value.

    Raises
    ------
    ParameterError
        A text is no measure, or names what the circuit does not have; the error has the column.
    """
    if not texts:
        raise ParameterError('measure: no expression, must be at least one; write "v_max = max(v_out)"')
    record = TransientRecord(result)
    return {each.name: each.of(record) for each in read_measures(texts, scope_of(result.machine))}
