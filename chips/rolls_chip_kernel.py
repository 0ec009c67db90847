"""Compiled stepping of a whole ROLLS chip: n neurons, their filters, and the synapses between them.

Time goes in steps. What was on the bus in the last step enters the filters at the beginning of this one, so
an event waits for a step at most. A filter is one equation: u is the ratio that the pair's currents I_1 and
I_2 would have in weak inversion, v the one that they have, `z = int (1 + v + c / (1 + v)) d ln u`:

    charge Q through the line:  z += kappa_n Q / (C U_T)
    leak:                       v -> v e^(-dt / tau),  z -= dt / tau + v (1 - e^(-dt / tau)), to rest
    output:                     I = I_S ln^2(1 + sqrt(E)),  E ~ u^(kappa_p / kappa_n)

c is what the line's capacitance adds while the line follows v_syn (`chips.rolls_lumped`). Between pulses the
line rises by the pair's current, by `C_line U_T ln t`; what it has taken then, the next pulse has to draw
from it first. The membrane is stepped in the charge y that a weak-inversion input would have needed to bring
it where it is, `dy = C dv / share(v)`, in which every input adds up and the leak is linear:

    dy/dt = a(y) + J (1 + w(y) G(J)) - (I_inh + I_ahp) b(y)

a, w and b are lines between points, 32 an octave of zeta = 1 + y / Q_0. A step is the exact solution on the
line of its beginning. Where a alone exceeds all input the neuron will spike, after the time T that is left,
with T_0 = int Q_0 / a dzeta and T_1 = int Q_0 / a^2 dzeta to the top, T = T_0 / (1 + J T_1 / T_0): exact for
a constant a, and what comes in meanwhile no longer counts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from circuits.compiled import compiled

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

# v and u^power over z: points from LOW to SPLIT, FINE an e-fold, then every COARSE up to HIGH
LOW, SPLIT, FINE, COARSE, COARSE_POINTS = -28.0, 256.0, 32, 16.0, 16384
FINE_POINTS = int((SPLIT - LOW) * FINE)
HIGH = SPLIT + COARSE * (COARSE_POINTS - 1)
VALUE, SLOPE, POWER, POWER_SLOPE = range(4)  # columns of that table

OCTAVE_BITS = 5  # 32 lines an octave of zeta
_SHIFT = 52 - OCTAVE_BITS  # of a float64's bits
BASE = 1023 << OCTAVE_BITS  # of 1.0
STATIC, BENT, DRAWN, VOLTAGE = 0, 2, 4, 6  # columns of a neuron's lines: intercept, and the slope behind it
LINE_COLUMNS = 8
# Columns of what a hard step needs: 1 / Q_0 (1/C), zeta of the top, s from there to the spike, s of the
# refractory period, V of v_ahp where all of a spike's current enters, and the membrane's own current at 0 V
# (A) with its slope
INVERSE, TOP, DELAY, REFRACTORY, KICK, OWN, OWN_SLOPE = range(7)
SPIKING_COLUMNS = 8
STEEP = 0.2  # of the slope times the step, from which an upstroke may be told; ours
NEVER = 1e30  # s
STRONGEST = 30.0  # e-folds that an inhibition's slope may have in a step

VIRTUAL = 8  # columns of virtual synapses, four excitatory and four inhibitory
SIGNS = 4  # filters of a neuron: excitatory, inhibitory, virtual excitatory, virtual inhibitory
# Rows of the state: z of the four filters, what their lines have taken since a pulse, and how long ago it was
Z, TAKEN, SINCE, V_AHP, ZETA, WAIT, SHUT = 0, 4, 8, 12, 13, 14, 15
STATE_ROWS = 16  # SHUT: s to a spike that is sure; WAIT: s until a neuron is let go


class FilterBank(NamedTuple):
    """Filters of one kind, float64[n] each."""

    kept: F64  # e^(-dt / tau)
    fall: F64  # dt / tau, less what idle synapses bring
    idle: F64  # that, in z
    line: F64  # C_line U_T in z
    first: F64  # what the line takes in a step with a pulse
    rest: F64  # z
    scale: F64  # E of u = 1, times the mean over a step of its decay
    specific: F64  # I_S of the output times the mirror's gain, A


class Membranes(NamedTuple):
    """Neurons, float64[n] unless said."""

    lines: F64  # float64[n, rows, LINE_COLUMNS] over zeta
    inverse: F64  # 1 / Q_0, 1/C
    strong: F64  # 1 / I_S of the pair, 1/A
    top: F64  # zeta at which the neuron spikes
    spiking: F64  # float64[n, SPIKING_COLUMNS]
    rise: F64  # float64[n, rows, 4] over zeta: T_0 (s) and T_1 / T_0 (1/A)
    adapting: bool  # whether v_ahp moves at all
    quiet: F64  # float64[n, points]: dv_ahp/dt, V/s
    share: F64  # float64[n, points]
    drawn: F64  # float64[n, points], A
    ahp_step: float  # V between points


class ChipTables(NamedTuple):
    """All that a step needs. charges: float32[pre, 2, post], kappa_n Q / (C U_T) of one event."""

    step: float  # s
    omega: F64  # float64[SIGNS, points, 4]
    banks: tuple[FilterBank, FilterBank, FilterBank, FilterBank]
    live: tuple[bool, bool, bool, bool]  # filters that something can reach
    charges: F32
    virtual: F64  # float64[columns, n], of the virtual synapses' events
    membranes: Membranes


class Scratch(NamedTuple):
    """Working space of `run_chip`, float64[n] each unless said."""

    charge: F64  # float64[SIGNS, n]
    place: F64
    value: F64
    power: F64
    excite: F64
    inhibit: F64
    lines: F64  # float64[6, n]
    rate: F64
    slope: F64
    hard: NDArray[np.uint8]
    words: I64  # the same, by eight


_compiled = compiled(fastmath={"contract", "nsz", "arcp"})
_inlined = compiled(fastmath={"contract", "nsz", "arcp"}, forceinline=True)


@_inlined
def _filter(state: F64, sign: int, omega: F64, bank: FilterBank, step: float, out: F64, s: Scratch) -> int:
    """A step of the filters of one kind; adds their currents to `out`, and empties their charges.

    Returns how many were beyond the table's end, and were held there.
    """
    place, value, power, q = s.place, s.value, s.power, s.charge[sign]
    z, taken, since = state[Z + sign], state[TAKEN + sign], state[SINCE + sign]
    # short loops over few arrays, or the compiler does not pack them
    for k in range(z.size):
        value[k] = max(bank.line[k] * step / (since[k] + 0.5 * step) - bank.idle[k], 0.0)
    for k in range(z.size):
        quiet = 0.0 if q[k] > 0.0 else 1.0
        value[k] = quiet * value[k] + (1.0 - quiet) * bank.first[k]
        power[k] = quiet
    for k in range(z.size):
        since[k] = power[k] * since[k] + step
    for k in range(z.size):
        before, quiet = taken[k], power[k]
        power[k] = value[k] + (1.0 - quiet) * (q[k] - before)
        taken[k] = value[k] + quiet * before
    held = 0
    for k in range(z.size):
        q[k] = 0.0
        x = min(z[k] + power[k], HIGH)
        held += 1 if z[k] + power[k] > HIGH else 0
        z[k] = x
        place[k] = (x - LOW) * FINE if x < SPLIT else (x - SPLIT) * (1.0 / COARSE) + FINE_POINTS
    for k in range(z.size):
        i = np.uint32(place[k])
        t = place[k] - i
        row = omega[i]
        value[k] = row[VALUE] + t * row[SLOPE]
        power[k] = row[POWER] + t * row[POWER_SLOPE]
    for k in range(z.size):
        e = math.sqrt(power[k] * bank.scale[k])
        # ln(1 + e) by a fraction of fourth order, 1e-3 off at e = 3
        log = e * (60.0 + e * (60.0 + 11.0 * e)) / (60.0 + e * (90.0 + e * (36.0 + 3.0 * e)))
        out[k] += bank.specific[k] * log * log
        z[k] = max(z[k] - bank.fall[k] - value[k] * (1.0 - bank.kept[k]), bank.rest[k])
    return held


@_inlined
def _strong(current: float, strong: float) -> float:
    """G(J): by how much more of J the pair lets into a membrane far above v_thr, for strong inversion."""
    t = math.sqrt(current * strong)
    r = 1.0 + t * (0.5 + t * (1.0 / 6.0 + t * (1.0 / 24.0)))
    return r * r - 1.0


@_inlined
def _rates(m: Membranes, zeta: F64, bits: I64, s: Scratch) -> None:
    """dzeta/dt and its slope, 1/s, at the step's beginning; s.excite, s.inhibit: currents, A."""
    lines = s.lines
    n = zeta.size
    for k in range(n):
        row = m.lines[k, np.uint64((bits[k] >> _SHIFT) - BASE)]
        x = zeta[k]
        lines[0, k] = row[0] + x * row[1]
        lines[1, k] = row[2] + x * row[3]
        lines[2, k] = row[4] + x * row[5]
        lines[3, k], lines[4, k], lines[5, k] = row[1], row[3], row[5]
    for k in range(n):
        more = s.excite[k] * _strong(s.excite[k], m.strong[k])
        into = lines[0, k] + s.excite[k] + more * lines[1, k] - s.inhibit[k] * lines[2, k]
        s.rate[k] = into * m.inverse[k]
        s.slope[k] = (lines[3, k] + more * lines[4, k] - s.inhibit[k] * lines[5, k]) * m.inverse[k]


