"""Jitter of an event by the noise of all devices, from one transient without noise.

Small noise currents i(t) move the voltages of a transient by dv, `d(C dv)/dt + G(t) dv = i`, G the devices'
conductances along the way, and an event where a port passes half the supply at the slope s by `-dv / s`.
With the steps of the transient, shorter ones towards the event, and second backward differences a,

    (a_0 C + G_k) dv_k + C (a_1 dv_(k-1) + a_2 dv_(k-2)) = i_k

one run backwards, of the transposed equations, gives what a current at any place and step does to the event:

    (a_0 C + G_k)^T m_k = -C^T (a_1 m_(k+1) + a_2 m_(k+2)),     (a_0 C + G_K)^T m_K = e / s

each a of the step that it leads to, and the event's variance is the sum over devices and steps of

    white     (S_k / 2 h_k) (m_start - m_end)^2,        h_k the step, S_k the density at the moment's state
    flicker   s_r^2 w_k w_l e^(-r |t_k - t_l|),         w = g_m (m_drain - m_source), over relaxations r, s_r

(`circuits.devices.noise`, `circuits.solver.noise.transient.relaxations`). Two things keep the tolerance of
the transient out of it. A node that runs away by feedback starts at microvolts, where an error of the
transient is a large share of its rate; but what is autonomous shifts as a whole, so that backwards from the
event, as long as no source has had a share in it (`DRIVEN`), m is scaled to where a shift of the whole way in
time shifts the event by as much. And a charge that comes in one of unequal steps is worth more or less than
its time to these differences, which is made up for by what it is worth to an integrator.

Noise at an earlier edge of a run, as at the end of a call before the next one, needs a tolerance at which
the steps of the transient resolve it: behind an earlier event two tolerances are to be compared. This is the
linear theory of what `simulate_noisy` draws: exact for noise that moves a node by little beside the scale on
which devices bend.

The transposed run is Tellegen's adjoint network: Director & Rohrer, "The generalized adjoint network and
network sensitivities" (1969).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.catalogue import later
from circuits.compiled import compiled
from circuits.devices.noise import NoiseModel, gate_flicker, noise_model
from circuits.errors import ParameterError
from circuits.lowering.kernel import Kernel, Machine
from circuits.solver.integrate import source_values
from circuits.solver.newton import Work, allocate, evaluate, fill_jacobian, set_base, with_charges
from circuits.solver.noise.analysis import kernel_order, noise_sources, owners, transistor_areas
from circuits.solver.noise.steps import moving_densities
from circuits.solver.noise.transient import relaxations
from circuits.solver.operating_point import OperatingPoint, operating_point, solve_dense, write_dense
from circuits.solver.transient import DEFAULT_RTOL, Result, simulate

interpolate = later("scipy.interpolate")  # slow to import

DRIVEN = 0.01  # share of an event that sources made, from which on the way is taken as it is; ours
LONGEST = 0.05  # of the time to the event, of a step; ours
FINEST = 1e-3  # of the last step of the transient, from which on steps are as short as that; ours
GROWTH = 1.5  # of the steps of the rest before a run, towards the past; ours


class _Way(NamedTuple):
    """The transient up to the event, a row a step, the event last."""

    time: F64  # [steps], s
    voltage: F64  # [steps, columns], V
    rate: F64  # [steps, unknowns], V/s
    share: F64  # [steps, 3], 1/s, of v_k, v_(k-1) and v_(k-2) in the rate at step k
    even: F64  # [steps], length of a step over what a charge that comes in it is worth


class _Currents(NamedTuple):
    """Noise currents, the channels' first."""

    start: I64  # [n], column that a current leaves
    end: I64  # [n], column that it enters
    density: F64  # [n], A^2/Hz; the channels' are filled in at each step


class _Scratch(NamedTuple):
    """Scratch of one call."""

    work: Work
    charge: F64  # [unknowns, unknowns], F
    matrix: F64  # [unknowns, unknowns]
    moved: F64  # [4, columns]


class _Found(NamedTuple):
    """What the backward run fills in."""

    white: F64  # [n], s^2, variance by each noise current
    gate: F64  # [steps, transistors], s/V, what a step of a gate's voltage moves the event by


