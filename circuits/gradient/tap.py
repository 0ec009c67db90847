"""Currents that measures read, and what they add to an adjoint run.

A measure that reads a current (`circuits.gradient.flow`) has slopes by the voltages, as others have. What
devices do to it beside these is what an adjoint run sums up for them with m = -e: `Sums` of both are added.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, Bools
from circuits.gradient.backwards import Tap
from circuits.gradient.flow import conducted, flow_of, gather
from circuits.gradient.reading import Reading, read_at
from circuits.gradient.sums import Ends, Sums, ends_of
from circuits.gradient.way import Way
from circuits.lowering.kernel import Machine
from circuits.measure.current import current_in, rate
from circuits.measure.signal import NODES, WEIGHTS
from circuits.solver.transient import Result


class Into(NamedTuple):
    """Slopes by voltages, float64[measures, rows, columns], by times, float64[measures, rows], and sums."""

    slopes: F64
    timing: F64
    sums: Sums


class Course(NamedTuple):
    """A waveform of a run.

    way : the run, with the waveform in a column.
    column : which it is.
    name : of the device or source whose current it is; None for a voltage.
    """

    way: Way
    column: int
    name: str | None

    @property
    def values(self) -> F64:
        """The waveform, V or A, float64[rows]."""
        return self.way.voltage[:, self.column]

    def told(self, found: Reading) -> Reading:
        """Return what was read of the waveform with the current that it is."""
        if self.name is None:
            return found
        weight = np.zeros(self.way.time.size)
        for row, _, slope in found.slopes:
            weight[row] += slope
        near = tuple(each._replace(reading=self.told(each.reading)) for each in found.near)
        return found._replace(slopes=(), taps=(_tap(self.name, weight),), near=near)


def _tap(name: str, weight: F64) -> Tap:
    """What reads a current by some weights of the rows."""
    rate = weight.copy()
    # before the first step charge flows as in it
    rate[1:2] += rate[:1]
    rate[0] = 0.0
    return Tap(name, weight, rate, np.zeros(weight.size))


def unit_of(node: str) -> str:
    """Return the SI unit of a node's voltage, or of `i(NAME)`."""
    return "V" if current_in(node) is None else "A"


def course_of(result: Result, way: Way, node: str) -> Course:
    """Return the waveform of a node, or of `i(NAME)`; raises `UnknownNameError` where there is none."""
    name = current_in(node)
    if name is None:
        return Course(way, result.machine.column_of(node), None)
    wide = np.column_stack([way.voltage, _current(result.machine, way, name)])
    return Course(way._replace(voltage=wide), wide.shape[1] - 1, name)


def current_at(machine: Machine, way: Way, name: str, time: float) -> Reading:
    """Read the current of a device or source at a time within a run, s."""
    row = max(int(np.searchsorted(way.time, time)), 1)
    first = max(row - _BEHIND, 0)
    near = way._replace(
        time=way.time[first : row + 1], voltage=way.voltage[first : row + 1],
        order=way.order[first : row + 1],
    )  # fmt: skip
    wide = np.full((row + 1, way.voltage.shape[1] + 1), np.nan)
    wide[first:, -1] = _current(machine, near, name)
    course = Course(way._replace(voltage=wide), wide.shape[1] - 1, name)
    return course.told(read_at(course.way, row, course.column, time))


_BEHIND = 5  # rows, from which a rate and a parabola at a row are known


def current_at_beginning(machine: Machine, way: Way, name: str) -> Reading:
    """Read the current of a device or source in the state in which a run begins, A."""
    first, none = np.zeros(way.time.size), np.zeros(way.time.size)
    first[0] = 1.0
    begun = way._replace(time=way.time[:1], voltage=way.voltage[:1], order=way.order[:1])
    return Reading(float(_current(machine, begun, name)[0]), (), taps=(Tap(name, first, none, none),))


def through(
    machine: Machine, way: Way, name: str, span: tuple[float, float], column: int | None = None
) -> Reading:
    """Read the charge that passes a device or source between two times, C.

    What flows without charge is a straight line between the steps, and what is stored counts at the ends.

    column: of a source that delivers the charge at its voltage, which makes it an energy, J.
    """
    plain, charge = _parts(machine, way, name)
    part, stored_there = parts_between(way, *span), np.diff(charge)
    before, after, share = part.before, part.after, part.share
    passed = before * plain[:-1] + after * plain[1:] + share * stored_there
    price = np.ones(way.time.size) if column is None else -way.voltage[:, column]
    mean = 0.5 * (price[1:] + price[:-1])
    weight, stored = at_rows(mean * before, mean * after), at_rows(-mean * share, mean * share)
    by_price = np.zeros(way.time.size) if column is None else 0.5 * at_rows(passed, passed)
    along = part.along(mean * plain[:-1], mean * plain[1:], mean * stored_there)
    flows = mean * stored_there / np.diff(way.time)
    own = at_ends(way, span, mean * plain[:-1] + flows, mean * plain[1:] + flows)
    tap = Tap(name, weight, np.zeros(weight.size), stored)
    whole = () if column is None else ((column, -by_price),)
    return Reading(float(mean @ passed), (), taps=(tap,), whole=whole, along=along, own=own)


