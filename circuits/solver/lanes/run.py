"""Many runs of one circuit in lanes: a lane whose run is over takes the next.

What most lanes do in a pass is done in all at once (`circuits.solver.lanes.step`); what few do, a spike, a
breakpoint, a rest state that is found, the next run, is done lane by lane. A run's numbers depend on its own
alone: which lane it has, what stands beside it and when the others end changes no bit of it.
"""

from __future__ import annotations

import math

from circuits.compiled import compiled
from circuits.solver.integrate import SAME_TIME, crossing_of
from circuits.solver.lanes.law import device_currents
from circuits.solver.lanes.layout import (
    CHECKING,
    DONE,
    FAILED,
    IDLE,
    RESTARTING,
    RESTING,
    ROW,
    RUNNING,
    STEPPING,
    TERM,
    Found,
    Jobs,
    Team,
    Wiring,
)
from circuits.solver.lanes.resting import keep_rest, look_for_rest, rest_on
from circuits.solver.lanes.step import accept, assemble, begin, judge, pull, solve, update

FINISHED, FULL = range(2)


@compiled()
def run(c: Wiring, jobs: Jobs, x: Team, found: Found) -> int:
    """Do what the queue has; `FULL` where what was recorded must be taken before it can go on."""
    width, watched = x.doing.size, c.watch.size
    working = _fill(c, jobs, x, found)
    while working:
        if not _has_room(c, jobs, x, found):
            return FULL
        begin(c, x)
        device_currents(c, x)
        assemble(c, x)
        if jobs.resting:
            for lane in range(width):
                if x.doing[lane] == CHECKING:
                    keep_rest(x, found, lane)
            pull(c, x)
        solve(c, x)
        update(c, x)
        accepted, special = judge(c, x, jobs.rtol, jobs.most)
        if accepted & special != 0 and watched > 0:
            _spikes(c, x, found, accepted & special)
        if accepted != 0:
            accept(c, x)
            _record(c, jobs, x, found, accepted)
        other = False
        for lane in range(width):
            other = other or not (x.doing[lane] == STEPPING or x.doing[lane] == IDLE)
        if special != 0 or other:
            _turn_over(c, jobs, x, found, special)
            working = _fill(c, jobs, x, found)
    return FINISHED


@compiled()
def _has_room(c: Wiring, jobs: Jobs, x: Team, found: Found) -> bool:
    """Whether what all lanes may record in a pass has a place."""
    width = x.doing.size
    if jobs.resting:
        return True
    if jobs.recording and found.filled.size - found.used[0] < width:
        return False
    return bool(found.spike_time.size - found.used[1] >= width * c.watch.size)


@compiled()
def _turn_over(c: Wiring, jobs: Jobs, x: Team, found: Found, special: int) -> None:
    """What lanes do behind a pass that have more to do than to go on stepping.

    special: bits of the lanes whose step ended in another way than most.
    """
    for lane in range(x.doing.size):
        if special & (1 << lane):
            _turn(c, jobs, x, found, lane)
        else:
            _go_on(c, jobs, x, found, lane)


@compiled()
def _fill(c: Wiring, jobs: Jobs, x: Team, found: Found) -> bool:
    """Give idle lanes what is next in the queue; whether any lane has something to do then."""
    working = False
    for lane in range(x.doing.size):
        if x.doing[lane] == IDLE:
            _next(c, jobs, x, found, lane)
        working = working or x.doing[lane] != IDLE
    return working


