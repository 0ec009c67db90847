"""Gradients of measures of all kinds at once: of a run, of small signals, and of searches over a stimulus.

They are checked on demand: against a coarser run, and on the two dies that are one sigma along the gradient,
where the line that it is has to tell what the measure is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import F64
from circuits.blocks.metric import Metric
from circuits.errors import CircuitError, ParameterError
from circuits.gradient.edge import gradients_at_edges
from circuits.gradient.gradient import GRADIENT_RTOL, Gradients, gradients_of
from circuits.gradient.measure import Measure
from circuits.gradient.small_signal.small_signal import small_signal_gradients
from circuits.gradient.small_signal.spectrum import Spectrum
from circuits.gradient.small_signal.transfer import SmallSignal
from circuits.gradient.stimulus import Move
from circuits.lowering.kernel import Machine, on_die
from circuits.silicon.sampling import Sampling
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import simulate
from circuits.units import format_quantity, unit_of_name

COARSER = 10.0  # times the tolerance, at which gradients are found again; ours
AGREES = 0.01  # of a measure's sigma, up to which both are said to agree; ours
STRAIGHT = 0.5  # sigma, by which a measure one sigma away may be off its gradient's line; ours
_OF_A_FUNCTION = LookupError, ArithmeticError, ValueError, TypeError
"""What a user's function says of a run that lacks what it reads, as its first spike."""


@dataclass(frozen=True, slots=True)
class Searched:
    """A metric that searches over a stimulus.

    metric : it has `edges`.
    machine : what the metric prepares, and measures.
    """

    metric: Metric
    machine: Machine


AnyMeasure = Measure | SmallSignal | Searched
"""What a testbench is measured by: of a run, of small signals, or by a search."""


def every_gradient(
    machine: Machine,
    measures: Sequence[AnyMeasure],
    *,
    rtol: float = GRADIENT_RTOL,
    moves: Sequence[Move] = (),
    check: bool = False,
) -> Gradients:
    """Return the gradients of measures of all kinds, in their order.

    Parameters
    ----------
    machine
        Lowered testbench on its silicon.
    measures
        What is measured.
    rtol
        Local error of a step of the transients, relative to the larger of |v| and 1 V.
    moves
        Parameters of the testbench that measures have a derivative by too, as `own_moves` of its sources;
        NaN of searches.
    check
        Whether those of a run are found at ten times the tolerance too, and what differs by more than 1 % of
        a measure's sigma is told of; and whether it is told what the dies one sigma along the gradient have,
        where that is off its line by more than half a sigma.

    Raises
    ------
    ParameterError
        There is no measure, or a frequency is not above 0.
    UnknownNameError
        No such node or source.
    SolverError
        The solver gives up, or equations are singular.
    """
    if not measures:
        raise ParameterError(f"{machine.testbench.title}: no measure, must be at least one")
    runs = {k: each for k, each in enumerate(measures) if isinstance(each, Measure)}
    small = {k: each for k, each in enumerate(measures) if isinstance(each, SmallSignal)}
    parts = []
    if runs:
        of_run = list(runs.values())
        found = gradients_of(machine, of_run, rtol=rtol, moves=moves)
        parts.append((list(runs), _checked(machine, of_run, found, rtol) if check else found))
    if small:
        parts.append((list(small), small_signal_gradients(machine, list(small.values()), moves=moves)))
    for k, each in enumerate(measures):
        if isinstance(each, Searched):
            parts.append(([k], gradients_of_search(each, rtol=rtol)))
    if check:
        parts = [(own, _straight(machine, [measures[k] for k in own], g, rtol)) for own, g in parts]
    return _together(parts)


def gradients_of_search(searched: Searched, *, rtol: float = GRADIENT_RTOL) -> Gradients:
    """Return the gradients of a metric that searches over a stimulus, at the edges of its search.

    A metric that has no value has no parameter either, and a note.
    """
    metric, machine = searched.metric, searched.machine
    measured = metric.measure(machine)
    edges = [] if metric.edges is None else metric.edges(machine, measured)
    unit = metric.unit or unit_of_name(metric.name)
    if edges:
        value = math.nan if metric.value is None else float(metric.value(measured))
        return gradients_at_edges(metric.name, unit, value, edges, rtol=rtol)
    why = metric.reason(measured) or metric.outcome(measured)
    none, note = np.zeros(0), f"{why}, so that it has no value"
    return Gradients((metric.name,), (unit,), np.array([np.nan]), (note,), (), (), none, none[None], None)


