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

a, w and b are lines over zeta = 1 + y / Q_0 (`chips.rolls.neuron.step`). Neurons that so much flows into
that they could spike again within a few steps take each step in parts (`chips.rolls.neuron.fast`). All is
done in float32 but what adds up.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.brief.encoded import Summed
from chips.rolls.depression.kernel import deliver_depressed
from chips.rolls.depression.layout import Depressing
from chips.rolls.layout import (
    DONE,
    HELD,
    LAST,
    READ,
    SHUT,
    WAIT,
    WRITTEN,
    ZERO,
    ZETA,
    ChipRun,
    ChipTables,
    Scratch,
    Traffic,
    step_compiled,
    step_inlined,
)
from chips.rolls.neuron.fast import bring, find_fast, live_fast
from chips.rolls.neuron.step import adapt, live_hard, move, rates
from chips.rolls.noise.kernel import disturb_filters, disturb_membranes, disturb_plastic, disturb_released
from chips.rolls.noise.layout import NoiseTables
from chips.rolls.plastic.kernel import deliver_plastic, step_plastic
from chips.rolls.plastic.layout import Plastic
from chips.rolls.synapse.step import step_all_filters
from circuits.arrays import F64, I64


@step_inlined
def _deliver(c: ChipTables, t: Traffic, s: Scratch, part: Scratch) -> None:
    """Charges of the last step's spikes; what neurons have by then is what parts of the step begin with."""
    exciting, inhibiting = s.charge[0], s.charge[1]
    for j in range(t.counts[LAST]):
        row = c.charges[t.last[j]]
        for k in range(exciting.size):
            exciting[k] += max(row[k], ZERO)
            inhibiting[k] -= min(row[k], ZERO)
    t.counts[LAST] = 0
    if c.parts > 1:
        for sign in range(part.charge.shape[0]):
            for k in range(exciting.size):
                part.charge[sign, k] = s.charge[sign, k]


@step_inlined
def _receive(c: ChipTables, t: Traffic, until: float, s: Scratch) -> int:
    """Charges of the events before `until` s; which one was the first."""
    first = j = int(t.counts[READ])
    while j < t.times.size and t.times[j] < until:
        bring(c, t, j, s)
        j += 1
    t.counts[READ] = j
    return first


@step_inlined
def _receive_encoded(c: ChipTables, e: Summed, number: int, cursor: int, s: Scratch) -> int:
    """Charges of the encoded events of step `number`, from token `cursor` on; which one is the next."""
    for sign in range(2):
        for k in range(e.many.shape[2]):
            count = e.many[number, sign, k]
            if count == 0:
                continue
            token = e.tokens[cursor]
            total = e.firsts[sign, token & 3, token >> 2, k]
            for j in range(cursor + 1, cursor + count):
                column = np.int64(e.tokens[j] & 3)
                for _ in range(e.tokens[j] >> 2):
                    total += c.virtual[4 * sign + column, k]
                    column = (column + 1) & 3
            s.charge[2 + sign, k] = total
            cursor += count
    return cursor


@step_inlined
def _currents(c: ChipTables, state: F64, counts: I64, s: Scratch) -> None:
    """What flows into i_in and is drawn from v_mem in this step, A."""
    for k in range(s.excite.size):
        s.excite[k] = ZERO
        s.inhibit[k] = ZERO
    counts[HELD] += step_all_filters(c, c.banks, c.step, state, s, (0, s.excite.size))


@step_inlined
def _beside(c: ChipTables, chip: ChipRun, plastic: Plastic | None) -> None:
    """What else flows in and is drawn, A: by the plastic array's filters, and by adaptation."""
    s = chip.scratch
    if plastic is not None:
        s.beside[0, :] = ZERO
        step_plastic(plastic, chip.state, chip.bits, c.step, s.beside[0])
        for k in range(s.excite.size):
            s.excite[k] += s.beside[0, k]
    if c.membranes.adapting:
        s.beside[1, :] = ZERO
        adapt(c.membranes, chip.state, c.step, s.beside[1])
        for k in range(s.inhibit.size):
            s.inhibit[k] += s.beside[1, k]


@step_compiled
def run_chip(  # noqa: C901, PLR0912 - numba tells None from tables by argument and branch
    chip: ChipRun, steps: int, now: float,
    plastic: Plastic | None = None, noise: NoiseTables | None = None, depressing: Depressing | None = None,
    encoded: Summed | None = None,
) -> None:  # fmt: skip
    """Run `steps` steps from `now` s, or fewer where `sent` could overflow: counts[DONE] tells.

    plastic: the plastic array; noise: of the devices; depressing: synapses whose charge depends on their
    past; encoded: events from outside of these very steps, in the place of the traffic's, up to the first
    step in which a neuron is fast. Of what is None numba compiles nothing.
    """
    c, state, bits, t, s = chip.tables, chip.state, chip.bits, chip.traffic, chip.scratch
    m, part = c.membranes, chip.part_scratch
    cursor = 0
    for k in range(steps):
        if t.counts[WRITTEN] + t.last.size > t.sent.size:
            break
        begin = now + k * c.step
        if plastic is not None:
            deliver_plastic(plastic, state, t, begin + c.step)
        if depressing is not None:
            deliver_depressed(depressing, t, round(begin / c.step), begin + c.step, s)
        _deliver(c, t, s, part)
        if encoded is not None:
            first, cursor = 0, _receive_encoded(c, encoded, k, cursor, s)
        else:
            first = _receive(c, t, begin + c.step, s)
        if noise is not None:
            disturb_filters(noise, c, state, round(begin / c.step), s)
        count, words = find_fast(chip) if c.parts > 1 else (0, 0)
        if encoded is not None and count > 0:
            break  # its parts ask when each event has come
        _currents(c, state, t.counts, s)
        if plastic is not None and noise is not None:
            disturb_plastic(noise, plastic, round(begin / c.step))
        _beside(c, chip, plastic)
        rates(m, state[ZETA], bits, s)
        if noise is not None:
            disturb_membranes(noise, m, bits, round(begin / c.step), c.step, s)
        hard = move(m, state, c.step, s)
        if noise is not None and (hard or count > 0):
            disturb_released(noise, m, c.step, s)
        if hard:
            live_hard(m, state, bits, c.step, begin, t, s)
        if count > 0:
            live_fast(chip, begin, first, count, words)
        for j in range(bits.size):
            state[SHUT, j] -= c.step
            state[WAIT, j] = max(state[WAIT, j] - c.step, 0.0)
        t.counts[DONE] += 1