def squared(result: Result, way: Way, node: str, span: tuple[float, float]) -> Reading:
    """Read the integral of the square of a node's voltage, or of `i(NAME)`, between two times.

    In V^2 s or A^2 s, of the parabolas of the steps, as measures read it.
    """
    course = course_of(result, way, node)
    value, by, along = _squares(way, course.values, span)
    along[[0, -1]] = 0.0
    begin, end = (read_at(course.way, _step_of(way, at), course.column, at).value ** 2 for at in span)
    found = Reading(value, (), along=along, own=(("begin", -begin), ("end", end)))
    if course.name is None:
        return found._replace(whole=((course.column, by),))
    return found._replace(taps=(_tap(course.name, by),))


def _squares(way: Way, y: F64, span: tuple[float, float]) -> tuple[float, F64, F64]:
    """Integral of a waveform's square, and what it moves by with its points: by values and by times.

    In a step to t_k, with x from 0 to 1, `y = y_k-1 + x d_k + x (x - 1) b`, where d are the differences
    of points, r the ratio of the step to the one before it, and `b = r (d_k - r d_k-1) / (1 + r)`, 0 where
    the solver begins anew.
    """
    t, h, d = way.time, np.diff(way.time), np.diff(y)
    low, high = np.clip(t[:-1], *span), np.clip(t[1:], *span)
    length, bends = high - low, way.order[1:] == 2
    shorter, before = np.append(1.0, h)[: h.size], np.append(0.0, d)[: d.size]  # the step before each
    r = np.where(bends, h / shorter, 0.0)
    share = r / (1.0 + r)
    b = share * (d - r * before)
    by_ratio = np.where(bends, (d - r * before) / (1.0 + r) ** 2 - share * before, 0.0)
    value, by_start, by_d, by_before, first, last, ratio = 0.0, *np.zeros((6, h.size))
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        x = (low + node * length - t[:-1]) / h
        bow, there = x * (x - 1.0), y[:-1] + x * d + x * (x - 1.0) * b
        own = 2.0 * weight * length * there
        value += 0.5 * float(own @ there)
        slope = own * (d + (2.0 * x - 1.0) * b) / h
        by_start, by_d, by_before = (
            by_start + own,
            by_d + own * (x + bow * share),
            by_before - own * bow * share * r,
        )
        first, last, ratio = first + slope * (x - 1.0), last - slope * x, ratio + own * bow * by_ratio
    # ends that move with their points
    first -= np.where((length > 0.0) & (low == t[:-1]), y[:-1] ** 2, 0.0)
    last += np.where((length > 0.0) & (high == t[1:]), y[1:] ** 2, 0.0)
    ratio /= shorter
    by = at_rows(by_start - by_d + by_before, by_d)
    by[:-2] -= by_before[1:]
    along = at_rows(first - ratio * (1.0 + r), last + ratio)
    along[:-2] += (ratio * r)[1:]
    return value, by, along


def at_rows(before: F64, after: F64) -> F64:
    """Return the weights of the rows, float64[rows], from those of the points before and after each step."""
    return np.asarray(np.append(before, 0.0) + np.append(0.0, after))


class Parts(NamedTuple):
    """What of each step lies between two times, of straight lines between the steps.

    before, after : float64[steps], s, of the points before and after each, in the integral.
    share : float64[steps], of the step.
    by_before, by_after, by_share : float64[2, steps], what these move by with the times of the two points.
    """

    before: F64
    after: F64
    share: F64
    by_before: F64
    by_after: F64
    by_share: F64

    def along(self, first: F64, second: F64, step: F64) -> F64:
        """Slopes by the times of rows, float64[rows], of the sum of what lies between the times.

        first, second: a waveform at the points before and after each step; step: what is shared of each; all
        float64[steps]. The ends of a run do not move.
        """
        sums = self.by_before * first + self.by_after * second + self.by_share * step
        found = at_rows(sums[0], sums[1])
        found[[0, -1]] = 0.0
        return found


def parts_between(way: Way, begin: float, end: float) -> Parts:
    """Return what of each step lies between two times, s.

    after = ((r - t_k-1)^2 - (l - t_k-1)^2) / 2 h,    share = (r - l) / h,    before = r - l - after

    with l and r the ends of what is within; they move with the points that lie between the times.
    """
    start, stop, h = way.time[:-1], way.time[1:], np.diff(way.time)
    left, right = np.clip(start, begin, end), np.clip(stop, begin, end)
    length = right - left
    after, share = (0.5 * (left + right) - start) / h * length, length / h
    first, second = (length > 0.0) & (start > begin), (length > 0.0) & (stop < end)
    by_after = np.stack([(after - length) / h, second - after / h])
    by_share = np.stack([share - first, second - share]) / h
    by_before = np.stack([-first.astype(float), second.astype(float)]) - by_after
    return Parts(length - after, after, share, by_before, by_after, by_share)