@_inlined
def _growth(x: float) -> float:
    """(e^x - 1) / x, e^x being taken as one over the first five terms of e^-x; for x of about 1 at most."""
    part = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0)))
    return part / (1.0 - x * part)


@_compiled
def _hard_step(
    p: F64, rise: F64, state: F64, bits: int, now: tuple[float, float, float, float], step: float, spikes: F64
) -> int:
    """A step in which a neuron spikes, is let go or is found to spike soon; returns how many spikes.

    p: its row of `Membranes.spiking`; state: its own; now: dzeta/dt, its slope, the membrane's own part and
    what enters, A. spikes: filled with their times from the step's beginning, s, as SHUT and WAIT count.
    """
    count, begin = 0, 0.0
    rate, slope, own, excite = now
    while True:
        if state[SHUT] < step:
            spikes[count] = state[SHUT]
            count += 1
            state[SHUT] = NEVER
        if state[WAIT] >= step:
            return count
        place = np.uint64((bits >> _SHIFT) - BASE)
        if state[WAIT] > 0.0:
            begin = state[WAIT]
            state[WAIT] = 0.0
            # at 0 V the whole input enters and nothing is drawn
            own, slope = p[OWN], p[OWN_SLOPE] * p[INVERSE]
            rate = (own + excite) * p[INVERSE]
            state[ZETA], place = 1.0, np.uint64(0)
        zeta, left = state[ZETA], step - begin
        drive = rate / p[INVERSE] - own
        new = max(zeta + rate * left * _growth(max(slope * left, -STRONGEST)), 1.0)
        if slope * step > STEEP and own > abs(drive):
            # T_0 / (1 + drive T_1 / T_0)
            row = rise[place]
            to_top = max((row[0] + zeta * row[1]) / (1.0 + drive * (row[2] + zeta * row[3])), 0.0)
        elif new >= p[TOP]:
            x = slope * (p[TOP] - zeta) / rate
            to_top = (p[TOP] - zeta) / rate * (math.log1p(x) / x if abs(x) > 1e-6 else 1.0)
        else:
            state[ZETA] = new
            return count
        state[SHUT] = begin + to_top + p[DELAY]
        state[WAIT] = state[SHUT] + p[REFRACTORY]


