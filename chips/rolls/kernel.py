"""Compiled steps of a whole ROLLS chip: its neurons, their filters, and the synapses between them.

Time goes in steps. What was on the bus in the last step enters the filters at the beginning of this one, so
an event waits for a step at most. A filter is one equation: u is the ratio that the pair's currents I_1 and
I_2 would have in weak inversion, v the one that they have, `z = int (1 + v + c / (1 + v)) d ln u`:

    charge Q through the line:  z += kappa_n Q / (C U_T)
    leak:                       v -> v e^(-dt / tau),  z -= (dt / tau + v (1 - e^(-dt / tau))) (1 - r)
    output:                     I = I_S ln^2(1 + sqrt(E)),  E ~ u^(kappa_p / kappa_n)

r = e^(-(v_dd - v_syn) / U_T), the leak being a transistor that ends at v_dd, is taken as (E_0 / E)^(3/2), E_0
at v_dd: the exponent is 1 / kappa_p, 1.3 to 1.6. c is what the line's capacitance adds while the line follows
v_syn (`chips.rolls.lumped`). Between pulses the line rises by the pair's current, by `C_line U_T ln t`; what
it has taken then, the next pulse has to draw from it first. The output is the mean over the step. The
membrane is stepped in the charge y that a weak-inversion input would have needed to bring it where it is,
`dy = C dv / share(v)`, in which every input adds up and the leak is linear:

    dy/dt = a(y) + J (1 + w(y) G(J)) - (I_inh + I_ahp) b(y)

a, w and b are lines, 16 an octave of zeta = 1 + y / Q_0. A step is the exact solution on the
line of its beginning. Where a alone exceeds all input the neuron will spike, after the time T that is left,
with T_0 = int Q_0 / a dzeta and T_1 = int Q_0 / a^2 dzeta to the top, T = T_0 / (1 + J T_1 / T_0): exact for
a constant a, and what comes in meanwhile no longer counts. All is done in float32 but what adds up.
"""

from __future__ import annotations

import math

import numpy as np

from chips.rolls.depression.kernel import deliver_depressed
from chips.rolls.depression.layout import Depressing
from chips.rolls.layout import (
    BASE,
    BENT,
    C24,
    DELAY,
    DONE,
    DRAWN,
    FIRES,
    FREED,
    HALF,
    HELD,
    INVERSE,
    KICK,
    LAST,
    NEVER,
    ONE,
    OWN,
    OWN_SLOPE,
    READ,
    REFRACTORY,
    RISES,
    SHIFT,
    SHUT,
    SIXTH,
    STATIC,
    STEEP,
    STRONGEST,
    TOP,
    TWO,
    V_AHP,
    VIRTUAL,
    WAIT,
    WRITTEN,
    ZERO,
    ZETA,
    ChipRun,
    ChipTables,
    Membranes,
    Scratch,
    Traffic,
    step_compiled,
    step_inlined,
)
from chips.rolls.noise.kernel import disturb_filters, disturb_membranes, disturb_plastic
from chips.rolls.noise.layout import NoiseTables
from chips.rolls.plastic.kernel import deliver_plastic, step_plastic
from chips.rolls.plastic.layout import Plastic
from chips.rolls.synapse.step import step_filters
from circuits.arrays import F32, F64, I64


@step_inlined
def _strong(current: np.float32, strong: np.float32) -> np.float32:
    """G(J): by how much more of J the pair lets into a membrane far above v_thr, for strong inversion."""
    t = math.sqrt(current * strong)
    r = t * (HALF + t * (SIXTH + t * C24))
    return r * (TWO + r)


@step_inlined
def _rates(m: Membranes, zeta: F64, bits: I64, s: Scratch) -> None:
    """dzeta/dt and its slope, 1/s, and the membrane's own part, A, at the step's beginning."""
    more = s.own
    for k in range(zeta.size):
        more[k] = s.excite[k] * _strong(s.excite[k], m.strong[k])
    for k in range(zeta.size):
        row = m.lines[k, np.uint64((bits[k] >> SHIFT) - BASE)]
        x, extra, drawn, inverse = np.float32(zeta[k]), more[k], s.inhibit[k], m.inverse[k]
        own = row[STATIC] + x * row[STATIC + 1]
        into = own + s.excite[k] + extra * (row[BENT] + x * row[BENT + 1])
        s.own[k] = own
        s.rate[k] = (into - drawn * (row[DRAWN] + x * row[DRAWN + 1])) * inverse
        s.slope[k] = (row[STATIC + 1] + extra * row[BENT + 1] - drawn * row[DRAWN + 1]) * inverse


@step_inlined
def _growth(x: np.float32) -> np.float32:
    """(e^x - 1) / x, e^x being taken as one over the first five terms of e^-x; for x of about 1 at most."""
    part = ONE - x * (HALF - x * (SIXTH - x * C24))
    return part / (ONE - x * part)


