"""Compiled ranging chip whose neurons are integrated only while an input can make them fire.

A neuron that rests, and is known to stay silent after a call alone and after an echo alone, may sleep. It
wakes for an echo that comes between `early` after the call and `settle` after the release. One at `early` is
surely without a spike, and the earlier one comes, the more has v_ex recovered at every later moment; after
`settle` v_mem is back at rest. A call puts the neuron to sleep again, because inhibition lasts longer than it
takes to forget what was before (`hold`). What it was when it wakes stands in states kept from the call alone.
All these spans are measured on this very die, by the equations of `chips.ranging.neuron_kernel`, to within
their tolerance of a step. Every other neuron stays awake.

A waking neuron is integrated once, up to its next spike or until it falls back to rest, and again only where
an input comes before that. What was seen to stay well below the threshold is not integrated again: an echo
still earlier before the release (`lead`), and what follows a spike with v_ex and v_r as high (`calm`).

A spike pulls v_mem to one voltage, so that what follows it depends on v_ex and v_r alone. Where they come
back to what they were, the way from one spike to the next is a patch of parabolas over both (`again`), made
by integration within a thousandth of the tolerance of a step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.ranging.law import Neurons
from chips.ranging.neuron_kernel import (
    COLUMNS,
    EARLY_STOP,
    ECHO_END,
    ECHO_START,
    MAY_STOP,
    NEAR,
    NOW,
    PEAK,
    PULLED_STEP,
    RELEASE,
    RESET_END,
    RUN_ON,
    SETTLED,
    STEP,
    STOPPED,
    TOLERANCE,
    UNDECIDED,
    V_EX,
    V_MEM,
    V_R,
    advance,
    advance_within,
    begin,
    call,
    copy_state,
    echo,
    excitation,
)
from chips.ranging.noise import Jitter, next_durations, no_jitter
from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from circuits.event import HALF_WIDTH

KEPT = 80  # states kept after the release
SPACING = 100e-6  # s, between them
WATCHED = 5e-3  # s, looked ahead of a neuron that may not sleep
LOOKED = 20e-3  # s after the release, looked ahead of a neuron that may
CALM = 4  # spikes remembered that no other came after
_STEEP = 100.0  # by more than what a peak moves where v_ex or v_r after the spike before it do (tested); ours
_BELOW = 2e-3  # V below the threshold, from where a peak is surely none: six times what steps move it; ours
AGAIN = 24  # patches remembered of what follows a spike; one that was made stays
_OFTEN = 30.0  # met so often a patch is made, which costs as much as some hundred looks; ours
AGAIN_X, AGAIN_R = 0.2e-3, 10e-3  # V, from the middle of a patch to its edge, of v_ex and v_r; ours
_AGAIN_STEPS = 1e-3 * TOLERANCE  # V, of a step by which it is made
_AGAIN_WITHIN = 50e-9  # s, to which it agrees with the integration between its points; ours
ROOM = 64  # echoes remembered; more than come in any `recover`
PULSE = HALF_WIDTH  # s, within which a second event merges into the first
_EARLIEST = 8e-3  # s before the release, from where `early` is looked for
_EARLY_WITHIN = 0.25e-3  # s, to which `early` is found
_AFTER = 1e-9  # s after the next input is known to come, when a neuron is looked at where none came; ours
_PIECES = 64  # of inhibition, in which `hold` is found

_compiled = compiled()

ASLEEP, QUIET, LOOKING, FIRING = range(4)
ECHOES, MERGED, DOUBTS = range(3)  # columns of `Chip.counts`
NEXT = 2  # column of `Chip.last`
_TOLD = 30  # columns of a patch: its middle, what it is, and of nine spikes the next one's time, v_ex and v_r
_MET, _MADE, _UNSURE = range(3)  # what a patch is: met, known, or one that never will be


class Plan(NamedTuple):
    """What is known beforehand of n neurons; times in s, voltages in V."""

    certain: Bools  # bool[n], that it may sleep
    hold: F64  # s after a call, when v_mem and v_r have settled
    early: F64  # s after a call, up to which an echo is surely too early
    settle: F64  # s after the release, when all is at rest again
    recover: F64  # s after an echo at rest, when all is at rest again
    rest: F64  # float64[n, COLUMNS], state at rest
    held: F64  # float64[n, COLUMNS], state under inhibition
    kept: F64  # float64[n, KEPT, COLUMNS], states after the release, at rest from the call to it


class Chip(NamedTuple):
    """State of a chip of n neurons; all of it is overwritten in place."""

    base: F64  # float64[n, COLUMNS], after the last input or spike
    ahead: F64  # float64[n, COLUMNS], at the next spike, or where nothing more will come
    due: F64  # float64[n], s, of the next spike, or of the next look
    phase: I64  # int64[n]: ASLEEP, QUIET, LOOKING or FIRING
    last: F64  # float64[3], s, of the last call and echo, and of the next input, where it is known, else past
    echoes: F64  # float64[ROOM, 2], time (s) and level (V) of the last echoes, round and round
    counts: I64  # int64[3]: echoes so far, merged inputs, spikes too near to call
    jitter: Jitter  # of inhibition: each call writes the neurons' t_inh anew, unless it is of none
    calm: F64  # float64[n, CALM, 3], V, v_ex and v_r after spikes that no other came after, and their leeway
    lead: F64  # float64[n], s, from an echo that stayed silent to the release, least so far
    again: F64  # float64[n, AGAIN, _TOLD + COLUMNS], from spike to spike; working space


def new_plan(neurons: Neurons) -> Plan:
    """Work out the plan of neurons."""
    n = neurons.t_inh.size
    hold, early, settle, recover = np.zeros((4, n))
    rest, held = np.zeros((2, n, COLUMNS))
    kept = np.zeros((n, KEPT, COLUMNS))
    plan = Plan(np.zeros(n, dtype=np.bool_), hold, early, settle, recover, rest, held, kept)
    prepare(neurons, plan, np.zeros(COLUMNS))
    return plan


def new_chip(neurons: Neurons, plan: Plan, time: float = 0.0, jitter: Jitter | None = None) -> Chip:
    """Return a chip with all neurons at rest at `time` s.

    jitter: with it the neurons' t_inh are written anew at every call.
    """
    n = neurons.t_inh.size
    chip = Chip(
        plan.rest.copy(), plan.rest.copy(), np.full(n, np.inf), np.zeros(n, np.int64), np.full(3, -np.inf),
        np.full((ROOM, 2), -np.inf), np.zeros(3, np.int64), no_jitter() if jitter is None else jitter,
        np.zeros((n, CALM, 3)), np.zeros(n), np.zeros((n, AGAIN, _TOLD + COLUMNS)),
    )  # fmt: skip
    forget_seen(chip)
    start(neurons, plan, chip, time)
    return chip


def forget_seen(chip: Chip) -> None:
    """Take nothing to be known of what stayed silent, and of what followed a spike, so far."""
    chip.calm[:], chip.lead[:], chip.again[:] = (np.inf, np.inf, 0.0), np.inf, np.inf


@_compiled
def _differ(m: Neurons, k: int, a: F64, b: F64) -> bool:
    """Whether two states are apart by more than a step's error, v_ex by what it does to v_mem."""
    apart = max(abs(a[V_MEM] - b[V_MEM]), abs(a[V_R] - b[V_R]))
    return bool(apart > TOLERANCE or abs(excitation(m, k, a) - excitation(m, k, b)) > SETTLED)


