"""Metrics of a study, which are found by their names.

A metric is a number that is measured on every die. There are four kinds. A registered metric
(`circuits.registry`) belongs to the circuits that it names. What a block's testbench measures is read from
one run of that testbench, and so is a measure, an expression (`system.study.metrics.measure`). A user's own
metric is a function, named `MODULE:FUNCTION` or `FILE.py:FUNCTION`: it takes the machine of the testbench on
a die and returns a number, NaN where the metric is not defined. If it is annotated to return a `bool`, its
mean is told as a share of the dies.
"""

from __future__ import annotations

import inspect
import math
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from circuits.blocks.metric import Metric
from circuits.catalogue import loaded
from circuits.circuit import Circuit
from circuits.errors import ParameterError, unknown_name
from circuits.lowering.kernel import Machine, to_kernel
from circuits.registry import metrics_of_circuit
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from system.options.block import Choice
from system.options.code import code_of, load_code
from system.study.metrics.measure import is_measure, measure_metrics, measure_name

MEASURED = "measured"
OUTSIDE = "outside the box"  # measured too, where a chip's model was not held against its transistors


def metrics_of(choice: Choice, names: Sequence[str]) -> tuple[Metric, ...]:
    """Give the metrics of a block with the given names, each once, in their order.

    Raises `UnknownNameError` for a name that no metric of the block has, and `ParameterError` for a user's
    function that cannot be loaded.
    """
    measures = measure_metrics(choice, [n for n in dict.fromkeys(names) if is_measure(n)])
    wanted = list(dict.fromkeys(n if is_own(n) or n in measures else n.replace("-", "_") for n in names))
    own = {m.name: m for m in metrics_of_circuit(choice.circuit.name)}
    plain = [n for n in wanted if not (is_own(n) or n in measures)]
    if any(name not in own for name in plain):
        measured = _measured(choice)
        for name in plain:
            if name not in own and name not in measured:
                raise unknown_name("metric", name, [*own, *measured])
        own = {**measured, **own}
    found = tuple(
        measures[n] if n in measures else _custom(choice, n) if is_own(n) else own[n] for n in wanted
    )
    for name, count in Counter(m.name for m in found).items():
        if count > 1:
            raise ParameterError(
                f"metric: {name}, the name of {count} of them, must be of one; rename a measure"
            )
    return found


def is_own(name: str) -> bool:
    """Say whether a name is that of a user's function, which is loaded only where the user names it."""
    return ":" in name and not is_measure(name)


def with_named(asked: Sequence[str], named: Sequence[str]) -> tuple[str, ...]:
    """Give the names of the metrics that are asked for, and then those that only other options name.

    asked: metrics that are asked for. named: metrics in specifications and other options, where `FUNCTION`
    stands for a metric that is asked for as `MODULE:FUNCTION`, and the name of a measure for the measure.
    """
    measures = {_short(name) for name in asked if is_measure(name)}
    own = [name for name in asked if is_measure(name) or _short(name) not in measures]
    known = {_short(name) for name in own}
    return (*own, *dict.fromkeys(name for name in named if _short(name) not in known))


def _short(name: str) -> str:
    if is_measure(name):
        return measure_name(name)
    return name.rpartition(":")[2].replace("-", "_")


def default_metrics(choice: Choice) -> tuple[str, ...]:
    """Give the names of the metrics that are measured on a block unless others are asked for.

    These are the first metric that is registered for its circuit, else all that its testbench measures.
    """
    own = [m.name for m in metrics_of_circuit(choice.circuit.name)]
    return tuple(own[:1] or _measured(choice))


def nominal_numbers(choice: Choice) -> Mapping[str, float | None]:
    """Give what a block's testbench measures in a run on the nominal die."""
    return choice.block.measured(simulate(choice.testbench(), _nominal(choice)))


def _nominal(choice: Choice) -> Silicon:
    return replace(choice.silicon, die=replace(choice.silicon.die, number=None))


def measurements(metrics: Sequence[Metric]) -> list[Metric]:
    """Give one metric for each different measurement, in order, since several metrics may share one."""
    return list({id(m.measure): m for m in reversed(metrics)}.values())[::-1]


def runs_testbench(metric: Metric) -> bool:
    """Say whether a metric is measured in a run of the block's own testbench, to which stimuli apply."""
    return metric.measure is simulate or metric.outcome is _word


def _measured(choice: Choice) -> dict[str, Metric]:
    """What the testbench measures, as metrics; their names come from a run on the nominal die."""
    number, outcome = choice.block.number, choice.block.outcome

    def prepare(circuit: Circuit, silicon: Silicon) -> Machine:
        return to_kernel(choice.testbench(), silicon)

    def value(name: str, result: Result) -> float:
        found = number(result, name)
        return math.nan if found is None else found

    def metric(name: str) -> Metric:
        circuits, summary = (choice.circuit.name,), "of the testbench's run"
        return Metric(
            name, "", summary, circuits, prepare, simulate, outcome, _no_reason, partial(value, name)
        )

    nominal = simulate(prepare(choice.circuit, _nominal(choice)))
    return {name: metric(name) for name in choice.block.measured(nominal)}


def _custom(choice: Choice, name: str) -> Metric:
    """`MODULE:FUNCTION`, a number of the testbench's machine on a die."""
    function, attribute = _loaded(name), name.partition(":")[2]

    def prepare(circuit: Circuit, silicon: Silicon) -> Machine:
        return to_kernel(replace(choice, circuit=circuit, silicon=silicon).testbench(), silicon)

    summary, circuits = "a function of the user's", (choice.circuit.name,)
    yes_no = inspect.signature(function).return_annotation in {bool, "bool"}
    return Metric(attribute, "", summary, circuits, prepare, function, _word, _no_reason, float, yes_no)


def _loaded(name: str) -> Callable[[Machine], float]:
    """The user's function, whose module may stand in the folder where the command was given.

    That folder comes first while the module is imported, and last after it: a file there takes no library's
    place in what is imported later.
    """
    sys.path.insert(0, "")
    try:
        code = code_of(name)
        function: Callable[[Machine], float] = loaded(name) if code is None else load_code(code)
    except Exception as error:  # noqa: BLE001 - a module may raise anything
        told = " ".join(str(error).split()) or type(error).__name__
        raise ParameterError(f"metric: {name}, {told}; give MODULE:FUNCTION of a machine") from None
    finally:
        sys.path.remove("")
        if sys.path[-1] != "":
            sys.path.append("")
    if not callable(function):
        raise ParameterError(f"metric: {name}, is no function; give MODULE:FUNCTION of a machine")
    return function


def _word(_: Any) -> str:
    return MEASURED


def _no_reason(_: Any) -> str:
    return ""