@step_inlined
def _time_to_top(
    p: F64, row: F32, zeta: float, now: tuple[float, float, float], left: float, step: float
) -> tuple[float, float]:
    """Time until a membrane is at the top, s, or below 0; and where it is after `left` s.

    p: its row of `Membranes.spiking`; row: its line of `Membranes.rise`; now: dzeta/dt, 1/s, its slope, 1/s,
    and the membrane's own part, A.
    """
    rate, slope, own = now
    drive = rate / p[INVERSE] - own
    growth = float(_growth(max(np.float32(slope * left), -STRONGEST)))
    new = max(zeta + rate * left * growth, 1.0)
    if slope * step > STEEP and own > abs(drive):
        # T_0 / (1 + drive T_1 / T_0)
        return max((row[0] + zeta * row[1]) / (1.0 + drive * (row[2] + zeta * row[3])), 0.0), new
    if new < p[TOP]:
        return -1.0, new
    x = slope * (p[TOP] - zeta) / rate
    return (p[TOP] - zeta) / rate * (math.log1p(x) / x if abs(x) > 1e-6 else 1.0), new


@step_inlined
def _linear(row: F64, x: float) -> float:
    i = min(max(int(x), 0), row.size - 2)
    return float(row[i] + (x - i) * (row[i + 1] - row[i]))


@step_inlined
def _adapt(m: Membranes, state: F64, step: float, inhibit: F32) -> None:
    """v_ahp over a step, and what it draws."""
    for k in range(inhibit.size):
        x = state[V_AHP, k] / m.ahp_step
        inhibit[k] += np.float32(_linear(m.drawn[k], x))
        rate = _linear(m.quiet[k], x)
        slope = (_linear(m.quiet[k], x + 0.01) - rate) / (0.01 * m.ahp_step)
        moved = step * rate * float(_growth(np.float32(min(slope * step, 0.0))))
        state[V_AHP, k] = max(state[V_AHP, k] + moved, 0.0)


@step_inlined
def _deliver(c: ChipTables, t: Traffic, until: float, s: Scratch) -> None:
    """Charges of the last step's spikes, and of the events before `until` s."""
    exciting, inhibiting = s.charge[0], s.charge[1]
    for j in range(t.counts[LAST]):
        row = c.charges[t.last[j]]
        for k in range(exciting.size):
            exciting[k] += max(row[k], ZERO)
            inhibiting[k] -= min(row[k], ZERO)
    t.counts[LAST] = 0
    j = t.counts[READ]
    while j < t.times.size and t.times[j] < until:
        column, k = t.columns[j], t.neurons[j]
        if column < VIRTUAL:
            s.charge[2 + (column >> 2), k] += c.virtual[column, k]
        else:
            charge = c.charges[column - VIRTUAL, k]
            exciting[k] += max(charge, ZERO)
            inhibiting[k] -= min(charge, ZERO)
        j += 1
    t.counts[READ] = j


@step_inlined
def _currents(c: ChipTables, state: F64, counts: I64, s: Scratch) -> None:
    """What flows into i_in and is drawn from v_mem in this step, A."""
    for k in range(s.excite.size):
        s.excite[k] = ZERO
        s.inhibit[k] = ZERO
    if c.live[0]:
        counts[HELD] += step_filters(state, np.int64(0), c.omega[0], c.banks[0], c.step, s.excite, s)
    if c.live[1]:
        counts[HELD] += step_filters(state, np.int64(1), c.omega[1], c.banks[1], c.step, s.inhibit, s)
    if c.live[2]:
        counts[HELD] += step_filters(state, np.int64(2), c.omega[2], c.banks[2], c.step, s.excite, s)
    if c.live[3]:
        counts[HELD] += step_filters(state, np.int64(3), c.omega[3], c.banks[3], c.step, s.inhibit, s)
    if c.membranes.adapting:
        _adapt(c.membranes, state, c.step, s.inhibit)


@step_inlined
def _move(m: Membranes, state: F64, step: float, s: Scratch) -> bool:
    """Easy steps; s.hard tells what else there is in a step: FIRES, FREED, RISES. Returns whether any is."""
    zeta = state[ZETA]
    some = False
    span, steep = np.float32(step), np.float32(STEEP)
    for k in range(zeta.size):
        x = s.slope[k] * span
        new = max(zeta[k] + s.rate[k] * span * _growth(max(x, -STRONGEST)), 1.0)
        held = state[WAIT, k] > 0.0
        # what drives it is less than its own current
        own = s.own[k] * m.inverse[k]
        rising = (x > steep) & (own > abs(s.rate[k] - own))
        fires, freed = state[SHUT, k] < step, held & (state[WAIT, k] <= step)
        rises = ((new >= m.top[k]) | rising) & (not held)
        zeta[k] = zeta[k] if held | rises else new
        s.hard[k] = (FIRES if fires else 0) | (FREED if freed else 0) | (RISES if rises else 0)
        some |= fires | freed | rises
    return some