@_inlined
def _linear(row: F64, x: float) -> float:
    i = min(max(int(x), 0), row.size - 2)
    return float(row[i] + (x - i) * (row[i + 1] - row[i]))


@_inlined
def _adapt(m: Membranes, state: F64, step: float, inhibit: F64) -> None:
    """v_ahp over a step, and what it draws."""
    for k in range(inhibit.size):
        x = state[V_AHP, k] / m.ahp_step
        inhibit[k] += _linear(m.drawn[k], x)
        rate = _linear(m.quiet[k], x)
        slope = (_linear(m.quiet[k], x + 0.01) - rate) / (0.01 * m.ahp_step)
        state[V_AHP, k] = max(state[V_AHP, k] + step * rate * _growth(min(slope * step, 0.0)), 0.0)


class Traffic(NamedTuple):
    """Events into a chip and spikes out of it.

    times (s, rising), columns (0 to 7 virtual, from 8 on presynaptic neurons), neurons: of events. sent (s),
    senders: room for spikes, in the order of steps and in a step of neurons. last: int64[n], the neurons that
    spiked in the step before. counts: int64[COUNTS].
    """

    times: F64
    columns: I64
    neurons: I64
    sent: F64
    senders: I64
    last: I64
    counts: I64


# Steps done, spikes written, events read, neurons in `last`, filters times steps beyond their table's end
DONE, WRITTEN, READ, LAST, HELD = range(5)
COUNTS = 5