@_compiled
def prepare(m: Neurons, p: Plan, s: F64) -> None:
    """Fill the plan; s: working space, float64[COLUMNS]."""
    for k in range(p.certain.size):
        above = begin(m, k, p.rest[k], 0.0)
        p.certain[k] = above < -m.margin[k] and _inhibited(m, k, p, s) and _released(m, k, p, s)
        p.certain[k] = p.certain[k] and _excited(m, k, p, s) and _too_early(m, k, p, s)


@_compiled
def _silent(m: Neurons, k: int, s: F64, until: float) -> bool:
    """Advance to `until` (s); whether surely no spike came."""
    spike = advance(m, k, s, until)
    return bool(spike == np.inf and s[UNDECIDED] == 0.0 and s[NEAR] == 0.0)


@_compiled
def _inhibited(m: Neurons, k: int, p: Plan, s: F64) -> bool:
    """Find the state under inhibition, and when it is reached; False where it never is."""
    last = m.t_inh[k] * (1.0 - 1e-6)
    copy_state(p.rest[k], p.held[k])
    call(m, k, p.held[k])
    if not _silent(m, k, p.held[k], last):
        return False
    copy_state(p.rest[k], s)
    call(m, k, s)
    p.hold[k] = 0.0
    for j in range(1, _PIECES):
        advance(m, k, s, last * j / _PIECES)
        if _differ(m, k, s, p.held[k]):
            p.hold[k] = last * (j + 1) / _PIECES
    return bool(p.hold[k] < last)