@dataclass(frozen=True, slots=True)
class EventJitter:
    """Variance of the time of an event, by the device whose noise makes it.

    port: label of the port. time: time of the event without noise, s. devices: paths of the devices that make
    noise. white, flicker: variance by device, float64[devices], s^2.
    """

    port: str
    time: float
    devices: tuple[str, ...]
    white: F64 = field(repr=False)
    flicker: F64 = field(repr=False)

    @property
    def deviation(self) -> float:
        """Standard deviation of the event's time, s."""
        return float(np.sqrt(self.white.sum() + self.flicker.sum()))

    def shares(self) -> dict[str, float]:
        """Share of the variance that each device has, the largest first, by its path."""
        own = self.white + self.flicker
        order = np.argsort(-own, kind="stable")
        return {self.devices[k]: float(own[k] / own.sum()) for k in order}


def event_jitter(
    machine: Machine,
    port: str,
    model: NoiseModel | None = None,
    *,
    number: int = 0,
    rest: float = 0.0,
    rtol: float = DEFAULT_RTOL,
    point: OperatingPoint | None = None,
) -> EventJitter:
    """Jitter of an event of a testbench.

    Parameters
    ----------
    machine
        Lowered testbench, without junction leakage, that watches the port.
    port
        Label of the port, as `spike` or `line[4]`.
    model
        Flicker; the process's own unless given.
    number
        Which of the port's events, from 0.
    rest
        For how long the circuit was at rest with noise before the run, s.
    rtol
        Local error of a step of the transient, relative to the larger of |v| and 1 V.
    point
        Rest state to begin in, solved for unless given.

    Raises
    ------
    ParameterError
        No such event.
    """
    title = machine.testbench.title
    point = operating_point(machine, time=0.0) if point is None else point
    result = simulate(machine, rtol=rtol, point=point)
    times = result.spikes.get(port, np.zeros(0))
    if number >= times.size:
        raise ParameterError(f"{title}.{port}: {times.size} events, must be more than {number}; see its run")
    model = noise_model(machine.silicon.process) if model is None else model
    way = _way(result, float(times[number]), rest)
    found, k = noise_sources(point, model), machine.kernel
    order = kernel_order(found)
    begin = np.zeros(k.unknowns)
    begin[machine.column_of(port)] = 1.0 / way.rate[-1, machine.column_of(port)]
    currents = _Currents(found.start[order], found.end[order], found.white[order].copy())
    moves = _Found(np.zeros(order.size), np.zeros((way.time.size, k.transistors.sign.size)))
    n = k.unknowns
    scratch = _Scratch(allocate(k), np.zeros((n, n)), np.zeros((n, n)), np.zeros((4, k.columns)))
    if not _backwards(k, way, begin, currents, scratch, moves):
        raise ParameterError(f"{title}: singular on its way to {port}; look for a node that floats")
    flicker = np.zeros(order.size)
    flicker[: moves.gate.shape[1]] = _flicker(point, model, way.time, moves.gate)
    names, owner = owners([found.device[i] for i in order])
    own = [np.asarray(np.bincount(owner, each, len(names)), np.float64) for each in (moves.white, flicker)]
    return EventJitter(port, float(times[number]), names, *own)


def _way(result: Result, event: float, rest: float) -> _Way:
    """The way from the rest before the run to the event at `event`, s; rest: how long, s."""
    machine = result.machine
    kept = np.concatenate([[True], np.diff(result.time) > 0.0])
    time = result.time[kept]
    own = _grid(time[time < event], event, rest)
    volts = result.voltage[kept]
    path = interpolate.CubicHermiteSpline(time, volts, np.gradient(volts, time, axis=0))
    slope = path.derivative()
    voltage, rate = (np.zeros((own.size, machine.kernel.columns)) for _ in range(2))
    columns = [machine.column_of(n) for n in result.nodes]
    voltage[:, columns] = path(np.maximum(own, 0.0))
    rate[:, columns] = np.where(own[:, None] > 0.0, slope(np.maximum(own, 0.0)), 0.0)
    sources = machine.sources()
    cursor = sources.start[:-1].copy()
    for t, v in zip(own, voltage, strict=True):
        source_values(sources, cursor, max(t, 0.0), v, machine.kernel.unknowns)
    voltage = with_charges(machine.kernel, voltage)
    share, even = _differences(own), np.ones(own.size)
    _fill_evenness(own, share, even)
    return _Way(own, voltage, rate[:, : machine.kernel.unknowns].copy(), share, even)


