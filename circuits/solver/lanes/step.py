"""One pass over all lanes: a Newton iteration of each, its step begun before and judged after.

Method and error control are those of `circuits.solver.integrate`, where their equations stand; each lane has
its own step and its own iteration. What is at rest, restarts or idles goes through the same sums, with
coefficients that make of them what it needs: a lane at rest has no derivative, and a lane that restarts has
`C v' = -(G v + i)` to solve, so that its step's slopes are 0.
"""

from __future__ import annotations

from circuits.compiled import compiled
from circuits.solver.integrate import SAME_TIME, SMALLEST_STEP, TIMING
from circuits.solver.lanes.layout import ROW, Team, Wiring
from circuits.solver.newton import MAX_ITERATIONS, SLACK
from circuits.vectors import vector
from circuits.vectors.vector import Lanes

load, store, every, select, bits = vector.load, vector.store, vector.every, vector.select, vector.bits
magnitude, larger, smaller = vector.magnitude, vector.larger, vector.smaller
root, inverse_cube_root = vector.root, vector.inverse_cube_root

_FINITE = 1e300  # V; above it an update is no number
_LARGE = 1e9  # V, stands for an update that is no measure of what is left


@compiled()
def begin(c: Wiring, x: Team) -> None:
    """Begin a step in the lanes that are to: its length, derivative, prediction, and the sources' values."""
    t = x.control
    begins = load(t, ROW.begins) >= 0.5
    one, zero = every(1.0), every(0.0)
    time, next_step, bend, points = (
        load(t, ROW.time0),
        load(t, ROW.next_step),
        load(t, ROW.bend),
        load(t, ROW.points),
    )
    room = bend - time
    at_bend = (next_step >= room - SAME_TIME) | (next_step >= 0.999 * room)
    step = select(at_bend, room, select(2.0 * next_step > room, 0.5 * room, next_step))
    step = select(begins, step, one)
    first, second = points < 1.5, points < 2.5
    h1 = select(first, one, time - load(t, ROW.time1))
    h2 = select(second, zero, load(t, ROW.time1) - load(t, ROW.time2))
    # predictor: a point and its derivative; two points and it; three points
    w = step / h1
    grown = 1.0 + w
    past = h1 + select(second, one, h2)
    far = step * (step + h1) / (past * select(second, one, h2))
    p0 = select(first, one, select(second, grown * grown, grown * (step + h1 + h2) / past))
    p2 = select(second, zero, far)
    p_rate = select(first, step, select(second, h1 + step - grown * grown * h1, zero))
    p1 = 1.0 - p0 - p2
    inverse = 1.0 / step
    per = 1.0 / (grown * (1.0 + 2.0 * w))
    a = select(first, inverse, (1.0 + 2.0 * w) * (1.0 + 2.0 * w) * per * inverse)
    b0 = select(first, 0.0 - inverse, 0.0 - grown * inverse)
    b1 = select(first, zero, w * w * (1.0 + 2.0 * w) * per * inverse)
    corrector = step * grown * grown * per
    share = select(first, every(0.5), corrector / (corrector + step + h1 + h2))
    _keep(x, ROW.a, begins, a)
    _keep(x, ROW.b0, begins, b0)
    _keep(x, ROW.b1, begins, b1)
    _keep(x, ROW.share, begins, share)
    _keep(x, ROW.step, begins, step)
    _keep(x, ROW.inverse_step, begins, inverse)
    _keep(x, ROW.time_new, begins, select(at_bend, bend, time + step))
    _keep(x, ROW.at_bend, begins, select(at_bend, one, zero))
    _keep(x, ROW.iteration, begins, zero)
    _keep(x, ROW.largest_move, begins, one)
    _keep(x, ROW.devices, begins, one)
    _keep(x, ROW.steps, begins, one)
    for i in range(c.unknowns):
        past_values = p0 * load(x.v0, i) + p1 * load(x.v1, i)
        guess = past_values + p2 * load(x.v2, i) + p_rate * load(x.slope, i)
        store(x.v, i, select(begins, guess, load(x.v, i)))
        store(x.guess, i, select(begins, guess, load(x.guess, i)))
    since = load(t, ROW.time_new) - load(t, ROW.began)
    for q in range(c.moving.size):
        i = c.unknowns + c.moving[q]
        store(x.v, i, select(begins, load(x.base, q) + since * load(x.drift, q), load(x.v, i)))
    store(t, ROW.begins, zero)


