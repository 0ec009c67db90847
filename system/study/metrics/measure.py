"""Measures as metrics of a study: expressions that are read from a run of a block's testbench.

A metric whose name has a `=` in it is a measure, as `t_delay = cross(v_out, 0.9)`. It is data: a study keeps
its text, and a replay needs no code.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from circuits.blocks.metric import Metric
from circuits.circuit import Circuit
from circuits.lowering.kernel import Machine, to_kernel
from circuits.measure.measure import Measure, Reading, read_measures
from circuits.measure.scope import Scope, TransientRecord, scope_of
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from system.options.block import Choice

_SIGN = "="


@dataclass(frozen=True, slots=True)
class Told:
    """Gives what an expression tells of a run; measure: the expression."""

    measure: Measure

    def __call__(self, result: Result) -> float:
        """Return its value, NaN where it has none."""
        return _reading(self.measure, result).value


def is_measure(name: str) -> bool:
    """Say whether a metric is a measure."""
    return _SIGN in name


def named_measures(texts: Sequence[str]) -> tuple[str, ...]:
    """Give texts of measures as metrics, each with a name: `measure_1` and so on where it has none."""
    return tuple(
        text if _begins_with_name(text) else f"measure_{k + 1} = {text}" for k, text in enumerate(texts)
    )


def measure_name(text: str) -> str:
    """Give the name of a measure."""
    return text.partition(_SIGN)[0].strip()


def _begins_with_name(text: str) -> bool:
    head, sign, _ = text.partition(_SIGN)
    return bool(sign) and head.strip().isidentifier()


def measures_of(choice: Choice, texts: Sequence[str]) -> tuple[Measure, ...]:
    """Read measures of the testbench of a block; raises `ParameterError` for one that it cannot have."""
    return read_measures(texts, measurable(choice)) if texts else ()


def measurable(choice: Choice) -> Scope:
    """Give the names that measures of the testbench of a block can use."""
    return scope_of(to_kernel(choice.testbench(), choice.silicon))


def measure_metrics(choice: Choice, texts: Sequence[str]) -> dict[str, Metric]:
    """Give measures as metrics of a block, by their texts."""
    return {each.text: _metric(choice, each) for each in measures_of(choice, texts)}


def _metric(choice: Choice, each: Measure) -> Metric:
    def prepare(circuit: Circuit, silicon: Silicon) -> Machine:
        return to_kernel(choice.testbench(), silicon)

    return Metric(
        each.name, each.unit, each.text, (choice.circuit.name,), prepare, simulate, choice.block.outcome,
        _no_reason, Told(each), missing=partial(_missing, each),
    )  # fmt: skip


def _reading(each: Measure, result: Result) -> Reading:
    return each.of(TransientRecord(result))


def _missing(each: Measure, result: Result) -> str:
    return _reading(each, result).reason


def _no_reason(_: Result) -> str:
    return ""
