"""Gradients of what a testbench measures, as a dataset, and measures by their names."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np

from circuits.blocks.metric import Metric
from circuits.catalogue import later
from circuits.errors import CircuitError, ParameterError, UnknownNameError
from circuits.gradient.every import AnyMeasure, Searched, every_gradient
from circuits.gradient.expression import Expression
from circuits.gradient.gradient import GRADIENT_RTOL, Gradients
from circuits.gradient.measure import (
    Crossing,
    Current,
    Energy,
    Extreme,
    Integral,
    Measure,
    Measured,
    SpikeTime,
    Voltage,
)
from circuits.gradient.small_signal.transfer import Corner, SmallSignal, Transfer
from circuits.gradient.stimulus import Move, Step, move_between, own_moves
from circuits.gradient.tap import unit_of
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from circuits.units import parse_quantity, unit_of_name
from system.options.block import Choice
from system.plot import COLOURS
from system.study.metrics.measure import Told, measure_name
from system.study.metrics.metric import metrics_of, with_named

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
else:
    xr = later("xarray")


FORMS = (
    "spike_time(PORT,K), voltage(NODE,TIME), current(NAME,TIME), rise(NODE,V,K), fall(NODE,V,K),"
    " maximum(NODE), minimum(NODE), integral(NODE), energy(SOURCE), mag(NODE,SOURCE,FREQUENCY),"
    " db(NODE,SOURCE,FREQUENCY), phase(NODE,SOURCE,FREQUENCY), bandwidth(NODE,SOURCE),"
    " unity_gain(NODE,SOURCE)"
)
"""Measures that every testbench has, by their names; NODE may be i(NAME), a current."""
_FORM = re.compile(r"(\w+)\((.*)\)")
_PARTS = re.compile(r",(?![^\[]*\])")


def gradients(
    testbench: Testbench | Machine,
    metrics: Sequence[AnyMeasure | Metric | str],
    silicon: Silicon | None = None,
    *,
    rtol: float = GRADIENT_RTOL,
    check: bool = True,
) -> xr.Dataset:
    """Return the gradients of measures by all devices and parameters, from one run and one run backwards.

    Value and delay of each source are parameters too: `source.NAME.value`, `source.NAME.time`.

    Parameters
    ----------
    testbench
        The testbench, or one that is lowered already.
    metrics
        What is measured: `circuits.gradient.measure`, `circuits.gradient.small_signal.transfer`, or names, as
        `spike_time(spike,0)`, or `db(v_out,v_plus,1kHz)` of small signals; or metrics, as
        `load_metric("best_delay")`.
    silicon
        Process, temperature and die: the nominal process at 27 degC unless given; of no effect on a lowered
        testbench.
    rtol
        Local error of a step of the transient, relative to the larger of |v| and 1 V.
    check
        Whether gradients of a run are found at ten times the tolerance too, and each measure on the two dies
        one sigma along its gradient; the notes tell what does not agree.

    Returns
    -------
    Dataset
        `gradient` [metric, parameter] in SI units, `value` and `note` [metric], `sigma` [parameter], and the
        standard deviation `spread` [metric] that the gradients and sigmas give; with `check` the `error`
        [metric], a share of that, by which gradients at ten times the tolerance differ.

    Raises
    ------
    ParameterError
        There is no measure, something is none and no name of one, or one text stands for a list of names.
    UnknownNameError
        A node, port or source is unknown.
    SolverError
        The solver gives up.
    """
    if isinstance(metrics, str):
        raise ParameterError(f'metrics: "{metrics}", must be a list of measures; write ["{metrics}"]')
    machine = testbench if isinstance(testbench, Machine) else to_kernel(testbench, silicon)

    def wanted(each: AnyMeasure | Metric | str) -> AnyMeasure:
        if isinstance(each, Metric):
            circuit = machine.testbench.circuit
            return measure_of_metric(each, lambda: each.prepare(circuit, machine.silicon))
        if isinstance(each, str):
            return measure_of(each)
        if not isinstance(each, AnyMeasure):
            raise ParameterError(f"metrics: {each!r}, must be a measure, a metric or a name; as {FORMS}")
        return each

    asked = [wanted(each) for each in metrics]
    return dataset_of(every_gradient(machine, asked, rtol=rtol, moves=own_moves(machine), check=check))


def dataset_of(found: Gradients) -> xr.Dataset:
    """Return gradients as a dataset, as of `gradients`."""
    return xr.Dataset(
        {
            "gradient": (("metric", "parameter"), found.by),
            "value": ("metric", found.values),
            "spread": ("metric", found.spread),
            "sigma": ("parameter", found.sigma),
            "error": ("metric", found.error if found.error.size else np.full(found.values.size, np.nan)),
            "note": ("metric", np.array(found.notes, dtype=object)),
            "unit": ("metric", np.array(found.units, dtype=object)),
            "parameter_unit": ("parameter", np.array(found.of_units, dtype=object)),
        },
        {"metric": list(found.measures), "parameter": list(found.labels)},
    )


def measure_of(text: str) -> AnyMeasure:
    """Return the measure of a name, as `fall(v_mem,1V,0)`; raises `ParameterError` for another text."""
    form = _FORM.fullmatch(text.strip())
    parts = [part.strip() for part in _PARTS.split(form[2])] if form else []
    made, most = (None, 0) if form is None else _MADE.get(form[1], (None, 0))
    try:
        found = None if made is None or len(parts) > most else made(parts)
    except IndexError:
        found = None
    if found is None or not parts[0]:
        raise ParameterError(f"metric: {text}, must be a metric of the block, or one of {FORMS}")
    return found


def _number(parts: Sequence[str], k: int) -> int:
    text = parts[k] if len(parts) > k else "0"
    if not text.isdigit():
        raise ParameterError(f"metric: {text}, must be the number of an event, from 0")
    return int(text)


def _crossing(parts: Sequence[str], *, rising: bool) -> Measure:
    return Crossing(
        parts[0], parse_quantity(parts[1], unit_of(parts[0]), "metric"), rising, _number(parts, 2)
    )


def _at(of: Callable[[str, float | None], Measure], parts: Sequence[str]) -> Measure:
    return of(parts[0], _time(parts[1]) if len(parts) > 1 else None)


def _time(text: str) -> float:
    """A time of a run, s."""
    time = parse_quantity(text, "s", "metric")
    if time < 0.0:
        raise ParameterError(f"metric: {text}, must be a time of the run, from 0s on")
    return time


def _span(parts: Sequence[str]) -> tuple[float, float]:
    """Begin and end, s, where they are given."""
    if len(parts) == 1:
        return 0.0, np.inf
    begin, end = _time(parts[1]), _time(parts[2])
    if not begin < end:
        raise ParameterError(f"metric: {parts[1]} to {parts[2]}, must be rising times")
    return begin, end


def _frequency(text: str) -> float:
    """A frequency of small signals, Hz."""
    frequency = parse_quantity(text, "Hz", "metric")
    if not 0.0 < frequency < np.inf:
        raise ParameterError(f"metric: {text}, must be a frequency above 0; as 1kHz")
    return frequency


def _transfer(parts: Sequence[str], kind: Literal["mag", "db", "phase"]) -> SmallSignal:
    return Transfer(kind, parts[0], parts[1], _frequency(parts[2]))


def _corner(parts: Sequence[str], level: float | None) -> SmallSignal:
    if len(parts) == 2:
        return Corner(parts[0], parts[1], level)
    low, high = _frequency(parts[2]), _frequency(parts[3])
    if not low < high:
        raise ParameterError(f"metric: {parts[2]} to {parts[3]}, must be rising frequencies")
    return Corner(parts[0], parts[1], level, low, high)


_MADE: Mapping[str, tuple[Callable[[Sequence[str]], AnyMeasure], int]] = {
    "spike_time": (lambda parts: SpikeTime(parts[0], _number(parts, 1)), 2),
    "voltage": (partial(_at, Voltage), 2),
    "current": (partial(_at, Current), 2),
    "rise": (partial(_crossing, rising=True), 3),
    "fall": (partial(_crossing, rising=False), 3),
    "maximum": (lambda parts: Extreme(parts[0], True, *_span(parts)), 3),  # noqa: FBT003 - the highest
    "minimum": (lambda parts: Extreme(parts[0], False, *_span(parts)), 3),  # noqa: FBT003 - the lowest
    "integral": (lambda parts: Integral(parts[0], *_span(parts)), 3),
    "energy": (lambda parts: Energy(parts[0], *_span(parts)), 3),
    "mag": (partial(_transfer, kind="mag"), 3),
    "db": (partial(_transfer, kind="db"), 3),
    "phase": (partial(_transfer, kind="phase"), 3),
    "bandwidth": (partial(_corner, level=None), 4),
    "unity_gain": (partial(_corner, level=1.0), 4),
}
"""How each is made of its parts, and how many there are at most."""


def moves_of(choice: Choice, machine: Machine) -> list[Move]:
    """Return the parameters of a block's testbench: its knobs, as `stimulus.echo`, then its sources' own.

    A knob that moves more than sources, as the length of a run, is not among them, nor one that is off or 0.
    """
    found = []
    for knob in choice.block.stimuli:
        value = choice.stimuli.get(knob.name)
        if value is not None and np.isfinite(value) and value != 0.0:
            size = _NUDGE * abs(value)
            try:
                more, less = (
                    replace(choice, stimuli={**choice.stimuli, knob.name: value + s}).testbench()
                    for s in (size, -size)
                )
            except CircuitError:  # a number that is whole, or at the end of its range
                continue
            found.append(move_between(machine, Step(f"stimulus.{knob.name}", knob.unit, size), more, less))
    return [*filter(None, found), *own_moves(machine)]


_NUDGE = 1e-6  # of a knob, by which it is moved; ours


def is_form(name: str) -> bool:
    """Return whether the name of a measure is a form that every testbench has."""
    return _FORM.fullmatch(name.strip()) is not None


def measures_of(choice: Choice, names: Sequence[str], own: Sequence[str] = ()) -> list[AnyMeasure]:
    """Return the measures of names: forms that every testbench has, and what the block's testbench measures.

    Parameters
    ----------
    choice
        The block.
    names
        The names.
    own
        Texts of measures that names may mean too, as those of a deck's cards.

    Raises
    ------
    ParameterError
        A metric is neither a number of one run of the testbench nor a search whose edges are known.
    UnknownNameError
        A name is unknown.
    """
    return [measure_of(name) if is_form(name) else _of_block(choice, name, own) for name in names]


def _of_block(choice: Choice, name: str, own: Sequence[str]) -> Measure | Searched:
    texts = with_named(own, (name,)) if name in map(measure_name, own) else (name,)
    try:
        (metric,) = (each for each in metrics_of(choice, texts) if each.name == name or len(texts) == 1)
    except UnknownNameError as error:
        raise UnknownNameError(f"{error}, or {FORMS}") from None
    return measure_of_metric(metric, lambda: metric.prepare(choice.circuit, choice.silicon))


def measure_of_metric(metric: Metric, prepare: Callable[[], Machine]) -> Measure | Searched:
    """Return the measure of a metric; prepare: gives the machine that a search is made on.

    Raises `ParameterError` for a metric that is neither read from one run nor a search with edges.
    """
    return measured_by(metric) if metric.edges is None else Searched(metric, prepare())


def measured_by(metric: Metric) -> Measure:
    """Return the measure of a metric; raises `ParameterError` where it is not read from one run."""
    if metric.measure is not simulate or metric.value is None:
        raise ParameterError(
            f"metric: {metric.name}, is no number of one run of the testbench, nor a search with known edges,"
            " so that it has no gradient; name one that the testbench measures"
        )
    value = metric.value
    if isinstance(value, Told):
        return Expression(value.measure)

    def read(result: Result) -> float:
        return value(result)

    return Measured(metric.name, read, metric.unit or unit_of_name(metric.name))


def shares(found: Gradients, metric: int = 0) -> Mapping[str, float]:
    """Return the share of each parameter in the variance of a measure, the largest first, by its label.

    Parameters
    ----------
    found
        Gradients.
    metric
        Which of its measures.
    """
    power = (found.by[metric] * found.sigma) ** 2
    total = float(power.sum())
    if not total > 0.0:
        return {}
    order = np.argsort(-power, kind="stable")
    return {found.labels[k]: float(power[k] / total) for k in order if power[k] > 0.0}


def draw_gradients(found: Gradients, metric: int, ax: Axes, most: int = 15) -> None:
    """Draw what one sigma of each parameter moves a measure by, the largest on top.

    Parameters
    ----------
    found, metric
        As `shares` has them.
    ax
        Axes to draw into.
    most
        How many parameters are shown.
    """
    moved = found.by[metric] * found.sigma
    order = np.argsort(-np.abs(moved), kind="stable")[:most]
    places = np.arange(order.size)
    ax.barh(places, moved[order], color=[COLOURS[0] if moved[k] > 0.0 else COLOURS[1] for k in order])
    ax.set_yticks(places, [found.labels[k] for k in order])
    ax.invert_yaxis()
    ax.axvline(0.0, color="black", linewidth=0.8)
    unit = f" ({found.units[metric]})" if found.units[metric] else ""
    ax.set_xlabel(f"{found.measures[metric]} by one sigma{unit}")