@compiled(forceinline=True)
def _keep(x: Team, row: int, begins: Lanes, value: Lanes) -> None:
    store(x.control, row, select(begins, value, load(x.control, row)))


@compiled()
def assemble(c: Wiring, x: Team) -> None:
    """Residual and Jacobian in all lanes, of the devices' currents and slopes there."""
    t = x.control
    a, b0, b1, devices = load(t, ROW.a), load(t, ROW.b0), load(t, ROW.b1), load(t, ROW.devices)
    for i in range(c.columns):
        store(x.rate, i, a * load(x.v, i) + b0 * load(x.v0, i) + b1 * load(x.v1, i) + load(x.extra, i))
    _residual(c, x)
    _jacobian(c, x, a, devices)
    for i in range(c.unknowns):
        if not c.dynamic[i]:  # a restart leaves a node without charge where it is
            e = c.factor.diagonal[i]
            store(x.jacobian, e, load(x.jacobian, e) + (1.0 - devices))
            store(x.residual, i, load(x.residual, i) * devices)


@compiled(forceinline=True)
def _residual(c: Wiring, x: Team) -> None:
    """Currents that leave each unknown node, A."""
    for i in range(c.unknowns):
        total = every(0.0)
        for p in range(c.charge.start[i], c.charge.start[i + 1]):
            total = total + load(x.charge, p) * load(x.rate, c.charge.column[p])
        for p in range(c.conductance.start[i], c.conductance.start[i + 1]):
            total = total + load(x.conductance, p) * load(x.v, c.conductance.column[p])
        for p in range(c.currents.start[i], c.currents.start[i + 1]):
            total = total + c.currents.sign[p] * load(x.current, c.currents.source[p])
        store(x.residual, i, total)


@compiled(forceinline=True)
def _jacobian(c: Wiring, x: Team, a: Lanes, devices: Lanes) -> None:
    """Entries of the Jacobian, S; a: of the charges, 1/s."""
    for e in range(c.charge_at.size):
        total = every(0.0)
        if c.charge_at[e] >= 0:
            total = a * load(x.charge, c.charge_at[e])
        if c.conductance_at[e] >= 0:
            total = total + devices * load(x.conductance, c.conductance_at[e])
        for p in range(c.slopes.start[e], c.slopes.start[e + 1]):
            total = total + c.slopes.sign[p] * load(x.device_slope, c.slopes.source[p])
        store(x.jacobian, e, total)


@compiled()
def pull(c: Wiring, x: Team) -> None:
    """Add the conductances that pull a rest state to where it is looked for."""
    g = load(x.control, ROW.pull)
    for i in range(c.unknowns):
        e = c.factor.diagonal[i]
        store(x.jacobian, e, load(x.jacobian, e) + g)
        store(x.residual, i, load(x.residual, i) + g * (load(x.v, i) - load(x.guess, i)))


@compiled()
def solve(c: Wiring, x: Team) -> None:
    """Factor the Jacobian in place, and put the solution in place of the residual."""
    f, a, b = c.factor, x.jacobian, x.residual
    n = f.diagonal.size
    for k in range(n):
        inverse = 1.0 / load(a, f.diagonal[k])
        store(a, f.diagonal[k], inverse)
        right = load(b, k)
        for p in range(f.lower_start[k], f.lower_start[k + 1]):
            factor = load(a, f.lower[p]) * inverse
            store(a, f.lower[p], factor)
            store(b, f.lower_row[p], load(b, f.lower_row[p]) - factor * right)
        for p in range(f.update_start[k], f.update_start[k + 1]):
            left = load(a, f.update[0, p]) - load(a, f.update[1, p]) * load(a, f.update[2, p])
            store(a, f.update[0, p], left)
    for k in range(n - 1, -1, -1):
        total = load(b, k)
        for p in range(f.upper_start[k], f.upper_start[k + 1]):
            total = total - load(a, f.upper[p]) * load(b, f.upper_column[p])
        store(b, k, total * load(a, f.diagonal[k]))


@compiled()
def update(c: Wiring, x: Team) -> None:
    """Take the update from the voltages, and keep its size and the step's error."""
    t = x.control
    timing, most = TIMING * load(t, ROW.inverse_step), load(t, ROW.largest_move)
    one, zero = every(1.0), every(0.0)
    largest, error, clamped, broken = zero, zero, zero, zero
    for i in range(c.unknowns):
        change = load(x.residual, i)
        size = magnitude(change)
        tame = size < most
        bounded = select(change >= 0.0, most, 0.0 - most)
        v = load(x.v, i) - select(tame, change, bounded)
        store(x.v, i, v)
        scale = larger(magnitude(v), one)
        largest = larger(largest, size / scale)
        clamped = larger(clamped, select(tame, zero, one))
        broken = larger(broken, select(size < _FINITE, zero, one))
        if c.dynamic[i]:
            moved = magnitude(v - load(x.v0, i))
            error = larger(error, magnitude(v - load(x.guess, i)) / (scale + timing * moved))
    store(t, ROW.update, select(clamped < 0.5, largest, every(_LARGE)))
    store(t, ROW.error, error)
    store(t, ROW.broken, broken)