@_compiled
def _released(m: Neurons, k: int, p: Plan, s: F64) -> bool:
    """Keep states after the release, and find when it rests; False where it never does or may fire."""
    copy_state(p.held[k], s)
    advance(m, k, s, m.t_inh[k])
    p.settle[k] = 0.0
    for j in range(KEPT):
        if not _silent(m, k, s, m.t_inh[k] + j * SPACING):
            return False
        copy_state(s, p.kept[k, j])
        if _differ(m, k, s, p.rest[k]):
            p.settle[k] = (j + 1) * SPACING
    return bool(p.settle[k] < (KEPT - 1) * SPACING)


@_compiled
def _excited(m: Neurons, k: int, p: Plan, s: F64) -> bool:
    """Find when an echo at rest is forgotten; False where it never is, or may fire."""
    copy_state(p.rest[k], s)
    echo(m, k, s, m.v_ex_max[k])
    p.recover[k] = 0.0
    for j in range(1, KEPT):
        if not _silent(m, k, s, j * SPACING):
            return False
        if _differ(m, k, s, p.rest[k]):
            p.recover[k] = (j + 1) * SPACING
    return bool(p.recover[k] < (KEPT - 1) * SPACING)


@_compiled
def _too_early(m: Neurons, k: int, p: Plan, s: F64) -> bool:
    """Bisect the delay up to which an echo is surely too early; False where there is none."""
    late = m.t_inh[k]
    early = max(late - _EARLIEST, 0.0)
    if not _silent_after(m, k, p, s, early):
        return False
    while late - early > _EARLY_WITHIN:
        middle = 0.5 * (early + late)
        if _silent_after(m, k, p, s, middle):
            early = middle
        else:
            late = middle
    p.early[k] = early
    return True


@_compiled
def _silent_after(m: Neurons, k: int, p: Plan, s: F64, delay: float) -> bool:
    """Whether an echo during inhibition, `delay` s after a call at 0, surely makes no spike."""
    if delay >= p.hold[k]:
        copy_state(p.held[k], s)
        s[NOW] = delay
    else:
        copy_state(p.rest[k], s)
        call(m, k, s)
        advance(m, k, s, delay)
    s[EARLY_STOP] = MAY_STOP
    echo(m, k, s, m.v_ex_max[k])
    return _silent(m, k, s, m.t_inh[k] + KEPT * SPACING)


@_compiled
def start(m: Neurons, p: Plan, c: Chip, time: float) -> None:
    """Put all neurons to rest at `time` s; those that may not sleep are watched."""
    for k in range(c.due.size):
        begin(m, k, c.base[k], time)
        c.phase[k], c.due[k] = ASLEEP, np.inf
        if not p.certain[k]:
            _look(m, p, c, k)