def _grid(time: F64, event: float, rest: float) -> F64:
    """Times (s) of the transient up to the event, the rest before them, and what is missing between.

    Noise at a node is made in its last few time constants: so steps are at most a twentieth of
    what is left to the event, down to a thousandth of the transient's last one.
    """
    gone = np.concatenate([event - time, [0.0]])  # falls to the event
    least = gone[-2] * FINEST
    marks = [gone[-1:], np.array([least])]
    ratio = 1.0 / (1.0 - LONGEST)
    for long, short in zip(gone[-2::-1], np.maximum(gone[:0:-1], least), strict=True):
        count = math.ceil(math.log(long / short) / math.log(ratio)) if long > short else 0
        if count > 1:
            marks.append(np.geomspace(short, long, count + 1)[1:])
        elif count:  # most steps are short enough as they are
            marks.append(np.array([long]))
    past = [gone[0] + (gone[0] - gone[1])]
    while rest > 0.0 and past[-1] < gone[0] + rest:
        past.append(past[-1] + GROWTH * (past[-1] - (past[-2] if len(past) > 1 else gone[0])))
    if rest > 0.0:
        marks.append(np.array(past))
    return np.asarray(event - np.concatenate(marks)[::-1])


def _differences(time: F64) -> F64:
    """Coefficients (1/s) of v_k, v_(k-1), v_(k-2) in the rate at step k, float64[steps, 3]."""
    share = np.zeros((time.size, 3))
    h = np.diff(time)
    w = h[1:] / h[:-1]
    share[1, :2] = 1.0 / h[0], -1.0 / h[0]
    share[2:, 0] = (1.0 + 2.0 * w) / ((1.0 + w) * h[1:])
    share[2:, 1] = -(1.0 + w) / h[1:]
    share[2:, 2] = w * w / ((1.0 + w) * h[1:])
    return share


@compiled()
def _fill_evenness(time: F64, share: F64, even: F64) -> None:
    """Length of each step over what a charge that comes in it is worth to an integrator, by the differences.

    It is 1 for equal steps; for steps that fall by w, `(1 + 2 w - w^2) / (1 + w)`.
    """
    last = time.size - 1
    one, two = 0.0, 0.0
    for step in range(last, 0, -1):
        owed = 1.0 if step == last else -share[step + 1, 1] * one
        if step < last - 1:
            owed -= share[step + 2, 2] * two
        two, one = one, owed / share[step, 0]
        even[step] = (time[step] - time[step - 1]) / one


@compiled()
def _charges(k: Kernel, w: Work, charge: F64, matrix: F64) -> None:
    """Fill charge with C; leaves the linear conductances in the working space. matrix: scratch."""
    w.slope[:] = 0.0
    set_base(k, 1.0, w)
    fill_jacobian(k, w)
    write_dense(k, w, charge)
    set_base(k, 0.0, w)
    fill_jacobian(k, w)
    write_dense(k, w, matrix)
    for i in range(k.unknowns):
        for j in range(k.unknowns):
            charge[i, j] -= matrix[i, j]


@compiled()
def _transposed(k: Kernel, v: F64, a: float, charge: F64, w: Work, matrix: F64) -> None:
    """Fill matrix with `(a C + G)^T` at v."""
    evaluate(k, v, w)
    fill_jacobian(k, w)
    write_dense(k, w, matrix)
    for i in range(k.unknowns):
        for j in range(i):
            matrix[i, j], matrix[j, i] = matrix[j, i], matrix[i, j]
    for i in range(k.unknowns):
        for j in range(k.unknowns):
            matrix[i, j] += a * charge[j, i]


@compiled()
def _owed(share: F64, step: int, begin: F64, charge: F64, moved: F64, right: F64) -> None:
    """Right side of the transposed equations at a step; moved: of the two steps after it."""
    last = share.shape[0] - 1
    one = share[step + 1, 1] if step < last else 0.0
    two = share[step + 2, 2] if step < last - 1 else 0.0
    for i in range(right.size):
        total = begin[i] if step == last else 0.0
        for j in range(right.size):
            total -= charge[j, i] * (one * moved[0, j] + two * moved[1, j])
        right[i] = total