def _checked(machine: Machine, measures: Sequence[Measure], found: Gradients, rtol: float) -> Gradients:
    """The gradients, with how far those of a coarser run differ from them."""
    coarse = gradients_of(machine, measures, rtol=COARSER * rtol)
    count = len(coarse.labels)
    moved = np.abs(found.by[:, :count] - coarse.by) * found.sigma[:count]
    spread = found.spread
    error = np.divide(moved.max(axis=1, initial=0.0), spread, out=np.zeros(spread.size), where=spread > 0.0)
    notes = []
    for note, value, own in zip(found.notes, found.values, error.tolist(), strict=True):
        told = f"at ten times the tolerance it differs by {100.0 * own:.2g} % of its sigma"
        if math.isnan(own) and np.isfinite(value):
            told = "at ten times the tolerance it has none"
        doubtful = np.isfinite(value) and not own <= AGREES
        notes.append("; ".join(filter(None, (note, told if doubtful else ""))))
    return replace(found, notes=tuple(notes), error=error)


def _straight(machine: Machine, measures: Sequence[AnyMeasure], found: Gradients, rtol: float) -> Gradients:
    """The gradients, with what is on the dies one sigma along them where that is not on their lines."""
    notes = []
    for k, (note, each) in enumerate(zip(found.notes, measures, strict=True)):
        there = each.machine if isinstance(each, Searched) else machine
        notes.append("; ".join(filter(None, (note, *_along(there, found, k, each, rtol)))))
    return replace(found, notes=tuple(notes))


def _along(
    machine: Machine, found: Gradients, number: int, measure: AnyMeasure, rtol: float
) -> Iterator[str]:
    """What is to be said of both dies one sigma along a measure's gradient."""
    value, spread = float(found.values[number]), float(found.spread[number])
    if not spread > 0.0 or machine.silicon.die.sampling is not None:
        return
    for sign, way in ((1.0, "along"), (-1.0, "against")):
        there = _moved(machine, found, sign * found.by[number] / spread)
        try:
            moved, why = _value_on(there, measure, COARSER * rtol)
        except (CircuitError, *_OF_A_FUNCTION) as error:
            moved, why = math.nan, str(error)
        if math.isnan(moved):
            yield f"one sigma {way} its gradient it has no value: {why}"
        elif abs(moved - value - sign * spread) > STRAIGHT * spread:
            by = format_quantity(moved - value, found.units[number])
            yield f"one sigma {way} its gradient it moves by {by}, not by the sigma"


def _value_on(machine: Machine, measure: AnyMeasure, rtol: float) -> tuple[float, str]:
    """A measure's value on a die, and why it has none."""
    if isinstance(measure, Measure):
        return measure.value(simulate(machine, rtol=rtol))
    if isinstance(measure, SmallSignal):
        found = measure.read(Spectrum(operating_point(machine)))
        return found.value, found.note
    metric = measure.metric
    measured = metric.measure(machine)
    value = None if metric.value is None else metric.value(measured)
    return math.nan if value is None else float(value), metric.reason(measured) or metric.outcome(measured)


def _moved(machine: Machine, found: Gradients, by: F64) -> Machine:
    """The testbench on the die whose draws differ by a direction's, which `by` times sigma is."""
    keep = np.flatnonzero(found.sigma > 0.0)
    columns = {found.labels[k]: at for at, k in enumerate(keep.tolist())}
    die, rows = machine.silicon.die, (by * found.sigma)[keep][None]
    drawn = Sampling("along a gradient", die.number or 0, columns, rows, added=die.number is not None)
    if die.number is None:
        die = replace(die, number=0, variation="plain")  # all that such a die draws has a column
    return on_die(machine, replace(die, sampling=drawn))


def _together(parts: Sequence[tuple[Sequence[int], Gradients]]) -> Gradients:
    """Several in one; with each, at which places its measures stand."""
    if len(parts) == 1:
        return parts[0][1]
    units = {label: unit for _, g in parts for label, unit in zip(g.labels, g.of_units, strict=True)}
    sigmas = {label: s for _, g in parts for label, s in zip(g.labels, g.sigma.tolist(), strict=True)}
    column = {label: k for k, label in enumerate(units)}
    count = sum(len(places) for places, _ in parts)
    by, values, error = np.full((count, len(units)), np.nan), np.empty(count), np.full(count, np.nan)
    texts = [("", "", "")] * count
    for places, g in parts:
        for row, place in enumerate(places):
            by[place, [column[label] for label in g.labels]] = g.by[row]
            values[place], texts[place] = g.values[row], (g.measures[row], g.units[row], g.notes[row])
            error[place] = g.error[row] if g.error.size else np.nan
    names, of, notes = (tuple(each) for each in zip(*texts, strict=True))
    return Gradients(
        names, of, values, notes, tuple(units), tuple(units.values()), np.array(list(sigmas.values())), by,
        parts[0][1].result, error,
    )  # fmt: skip