@_compiled
def _look(m: Neurons, p: Plan, c: Chip, k: int) -> None:
    """Integrate from `base` to the next spike, or until it is known that none comes."""
    s = c.ahead[k]
    copy_state(c.base[k], s)
    x, r, spiked = np.inf, np.inf, p.certain[k] and _just_spiked(s)
    x_then, r_then, sure = s[V_EX], s[V_R], s[UNDECIDED]
    if spiked and _goes_on(m, c, k, s):
        c.phase[k], c.due[k] = FIRING, s[NOW]
        return
    if spiked:
        s[EARLY_STOP] = RUN_ON
        advance(m, k, s, s[RESET_END])
        x, r = s[V_EX], s[V_R]
        if _seen(c, k, x, r):
            c.phase[k], c.due[k] = QUIET, np.inf
            return
    s[EARLY_STOP] = MAY_STOP if p.certain[k] else RUN_ON
    s[PEAK] = -np.inf
    until = max(s[NOW], s[RELEASE]) + LOOKED
    if not p.certain[k]:  # not beyond the release, before which an echo may come, nor far beyond it
        until = s[RELEASE] if s[NOW] < s[RELEASE] else s[NOW] + WATCHED
    cut = s[NOW] < c.last[NEXT] < until
    if cut:
        until = c.last[NEXT]
    spike = advance(m, k, s, until)
    if spike < np.inf:
        c.phase[k], c.due[k] = FIRING, spike
        _meet(m, p, c, k, x_then, r_then if spiked and s[UNDECIDED] == sure else np.inf)
    elif cut and s[EARLY_STOP] != STOPPED:
        c.phase[k], c.due[k] = LOOKING, until + _AFTER
    elif p.certain[k]:
        c.phase[k], c.due[k] = QUIET, np.inf
        below = _calm(m, c, k)
        if spiked and below > 0.0:
            _remember(c, k, x, r, below / _STEEP)
    else:
        c.phase[k], c.due[k] = LOOKING, until


@_compiled
def _just_spiked(s: F64) -> bool:
    """Whether a state is that of a spike, with no input at work."""
    return bool(s[RESET_END] > s[NOW] and s[RELEASE] <= s[NOW] and s[ECHO_END] <= s[NOW])


@_compiled
def _patch_at(c: Chip, k: int, x: float, r: float) -> int:
    """Which patch a spike lies in that leaves v_ex and v_r so, AGAIN where none."""
    i = 0
    while i < AGAIN and not (
        abs(x - c.again[k, i, 0]) <= AGAIN_X and abs(r - c.again[k, i, 1]) <= AGAIN_R
    ):  # fmt: skip
        i += 1
    return i


@_compiled
def _goes_on(m: Neurons, c: Chip, k: int, s: F64) -> bool:
    """Bring a state just after a spike to the next; False where no patch tells it, or an input is first."""
    i = _patch_at(c, k, s[V_EX], s[V_R])
    if i == AGAIN or c.again[k, i, 2] != _MADE or s[RESET_END] - s[NOW] < m.pulse_width[k] - _AFTER:
        return False
    q = c.again[k, i]
    x, r = (s[V_EX] - q[0]) / AGAIN_X, (s[V_R] - q[1]) / AGAIN_R
    time, x_next, r_next = _told(q, 3, x, r), _told(q, 4, x, r), _told(q, 5, x, r)
    spike = s[NOW] + time
    if s[NOW] < c.last[NEXT] <= spike:
        return False
    s[V_EX], s[V_R], s[NOW], s[RESET_END] = x_next, r_next, spike, spike + m.pulse_width[k]
    return True