@compiled()
def _shift_by_one(share: F64, step: int, rate: F64, charge: F64, moved: F64) -> None:
    """Scale what is moved so that a shift of the whole way in time shifts the event by as much."""
    last = share.shape[0] - 1
    one, both = share[step + 1, 1], share[step + 1, 2]
    two = share[step + 2, 2] if step < last - 1 else 0.0
    total = 0.0
    for i in range(rate.shape[1]):
        for j in range(rate.shape[1]):
            by = (one * moved[0, j] + two * moved[1, j]) * rate[step, i] + both * moved[0, j] * rate[
                step - 1, i
            ]
            total -= charge[j, i] * by
    for i in range(rate.shape[1]):
        moved[0, i] /= total
        moved[1, i] /= total


@compiled()
def _drive(k: Kernel, voltage: F64, step: int, w: Work, moved: F64) -> float:
    """Event (s) times what the sources' movement in a step adds to a current; w: as evaluated at the step."""
    v, n = moved[3], k.unknowns
    same = True
    for i in range(n, k.columns):
        same = same and voltage[step, i] == voltage[step - 1, i]
    if same:
        return 0.0
    by = 0.0
    for i in range(n):
        v[i] = voltage[step, i]
        by += moved[0, i] * w.residual[i]
    for i in range(n, k.columns):
        v[i] = voltage[step - 1, i]
    evaluate(k, v, w)
    for i in range(n):
        by -= moved[0, i] * w.residual[i]
    return by


@compiled()
def _backwards(
    k: Kernel, way: _Way, begin: F64, currents: _Currents, scratch: _Scratch, found: _Found
) -> bool:
    """Fill `found` by the transposed run; false where its equations are singular.

    begin: float64[unknowns], s/V, what a voltage at the event moves it by.
    """
    time, voltage, share = way.time, way.voltage, way.share
    start, end, density = currents.start, currents.end, currents.density
    w, charge, matrix, moved = scratch.work, scratch.charge, scratch.matrix, scratch.moved
    n, m = k.unknowns, k.transistors.sign.size
    _charges(k, w, charge, matrix)
    right, driven = moved[2, :n], 0.0
    for step in range(time.size - 1, 0, -1):
        if abs(driven) < DRIVEN and step < time.size - 1:
            _shift_by_one(share, step, way.rate, charge, moved)
        _owed(share, step, begin, charge, moved, right)
        _transposed(k, voltage[step], share[step, 0], charge, w, matrix)
        if not solve_dense(matrix, right):
            return False
        for i in range(n):
            moved[1, i], moved[0, i] = moved[0, i], right[i]
        moving_densities(k, w, density)
        half = 0.5 / (time[step] - time[step - 1])
        for q in range(density.size):
            at = way.even[step] * (moved[0, start[q]] - moved[0, end[q]])
            found.white[q] += half * density[q] * at * at
            if q < m:
                found.gate[step, q] = at * w.transistor.conductance[1, q]
        if abs(driven) < DRIVEN:
            driven += _drive(k, voltage, step, w, moved) / (time[step] - time[step - 1])
    return True


def _flicker(point: OperatingPoint, model: NoiseModel, time: F64, gate: F64) -> F64:
    """Variance of the event by the flicker of each gate, float64[transistors], s^2."""
    machine = point.machine
    areas = transistor_areas(point)
    if not areas.size:
        return areas
    rate, variance = relaxations(model, float(np.diff(time).min()))
    sign = machine.kernel.transistors.sign
    at_gate = gate_flicker(model, machine.silicon.process, sign > 0.0, areas)
    total = np.zeros((gate.shape[1], rate.size))
    later = np.zeros_like(total)
    for k in range(time.size - 1, 0, -1):
        own = gate[k][:, None]
        if k < time.size - 1:
            later *= np.exp(-rate * (time[k + 1] - time[k]))
        total += own * (2.0 * later + own)
        later += own
    return np.asarray(at_gate * (total @ variance))