def at_ends(
    way: Way, span: tuple[float, float], first: F64, second: F64
) -> tuple[tuple[str, float], tuple[str, float]]:
    """Return the slopes of an integral by its two ends, as a reading has them: what is integrated is there.

    first, second: that at the points before and after each step, float64[steps].
    """
    found = []
    for at in span:
        row = _step_of(way, at)
        share = (at - way.time[row - 1]) / (way.time[row] - way.time[row - 1])
        found.append(float(first[row - 1] + share * (second[row - 1] - first[row - 1])))
    return ("begin", -found[0]), ("end", found[1])


def _step_of(way: Way, time: float) -> int:
    """Row to which the step goes that a time falls into, s."""
    return min(max(int(np.searchsorted(way.time, time)), 1), way.time.size - 1)


def _current(machine: Machine, way: Way, name: str) -> F64:
    """A current over the rows of a run, A, float64[rows]."""
    plain, charge = _parts(machine, way, name)
    return plain + rate(way.time, charge, _kinks(way))


def _parts(machine: Machine, way: Way, name: str) -> tuple[F64, F64]:
    """What flows without charge over the rows of a run, A, and the charge whose rate flows too, C."""
    flow = flow_of(machine, name, ends_of(machine))
    plain = conducted(machine.kernel, way.voltage, flow, np.ones(way.time.size, np.bool_))
    return plain, way.voltage @ flow.charge


def _kinks(way: Way) -> Bools:
    """Rows at which the solver begins anew."""
    return np.append(way.order[1:] == 1, True)


def add_taps(machine: Machine, way: Way, taps: Sequence[tuple[int, Tap]], ends: Ends, into: Into) -> None:
    """Add what currents do to measures: to their slopes by voltages and by times, and to the sums of devices.

    Parameters
    ----------
    machine, way
        The machine and its run.
    taps
        Number of a measure, and what it reads.
    ends
        As `flow_of` has them.
    into
        To what it is added.
    """
    v, sums = way.voltage, into.sums
    for m, tap in taps:
        flow, slopes = flow_of(machine, tap.name, ends), into.slopes[m]
        gather(machine.kernel, v, tap.conducted, flow, m, slopes, sums)
        # what a charge at each row counts, its rate at that row and the next ones included
        counts = tap.stored.copy()
        for j in range(3):
            counts[: counts.size - j] += tap.rate[j:] * way.share[j:, j]
        at = np.flatnonzero(counts)
        for pairs, weight, of, drops in (
            (ends[0], flow.resistors, sums.conductance, (tap.conducted, slice(None))),
            (ends[1], flow.pairs, sums.charge, (counts[at], at)),
        ):
            own = np.flatnonzero(weight)
            (a, b), (count, rows) = pairs[:, own], drops
            of[m, own] += weight[own] * (count @ (v[rows][:, a] - v[rows][:, b]))
        slopes[at] += counts[at, None] * flow.charge
        into.timing[m] += _by_times(way, v @ flow.charge, tap.rate)


def _by_times(way: Way, y: F64, weight: F64) -> F64:
    """Slopes by the times of the rows of a weighted rate of a charge y, whose points keep their values.

    A point that moves by dt_j bends the parabola of a step there by `-y'(t_j) dt_j`, and its end is told at
    another place: by `y'' dt_k`.
    """
    found, t = np.zeros(y.size), way.time
    for row in np.flatnonzero(weight):
        if row == 0:
            continue
        h, rate = t[row] - t[row - 1], (y[row] - y[row - 1]) / (t[row] - t[row - 1])
        bend, before = 0.0, 0.0
        if way.order[row] == 2:
            before = t[row - 1] - t[row - 2]
            bend = 2.0 * (rate - (y[row - 1] - y[row - 2]) / before) / (h + before)
        found[row] += weight[row] * bend
        for j, after in enumerate((0.5 * h, -0.5 * h, -0.5 * h - before)):
            if way.share[row, j] != 0.0:
                found[row - j] -= weight[row] * way.share[row, j] * (rate + after * bend)
    return found


def carried_by(
    machine: Machine, voltage: F64, taps: Sequence[tuple[int, Tap]], ends: Ends, count: int
) -> F64:
    """Return what flows without charge gives measures at some voltages, float64[count].

    machine: perhaps on another silicon; voltage: float64[rows, columns], V.
    """
    found = np.zeros(count)
    for own, tap in taps:
        flow = flow_of(machine, tap.name, ends)
        found[own] += tap.conducted @ conducted(machine.kernel, voltage, flow, tap.conducted != 0.0)
    return found