@_compiled
def _told(q: F64, column: int, x: float, r: float) -> float:
    """What a patch tells, by parabolas through nine points; x and r from -1 to 1."""
    a, b, c = 0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)
    low = a * q[column] + b * q[column + 9] + c * q[column + 18]
    middle = a * q[column + 3] + b * q[column + 12] + c * q[column + 21]
    high = a * q[column + 6] + b * q[column + 15] + c * q[column + 24]
    return float(0.5 * r * (r - 1.0) * low + (1.0 - r * r) * middle + 0.5 * r * (r + 1.0) * high)


@_compiled
def _meet(m: Neurons, p: Plan, c: Chip, k: int, x: float, r: float) -> None:
    """Remember a spike that another surely follows (r finite), and make its patch when it is met often."""
    i = _patch_at(c, k, x, r)
    if r == np.inf:
        return
    if i < AGAIN:
        if c.again[k, i, 2] == _MET:
            c.again[k, i, 3] += 1.0
            if c.again[k, i, 3] >= _OFTEN:
                _make(m, p, k, c.again[k, i])
        return
    for i in range(AGAIN - 1, -1, -1):  # in place of the last that was not made, before the others
        if c.again[k, i, 2] != _MADE and c.again[k, i, 2] != _UNSURE:
            for j in range(i, 0, -1):
                for column in range(_TOLD):
                    c.again[k, j, column] = c.again[k, j - 1, column]
            c.again[k, 0, 0], c.again[k, 0, 1], c.again[k, 0, 2], c.again[k, 0, 3] = x, r, _MET, 1.0
            return