@compiled()
def judge(c: Wiring, x: Team, rtol: float, most: float) -> tuple[int, int]:
    """End the steps that are over; lanes whose step was accepted, and those with something beside to do."""
    t = x.control
    one, zero = every(1.0), every(0.0)
    stepping = load(t, ROW.steps) >= 0.5
    iteration = load(t, ROW.iteration) + 1.0
    store(t, ROW.iteration, iteration)
    store(t, ROW.iterations, load(t, ROW.iterations) + select(stepping, one, zero))
    largest, target = load(t, ROW.update), SLACK * rtol
    converged = (largest < target) | (largest * largest < target * load(t, ROW.curvature))
    broken = load(t, ROW.broken) >= 0.5
    error = load(t, ROW.error) * load(t, ROW.share) * (1.0 / rtol)
    gave_up = stepping & (broken | (~converged & (iteration >= MAX_ITERATIONS)))
    ended = stepping & converged & ~broken
    accepted, rejected = ended & (error <= 1.0), gave_up | (ended & ~(error <= 1.0))
    safe = larger(smaller(error, every(1e6)), every(1e-9))
    power = select(load(t, ROW.points) < 1.5, 1.0 / root(safe), inverse_cube_root(safe))
    grow = smaller(every(2.0), larger(every(0.3), 0.85 * power))
    cut = select(gave_up, every(0.25), larger(every(0.2), 0.8 * power))
    step, next_step, at_bend = load(t, ROW.step), load(t, ROW.next_step), load(t, ROW.at_bend) >= 0.5
    next_step = select(accepted, select(at_bend, larger(next_step, step), step * grow), next_step)
    next_step = select(rejected, step * cut, next_step)
    store(t, ROW.next_step, next_step)
    store(t, ROW.begins, select(accepted | rejected, one, zero))
    store(t, ROW.accepted, select(accepted, one, zero))
    done = load(t, ROW.steps_done) + select(accepted, one, zero)
    refused = load(t, ROW.steps_rejected) + select(rejected, one, zero)
    store(t, ROW.steps_done, done)
    store(t, ROW.steps_rejected, refused)
    lost = (rejected & (next_step < SMALLEST_STEP)) | (done + refused >= most)
    special = (accepted & at_bend) | (stepping & lost)
    for j in range(c.watch.size):
        fired = (load(x.armed, j) >= 0.5) & (load(x.v, c.watch[j]) >= load(x.level, j))
        special = special | (accepted & fired)
    return bits(accepted), bits(special)


@compiled()
def accept(c: Wiring, x: Team) -> None:
    """Make the new point the last one in the lanes whose step was accepted, and arm detectors again."""
    t = x.control
    accepted = load(t, ROW.accepted) >= 0.5
    for i in range(c.columns):
        v, v0, v1 = load(x.v, i), load(x.v0, i), load(x.v1, i)
        store(x.v2, i, select(accepted, v1, load(x.v2, i)))
        store(x.v1, i, select(accepted, v0, v1))
        store(x.v0, i, select(accepted, v, v0))
    time0, time1, points = load(t, ROW.time0), load(t, ROW.time1), load(t, ROW.points)
    store(t, ROW.time2, select(accepted, time1, load(t, ROW.time2)))
    store(t, ROW.time1, select(accepted, time0, time1))
    store(t, ROW.time0, select(accepted, load(t, ROW.time_new), time0))
    store(t, ROW.points, select(accepted, smaller(points + 1.0, every(3.0)), points))
    watched = c.watch.size
    for j in range(watched):
        below = accepted & (load(x.v, c.watch[j]) < load(x.level, watched + j))
        store(x.armed, j, select(below, every(1.0), load(x.armed, j)))
        v, low, high = load(x.v, c.watch[j]), load(x.extent, j), load(x.extent, watched + j)
        store(x.extent, j, select(accepted, smaller(v, low), low))
        store(x.extent, watched + j, select(accepted, larger(v, high), high))