@compiled()
def _next(c: Wiring, jobs: Jobs, x: Team, found: Found, lane: int) -> None:
    """Give a lane its next run; without one it goes on with numbers that are harmless."""
    for row in range(len(ROW)):
        x.control[row, lane] = 0.0
    x.control[ROW.a, lane] = x.control[ROW.inverse_step, lane] = x.control[ROW.step, lane] = 1.0
    x.control[ROW.points, lane] = 1.0
    x.block[lane] = -1
    job = take(x)
    if job >= x.queue[1]:
        x.doing[lane], x.job[lane] = IDLE, -1
        return
    x.job[lane] = job
    found.state[job] = RUNNING
    _take_numbers(c, jobs, x, lane)
    if jobs.resting:
        look_for_rest(x, lane)
        return
    for j in range(c.watch.size):
        v = x.v[c.watch[j], lane]
        for side in range(2):
            x.level[side * c.watch.size + j, lane] = jobs.level[job, side, j]
            x.extent[side * c.watch.size + j, lane] = v
        x.armed[j, lane] = 1.0 if v < jobs.level[job, 0, j] else 0.0
    for q in range(c.moving.size):
        x.cursor[q, lane] = jobs.line_start[jobs.line[job], c.moving[q]]
    _restart(c, jobs, x, lane)


@compiled()
def take(x: Team) -> int:
    """The next run of the queue, which may be behind the last one."""
    job = x.queue[0]
    x.queue[0] = job + 1
    return int(job)


@compiled()
def _take_numbers(c: Wiring, jobs: Jobs, x: Team, lane: int) -> None:
    """Put the numbers of a lane's run where its passes look for them, and its voltages where it begins."""
    job, n = x.job[lane], c.polarity.size
    for row in range(len(TERM)):
        for i in range(n):
            x.coefficient[row * n + i, lane] = jobs.coefficient[job, row, i]
    for p in range(c.charge.column.size):
        x.charge[p, lane] = jobs.charge[job, p]
    for p in range(c.conductance.column.size):
        x.conductance[p, lane] = jobs.conductance[job, p]
    for i in range(c.columns):
        v = jobs.start[job, i]
        x.v[i, lane] = x.v0[i, lane] = x.v1[i, lane] = x.v2[i, lane] = x.guess[i, lane] = v
        x.slope[i, lane] = x.extra[i, lane] = 0.0
    x.control[ROW.curvature, lane] = jobs.curvature[job]


@compiled()
def _restart(c: Wiring, jobs: Jobs, x: Team, lane: int) -> None:
    """Ask for the derivative just behind the breakpoint where a lane stands; its sources' next segments."""
    t, job = x.control, x.job[lane]
    now = t[ROW.time0, lane]
    t[ROW.a, lane], t[ROW.b0, lane], t[ROW.b1, lane], t[ROW.devices, lane] = 1.0, -1.0, 0.0, 0.0
    t[ROW.largest_move, lane], t[ROW.begins, lane], t[ROW.iteration, lane], t[ROW.began, lane] = (
        0.0,
        0.0,
        0.0,
        now,
    )
    t[ROW.steps, lane] = 0.0
    nearest = jobs.stop
    for q in range(c.moving.size):
        source = c.moving[q]
        first, end = jobs.line_start[jobs.line[job], source], jobs.line_start[jobs.line[job], source + 1]
        k = x.cursor[q, lane]  # the first vertex behind now
        while k < end and jobs.line_time[k] <= now + SAME_TIME:
            k += 1
        x.cursor[q, lane] = k
        slope = 0.0
        value = jobs.line_value[max(k - 1, first)]
        if first < k < end:
            slope = (jobs.line_value[k] - value) / (jobs.line_time[k] - jobs.line_time[k - 1])
            if now > jobs.line_time[k - 1] + SAME_TIME:
                value += (now - jobs.line_time[k - 1]) * slope
        i = c.unknowns + source
        x.base[q, lane], x.drift[q, lane], x.extra[i, lane] = value, slope, slope
        x.v[i, lane] = x.v0[i, lane] = value
        if k < end:
            nearest = min(nearest, jobs.line_time[k])
    t[ROW.bend, lane] = nearest
    x.doing[lane] = RESTARTING


@compiled()
def _turn(c: Wiring, jobs: Jobs, x: Team, found: Found, lane: int) -> None:
    """What a lane does whose step was special: it ends, fails, restarts at a breakpoint, or goes on."""
    t = x.control
    steps = t[ROW.steps_done, lane] + t[ROW.steps_rejected, lane]
    if t[ROW.accepted, lane] < 0.5 or steps >= jobs.most:
        _end(c, x, found, lane, FAILED)
    elif t[ROW.at_bend, lane] >= 0.5:
        if jobs.stop - t[ROW.time0, lane] <= SAME_TIME:
            _end(c, x, found, lane, DONE)
        else:
            _restart(c, jobs, x, lane)