@step_inlined
def _sorted_out(s: Scratch) -> tuple[int, int, int]:
    """Neurons of each kind of hard step into the rows of s.found; their numbers.

    Without a branch that depends on a neuron: what cannot be guessed costs more than all the rest.
    """
    words = fires = freed = rises = 0
    for word in range(s.words.size):
        s.found[3, words] = word
        words += 1 if s.words[word] != 0 else 0
    for j in range(words):
        first = 8 * s.found[3, j]
        for k in range(first, first + 8):
            hard = s.hard[k]
            s.found[0, fires], s.found[1, freed], s.found[2, rises] = k, k, k
            fires += hard & FIRES
            freed += (hard & FREED) >> 1
            rises += (hard & RISES) >> 2
    return fires, freed, rises


@step_inlined
def _fire(m: Membranes, state: F64, k: int, now: float, t: Traffic) -> None:
    """The spike of neuron k whose time has come."""
    t.sent[t.counts[WRITTEN]], t.senders[t.counts[WRITTEN]] = now + state[SHUT, k], k
    t.counts[WRITTEN] += 1
    t.last[t.counts[LAST]] = k
    t.counts[LAST] += 1
    state[SHUT, k] = NEVER
    if m.adapting:
        state[V_AHP, k] += m.spiking[k, KICK] * _linear(m.share[k], state[V_AHP, k] / m.ahp_step)


@step_inlined
def _release(m: Membranes, state: F64, k: int, now: float, step: float, t: Traffic, s: Scratch) -> None:
    """The rest of the step of a neuron that is let go in it, and all that it still does in it."""
    p = m.spiking[k]
    while 0.0 < state[WAIT, k] <= step:
        begin = state[WAIT, k]
        state[WAIT, k] = 0.0
        # at 0 V the whole input enters and nothing is drawn
        at = ((p[OWN] + s.excite[k]) * p[INVERSE], p[OWN_SLOPE] * p[INVERSE], p[OWN])
        to_top, state[ZETA, k] = _time_to_top(p, m.rise[k, 0], 1.0, at, step - begin, step)
        if to_top >= 0.0:
            state[SHUT, k] = begin + to_top + p[DELAY]
            state[WAIT, k] = state[SHUT, k] + p[REFRACTORY]
            if state[SHUT, k] < step:
                _fire(m, state, k, now, t)


@step_compiled
def _spike(m: Membranes, state: F64, bits: I64, step: float, now: float, t: Traffic, s: Scratch) -> None:
    """Hard steps: spikes whose time has come, neurons that are let go, and those found to spike soon."""
    fires, freed, rises = _sorted_out(s)
    for j in range(fires):
        _fire(m, state, s.found[0, j], now, t)
    for j in range(rises):
        k = s.found[2, j]
        p, row = m.spiking[k], m.rise[k, np.uint64((bits[k] >> SHIFT) - BASE)]
        at = (float(s.rate[k]), float(s.slope[k]), float(s.own[k]))
        to_top, _ = _time_to_top(p, row, state[ZETA, k], at, step, step)
        state[SHUT, k] = to_top + p[DELAY]
        state[WAIT, k] = state[SHUT, k] + p[REFRACTORY]
        if state[SHUT, k] < step:
            _fire(m, state, k, now, t)
            _release(m, state, k, now, step, t, s)
    for j in range(freed):
        _release(m, state, s.found[1, j], now, step, t, s)


@step_compiled
def run_chip(  # noqa: C901 - numba tells None from tables by argument and branch
    chip: ChipRun, steps: int, now: float,
    plastic: Plastic | None = None, noise: NoiseTables | None = None, depressing: Depressing | None = None,
) -> None:  # fmt: skip
    """Run `steps` steps from `now` s, or fewer where `sent` could overflow: counts[DONE] tells.

    plastic: the plastic array; noise: of the devices; depressing: synapses whose charge depends on their
    past. Of what is None numba compiles nothing.
    """
    c, state, bits, t, s = chip.tables, chip.state, chip.bits, chip.traffic, chip.scratch
    m = c.membranes
    for k in range(steps):
        if t.counts[WRITTEN] + t.last.size > t.sent.size:
            break
        begin = now + k * c.step
        if plastic is not None:
            deliver_plastic(plastic, state, t, begin + c.step)
        if depressing is not None:
            deliver_depressed(depressing, t, round(begin / c.step), begin + c.step, s)
        _deliver(c, t, begin + c.step, s)
        if noise is not None:
            disturb_filters(noise, c, state, round(begin / c.step), s)
        _currents(c, state, t.counts, s)
        if plastic is not None:
            if noise is not None:
                disturb_plastic(noise, plastic, round(begin / c.step))
            step_plastic(plastic, state, bits, c.step, s.excite)
        _rates(m, state[ZETA], bits, s)
        if noise is not None:
            disturb_membranes(noise, m, bits, round(begin / c.step), c.step, s)
        if _move(m, state, c.step, s):
            _spike(m, state, bits, c.step, begin, t, s)
        for j in range(bits.size):
            state[SHUT, j] -= c.step
            state[WAIT, j] = max(state[WAIT, j] - c.step, 0.0)
        t.counts[DONE] += 1