@_compiled
def _make(m: Neurons, p: Plan, k: int, q: F64) -> None:
    """Integrate from nine spikes of a patch to what follows them."""
    s = q[_TOLD:]
    q[2] = _UNSURE
    for i in range(9):
        spike = _follows(m, p, k, s, q[0] + (i // 3 - 1) * AGAIN_X, q[1] + (i % 3 - 1) * AGAIN_R)
        if spike == np.inf:
            return
        q[3 + 3 * i], q[4 + 3 * i], q[5 + 3 * i] = spike, s[V_EX], s[V_R]
    spike = _follows(m, p, k, s, q[0] + 0.5 * AGAIN_X, q[1] + 0.5 * AGAIN_R)
    if abs(spike - _told(q, 3, 0.5, 0.5)) < _AGAIN_WITHIN:
        q[2] = _MADE


@_compiled
def _follows(m: Neurons, p: Plan, k: int, s: F64, x: float, r: float) -> float:
    """Integrate from a spike at 0 to the next one; its time, s, inf where none surely comes."""
    copy_state(p.rest[k], s)
    s[V_MEM], s[V_EX], s[V_R] = m.v_held[k], x, r
    s[NOW], s[STEP], s[RESET_END], s[EARLY_STOP] = 0.0, PULLED_STEP, m.pulse_width[k], MAY_STOP
    spike = advance_within(m, k, s, LOOKED, _AGAIN_STEPS)
    return float(spike) if s[UNDECIDED] == 0.0 and s[NEAR] == 0.0 else np.inf


@_compiled
def _seen(c: Chip, k: int, x: float, r: float) -> bool:
    """Whether no other spike came where, but for the leeway, less held v_mem back than v_ex and v_r do."""
    seen = False
    for i in range(CALM):
        leeway = c.calm[k, i, 2]
        seen = seen or (x >= c.calm[k, i, 0] - leeway and r >= c.calm[k, i, 1] - leeway)
    return bool(seen)


@_compiled
def _remember(c: Chip, k: int, x: float, r: float, leeway: float) -> None:
    """Put a spike that no other came after first, in place of one that it tells more than, or of the last."""
    i = 0
    while i < CALM - 1 and not (x <= c.calm[k, i, 0] and r <= c.calm[k, i, 1]):
        i += 1
    while i > 0:
        for j in range(3):
            c.calm[k, i, j] = c.calm[k, i - 1, j]
        i -= 1
    c.calm[k, 0, 0], c.calm[k, 0, 1], c.calm[k, 0, 2] = x, r, leeway


@_compiled
def _calm(m: Neurons, c: Chip, k: int) -> float:
    """How surely a neuron that was looked at stayed below its threshold, V; not where that is not above 0."""
    s, sure = c.ahead[k], c.ahead[k, NEAR] == 0.0 and c.ahead[k, UNDECIDED] == c.base[k, UNDECIDED]
    return float(m.v_threshold[k] - _BELOW - s[PEAK]) if sure else 0.0


@_compiled
def next_due(c: Chip) -> tuple[float, int]:
    """Return the time (s, inf for none) and the number of the neuron that spikes, or is looked at, next."""
    which = 0
    for k in range(1, c.due.size):
        if c.due[k] < c.due[which]:
            which = k
    return c.due[which], which


@_compiled
def take(m: Neurons, p: Plan, c: Chip, k: int) -> bool:
    """Go on beyond a neuron's due time, and return whether that was a spike."""
    fired = bool(c.phase[k] == FIRING)
    copy_state(c.ahead[k], c.base[k])
    _look(m, p, c, k)
    return fired


@_compiled
def _roll(m: Neurons, c: Chip, k: int, time: float) -> None:
    """Bring `base` of a neuron that is awake to `time` s."""
    s = c.ahead[k]
    if c.phase[k] != FIRING and s[NOW] <= time:
        copy_state(s, c.base[k])
    c.base[k, EARLY_STOP] = RUN_ON
    advance(m, k, c.base[k], time)


@_compiled
def _wake(m: Neurons, p: Plan, c: Chip, k: int, time: float) -> None:
    """Put into `base` what a sleeping neuron is at `time` s; older echoes than those told are forgotten."""
    s = c.base[k]
    since, release = c.last[0], c.last[0] + m.t_inh[k]
    if time >= release + p.settle[k]:
        copy_state(p.rest[k], s)
        s[NOW] = time
        return
    if time >= release:
        j = int((time - release) / SPACING)
        copy_state(p.kept[k, j], s)
        s[NOW] = release + j * SPACING
    elif time >= since + p.hold[k]:
        copy_state(p.held[k], s)
        s[NOW] = time
    else:
        copy_state(p.rest[k], s)
        s[NOW] = since
        call(m, k, s)
    s[RELEASE] = release
    s[RESET_END] = -np.inf
    s[ECHO_START], s[ECHO_END] = np.inf, -np.inf
    advance(m, k, s, time)


@_compiled
def _sleep(m: Neurons, c: Chip, k: int, time: float) -> None:
    """Put a neuron to sleep at `time` s, and count what was too near to call before."""
    if c.phase[k] != ASLEEP:
        if c.ahead[k, NOW] > time:
            _roll(m, c, k, time)
            copy_state(c.base[k], c.ahead[k])
        c.counts[DOUBTS] += int(c.ahead[k, UNDECIDED] + c.ahead[k, NEAR])
    c.phase[k], c.due[k] = ASLEEP, np.inf


@_compiled
def on_call(m: Neurons, p: Plan, c: Chip, time: float) -> None:
    """Take a call at `time` s, which is not before the last input nor beyond the next spike."""
    if time <= c.last[0] + PULSE:
        c.counts[MERGED] += 1
        return
    next_durations(c.jitter, time, m.t_inh)
    for k in range(c.due.size):
        if p.certain[k]:
            _sleep(m, c, k, time)
            continue
        _roll(m, c, k, time)
        call(m, k, c.base[k])
        _look(m, p, c, k)
    c.last[0] = time


@_compiled
def _replay(m: Neurons, p: Plan, c: Chip, k: int, time: float) -> None:
    """Wake a neuron at the last echo, which it slept through, and bring it to `time` s."""
    i = (c.counts[ECHOES] - 1) % ROOM
    s, before = c.base[k], c.echoes[i, 0]
    if before >= c.last[0]:
        _wake(m, p, c, k, before)
    else:
        copy_state(p.rest[k], s)
        s[NOW] = before
    echo(m, k, s, _own(m, k, c.echoes[i, 1]))
    if before < c.last[0]:
        advance(m, k, s, c.last[0])
        call(m, k, s)
    advance(m, k, s, time)


@_compiled
def on_echo(m: Neurons, p: Plan, c: Chip, time: float, level: float) -> None:
    """Take an echo at `time` s, which is not before the last input nor beyond the next spike.

    level: of v_ex_max, V, NaN for the neurons' own.
    """
    if time <= c.last[1] + PULSE:
        c.counts[MERGED] += 1
        return
    for k in range(c.due.size):
        if _does_not_matter(m, p, c, k, time, _own(m, k, level)):
            continue
        if c.phase[k] != ASLEEP:
            _roll(m, c, k, time)
        elif _still_excited(m, p, c, k, time):
            _replay(m, p, c, k, time)
        else:
            _wake(m, p, c, k, time)
        lead = c.last[0] + m.t_inh[k] - time
        inhibited = c.phase[k] == ASLEEP and lead > 0.0 and time >= c.last[0] + p.hold[k]
        inhibited = inhibited and _own(m, k, level) <= m.v_ex_max[k] + TOLERANCE
        echo(m, k, c.base[k], _own(m, k, level))
        _look(m, p, c, k)
        if inhibited and lead < c.lead[k] and c.phase[k] == QUIET and _calm(m, c, k) > 0.0:
            c.lead[k] = lead
    i = c.counts[ECHOES] % ROOM
    c.echoes[i, 0], c.echoes[i, 1] = time, level
    c.counts[ECHOES] += 1
    c.last[1] = time


@_compiled
def _still_excited(m: Neurons, p: Plan, c: Chip, k: int, time: float) -> bool:
    """Whether the last echo, slept through, matters to a neuron that is free at `time` s."""
    last = c.echoes[(c.counts[ECHOES] - 1) % ROOM, 1]
    if _excites_nothing(m, p, k, _own(m, k, last)):
        return False
    release = c.last[0] + m.t_inh[k]
    over = release if time <= release + p.settle[k] else time
    return bool(time > release and c.last[1] + p.recover[k] > over)


@_compiled
def _excites_nothing(m: Neurons, p: Plan, k: int, level: float) -> bool:
    """Whether an echo leaves v_ex no lower than it is at rest."""
    return bool(level >= p.rest[k, V_EX] - TOLERANCE and m.echo_step[k] >= -TOLERANCE)


@_compiled
def _own(m: Neurons, k: int, level: float) -> float:
    own: float = m.v_ex_max[k] if np.isnan(level) else level
    return own


@_compiled
def _does_not_matter(m: Neurons, p: Plan, c: Chip, k: int, time: float, level: float) -> bool:
    """Whether an echo cannot bring a neuron nearer to a spike, or take one from it."""
    if c.phase[k] == LOOKING or c.phase[k] == FIRING:
        return False
    if _excites_nothing(m, p, k, level):
        return True
    if c.phase[k] == QUIET or level < m.v_ex_max[k] - TOLERANCE:
        return False  # awake, or more than what was tried
    since = time - c.last[0]
    if since < m.t_inh[k]:
        seen = since >= p.hold[k] and m.t_inh[k] - since >= c.lead[k]
        return bool(since <= p.early[k] or seen)
    return bool(since > m.t_inh[k] + p.settle[k] and c.last[1] + p.recover[k] <= time)


def doubts(chip: Chip) -> int:
    """Return at how many moments so far a spike was too near to call."""
    awake = chip.phase != ASLEEP
    return int(chip.counts[DOUBTS] + chip.ahead[awake, UNDECIDED].sum() + chip.ahead[awake, NEAR].sum())