@_inlined
def _deliver(c: ChipTables, t: Traffic, until: float, s: Scratch) -> None:
    """Charges of the last step's spikes, and of the events before `until` s."""
    exciting, inhibiting = s.charge[0], s.charge[1]
    for j in range(t.counts[LAST]):
        excited, inhibited = c.charges[t.last[j], 0], c.charges[t.last[j], 1]
        for k in range(exciting.size):
            exciting[k] += excited[k]
        for k in range(exciting.size):
            inhibiting[k] += inhibited[k]
    t.counts[LAST] = 0
    j = t.counts[READ]
    while j < t.times.size and t.times[j] < until:
        column, k = t.columns[j], t.neurons[j]
        if column < VIRTUAL:
            s.charge[2 + (column >> 2), k] += c.virtual[column, k]
        else:
            exciting[k] += c.charges[column - VIRTUAL, 0, k]
            inhibiting[k] += c.charges[column - VIRTUAL, 1, k]
        j += 1
    t.counts[READ] = j


@_inlined
def _currents(c: ChipTables, state: F64, counts: I64, s: Scratch) -> None:
    """What flows into i_in and is drawn from v_mem in this step, A."""
    for k in range(s.excite.size):
        s.excite[k] = 0.0
        s.inhibit[k] = 0.0
    if c.live[0]:
        counts[HELD] += _filter(state, 0, c.omega[0], c.banks[0], c.step, s.excite, s)
    if c.live[1]:
        counts[HELD] += _filter(state, 1, c.omega[1], c.banks[1], c.step, s.inhibit, s)
    if c.live[2]:
        counts[HELD] += _filter(state, 2, c.omega[2], c.banks[2], c.step, s.excite, s)
    if c.live[3]:
        counts[HELD] += _filter(state, 3, c.omega[3], c.banks[3], c.step, s.inhibit, s)
    if c.membranes.adapting:
        _adapt(c.membranes, state, c.step, s.inhibit)


@_inlined
def _move(m: Membranes, state: F64, step: float, s: Scratch) -> bool:
    """Easy steps; s.hard becomes 1 where a step is hard. Returns whether any is."""
    zeta = state[ZETA]
    some = False
    for k in range(zeta.size):
        x = s.slope[k] * step
        new = max(zeta[k] + s.rate[k] * step * _growth(max(x, -STRONGEST)), 1.0)
        held = state[WAIT, k] > 0.0
        # what drives it is less than its own current
        own = s.lines[0, k] * m.inverse[k]
        rising = (x > STEEP) & (own > abs(s.rate[k] - own))
        ends = (state[SHUT, k] < step) | (held & (state[WAIT, k] < step))
        hard = ends | (((new >= m.top[k]) | rising) & (not held))
        zeta[k] = zeta[k] if held | hard else new
        s.hard[k] = 1 if hard else 0
        some |= hard
    return some


@_inlined
def _spike(
    m: Membranes, state: F64, bits: I64, step: float, now: float, t: Traffic, s: Scratch, spikes: F64
) -> None:
    """Hard steps; few neurons have one, so they are looked for by eight."""
    for word in range(s.words.size):
        if s.words[word] != 0:
            for k in range(8 * word, 8 * word + 8):
                if s.hard[k] != 0:
                    at = (s.rate[k], s.slope[k], s.lines[0, k], s.excite[k])
                    count = _hard_step(m.spiking[k], m.rise[k], state[:, k], bits[k], at, step, spikes)
                    if m.adapting:
                        share = _linear(m.share[k], state[V_AHP, k] / m.ahp_step)
                        state[V_AHP, k] += count * m.spiking[k, KICK] * share
                    for j in range(count):
                        t.sent[t.counts[WRITTEN]], t.senders[t.counts[WRITTEN]] = now + spikes[j], k
                        t.counts[WRITTEN] += 1
                    if count > 0:
                        t.last[t.counts[LAST]] = k
                        t.counts[LAST] += 1


@_compiled
def run_chip(
    c: ChipTables, state: F64, bits: I64, steps: int, now: float, t: Traffic, s: Scratch, spikes: F64
) -> None:
    """Run `steps` steps from `now` s, or fewer where `sent` could overflow: t.counts[DONE] tells.

    state: float64[STATE_ROWS, n], of which `bits` is the row of zeta as int64; spikes: room for those of a
    neuron in a step.
    """
    m = c.membranes
    n = t.last.size
    for k in range(steps):
        if t.counts[WRITTEN] + spikes.size * n > t.sent.size:
            break
        begin = now + k * c.step
        _deliver(c, t, begin + c.step, s)
        _currents(c, state, t.counts, s)
        _rates(m, state[ZETA], bits, s)
        if _move(m, state, c.step, s):
            _spike(m, state, bits, c.step, begin, t, s, spikes)
        for j in range(n):
            state[SHUT, j] -= c.step
            state[WAIT, j] = max(state[WAIT, j] - c.step, 0.0)
        t.counts[DONE] += 1