@compiled()
def _go_on(c: Wiring, jobs: Jobs, x: Team, found: Found, lane: int) -> None:
    """What a lane does that is not stepping: it begins its steps, or its rest state is looked at."""
    t, doing = x.control, x.doing[lane]
    if doing == RESTARTING:
        fastest = 1.0
        for i in range(c.unknowns):
            x.slope[i, lane] = -x.residual[i, lane]
            fastest = max(fastest, abs(x.slope[i, lane]))
        for i in range(c.unknowns, c.columns):
            x.extra[i, lane] = 0.0
        t[ROW.points, lane], t[ROW.begins, lane] = 1.0, 1.0
        t[ROW.next_step, lane] = 0.5 * math.sqrt(jobs.rtol) / fastest
        x.doing[lane] = STEPPING if math.isfinite(fastest) else IDLE
        if x.doing[lane] == IDLE:
            _end(c, x, found, lane, FAILED)
    elif doing == CHECKING:
        _end(c, x, found, lane, DONE)
    elif doing == RESTING:
        state = rest_on(c, x, lane)
        if state != RUNNING:
            _end(c, x, found, lane, state)


@compiled()
def _end(c: Wiring, x: Team, found: Found, lane: int, state: int) -> None:
    job = x.job[lane]
    found.state[job] = state
    found.steps[job, 0], found.steps[job, 1] = (
        x.control[ROW.steps_done, lane],
        x.control[ROW.steps_rejected, lane],
    )
    found.steps[job, 2] = x.control[ROW.iterations, lane]
    for side in range(2):
        for j in range(c.watch.size):
            found.extent[job, side, j] = x.extent[side * c.watch.size + j, lane]
    x.doing[lane] = IDLE


@compiled()
def _record(c: Wiring, jobs: Jobs, x: Team, found: Found, accepted: int) -> None:
    """Write the last point of each lane that has a new one into its block, or into a new block."""
    for lane in range(x.doing.size if jobs.recording else 0):
        if accepted & (1 << lane):
            block = x.block[lane]
            if block < 0 or found.filled[block] == found.point.shape[1]:
                block = x.block[lane] = found.used[0]
                found.used[0] += 1
                found.filled[block], found.owner[block] = 0, x.job[lane]
            p = found.filled[block]
            found.point[block, p, 0] = x.control[ROW.time0, lane]
            for j in range(c.recorded.size):
                found.point[block, p, 1 + j] = x.v0[c.recorded[j], lane]
            found.filled[block] = p + 1


@compiled()
def _spikes(c: Wiring, x: Team, found: Found, some: int) -> None:
    """Write down what has risen through its threshold in steps that are accepted; some: bits of the lanes."""
    for lane in range(x.doing.size):
        for j in range(c.watch.size):
            armed = some & (1 << lane) and x.armed[j, lane] >= 0.5
            if armed and x.v[c.watch[j], lane] >= x.level[j, lane]:
                p = found.used[1]
                found.spike_time[p] = _crossing(x, lane, c.watch[j], x.level[j, lane])
                found.spike_index[p], found.spike_job[p] = j, x.job[lane]
                found.used[1] = p + 1
                x.armed[j, lane] = 0.0


@compiled()
def _crossing(x: Team, lane: int, column: int, threshold: float) -> float:
    """Time at which the parabola through a lane's last points rises through the threshold, s."""
    t = x.control
    begin, y0, y1 = t[ROW.time0, lane], x.v0[column, lane] - threshold, x.v[column, lane] - threshold
    step = t[ROW.time_new, lane] - begin
    slope = (y1 - y0) / step
    bend = 0.0
    if t[ROW.points, lane] > 1.5:
        before = begin - t[ROW.time1, lane]
        bend = (slope - (x.v0[column, lane] - x.v1[column, lane]) / before) / (step + before)
    return crossing_of(begin, step, y0, slope, bend)
