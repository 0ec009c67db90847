"""Compiled run of a spiking network: Hodgkin-Huxley neurons by blocks, integrate-and-fire neurons as needed.

Hodgkin-Huxley neurons (`system.spiking_bat.network.hodgkin_huxley`) take alpha-shaped conductances, equations
(12) and (13) of Wen & Horiuchi 2022. An integrate-and-fire neuron, with v in units of its threshold,

    dv/dt = -leak v + I_0 + sum of boxes,    v >= 0;    at v >= 1 a spike, v = 0, and nothing while refractory

takes currents that are boxes in time, equation (14); between events they are constant, so that a step of it
is exact. That v stops at 0, its reset, is ours: then a neuron without positive current rests there exactly,
and is left out until an event reaches it.

A synapse whose `hold` is `_LATCHED` switches its current on at its first spike and keeps it, whatever spikes
follow, until the next release, as the paper's saturating step currents do. A release, at each spike of the
source `release`, brings the neurons marked `released` back to v = 0, ends their refractory time, and ends all
latched currents.

Order within step k, from k dt to (k + 1) dt, which pins what a delay means:

    1. all neurons advance by dt;  2. their spikes of this step, then inputs of step k, are recorded;
    3. each is delivered, or put off by its synapse's delay;  4. what was put off until step k is delivered

so that a spike whose delay is 0 acts on its target in step k + 1, and a box is on for exactly `hold` steps.
"""

from __future__ import annotations

from typing import NamedTuple

from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from system.spiking_bat.network.hodgkin_huxley import BLOCK, LANES, SPIKED, X_E, X_I, V, step_blocks

_LATCHED = -1  # as `hold`: until the next release
FOREVER = 1 << 62  # steps; as `refractory`: until the next release
NOW, FREE, ACTIVE, SPIKES, LOST = range(5)  # of `State.counts`
NOBODY = -1


class Wiring(NamedTuple):
    """What does not change in a run. Sources count neurons, then inputs; Hodgkin-Huxley neurons come first.

    step: s; conductors: number of Hodgkin-Huxley neurons; release: source whose spikes release, or -1.
    begin: int64[sources + 1], where each one's synapses begin; target, delay (steps), hold (steps, or
    `_LATCHED`): int64[synapses]; weight: float64[synapses], of an integrate-and-fire target the current in
    thresholds per second, of another what x_e (above 0) or x_i (below 0) gets, S/m^2/s.
    decay, gain (s), drive (1/s): float64[integrators], a step is v decay + gain (drive + currents);
    refractory: int64[integrators], steps; released: bool[integrators].
    """

    step: float
    conductors: int
    release: int
    begin: I64
    target: I64
    delay: I64
    hold: I64
    weight: F64
    decay: F64
    gain: F64
    drive: F64
    refractory: I64
    released: Bools


class State(NamedTuple):
    """What changes, overwritten in place.

    blocks: of Hodgkin-Huxley neurons; v, current, held (latched currents): float64[integrators]; wait: the
    step from which each is no longer refractory; active, place: list of those that advance, and where each
    stands in it; latched: bool[synapses]; slot: int64[slots], first event that was put off until a step;
    after, event: int64[room], the next one, and the synapse, or its complement to end a box; fired:
    int64[sources], spikes of this step; counts: step, free event, number of active, spikes recorded, and
    spikes or events without room.
    """

    blocks: F64
    v: F64
    current: F64
    held: F64
    wait: I64
    active: I64
    place: I64
    latched: Bools
    slot: I64
    after: I64
    event: I64
    fired: I64
    counts: I64


_compiled = compiled(fastmath={"contract"})
_inlined = compiled(fastmath={"contract"}, forceinline=True)


@_compiled
def advance(w: Wiring, s: State, inputs: I64, steps: int, raster: I64, probes: I64, traces: F64) -> None:
    """Advance by so many steps.

    inputs: int64[inputs, 2], step and source, by step, none before the state's; raster: int64[room, 2], step
    and source of every spike from row SPIKES on; traces: float64[steps, probes], voltage of each of the
    neurons `probes` after each step, V, or in thresholds.
    """
    given = 0
    for row in range(steps):
        now = s.counts[NOW]
        step_blocks(s.blocks, w.step)
        found = _conductor_spikes(w, s)
        found = _advance_integrators(w, s, found)
        while given < inputs.shape[0] and inputs[given, 0] == now:
            s.fired[found] = inputs[given, 1]
            found += 1
            given += 1
        for k in range(found):
            source = s.fired[k]
            _record(s, source, raster)
            if source == w.release:
                _release(w, s)
            for synapse in range(w.begin[source], w.begin[source + 1]):
                if w.delay[synapse] == 0:
                    _deliver(w, s, synapse)
                else:
                    _put_off(s, synapse, w.delay[synapse])
        _deliver_due(w, s)
        for k in range(probes.size):
            traces[row, k] = _voltage(w, s, probes[k])
        s.counts[NOW] = now + 1


@_compiled
def _conductor_spikes(w: Wiring, s: State) -> int:
    """List the Hodgkin-Huxley neurons that have just spiked; returns how many."""
    found = 0
    for at in range(SPIKED * LANES, s.blocks.size, BLOCK):
        some = 0.0
        for k in range(at, at + LANES):
            some += s.blocks[k]
        if some == 0.0:
            continue
        for k in range(LANES):
            if s.blocks[at + k] != 0.0:
                s.fired[found] = at // BLOCK * LANES + k
                found += 1
    return found


@_compiled
def _advance_integrators(w: Wiring, s: State, found: int) -> int:
    """Advance the active integrate-and-fire neurons, and list those that spike."""
    now, k = s.counts[NOW], 0
    while k < s.counts[ACTIVE]:
        i = s.active[k]
        total = w.drive[i] + s.current[i] + s.held[i]
        if s.wait[i] > now:
            if s.wait[i] >= FOREVER:
                _rest(s, i)
            else:
                k += 1
            continue
        v = s.v[i] * w.decay[i] + w.gain[i] * total
        if v >= 1.0:
            v = 0.0
            s.wait[i] = FOREVER if w.refractory[i] >= FOREVER else now + w.refractory[i]
            s.fired[found] = w.conductors + i
            found += 1
        s.v[i] = max(v, 0.0)
        if v <= 0.0 and total <= 0.0:
            _rest(s, i)
        else:
            k += 1
    return found


@_inlined
def _rest(s: State, i: int) -> None:
    """Take a neuron from the list; the last one takes its place."""
    last = s.counts[ACTIVE] - 1
    moved, k = s.active[last], s.place[i]
    s.active[k], s.place[moved] = moved, k
    s.place[i] = NOBODY
    s.counts[ACTIVE] = last


@_inlined
def _wake(s: State, i: int) -> None:
    if s.place[i] == NOBODY:
        s.place[i] = s.counts[ACTIVE]
        s.active[s.counts[ACTIVE]] = i
        s.counts[ACTIVE] += 1


@_inlined
def _record(s: State, source: int, raster: I64) -> None:
    row = s.counts[SPIKES]
    if row < raster.shape[0]:
        raster[row, 0], raster[row, 1] = s.counts[NOW], source
        s.counts[SPIKES] = row + 1
    else:
        s.counts[LOST] += 1


@_compiled
def _deliver(w: Wiring, s: State, synapse: int) -> None:
    """A spike arrives at its target."""
    target, weight, hold = w.target[synapse], w.weight[synapse], w.hold[synapse]
    if target < w.conductors:
        at = target // LANES * BLOCK + target % LANES
        if weight > 0.0:
            s.blocks[at + X_E * LANES] += weight
        else:
            s.blocks[at + X_I * LANES] -= weight
        return
    i = target - w.conductors
    if hold == _LATCHED:
        if s.latched[synapse]:
            return
        s.latched[synapse] = True
        s.held[i] += weight
    else:
        s.current[i] += weight
        _put_off(s, ~synapse, hold)
    _wake(s, i)


@_compiled
def _put_off(s: State, event: int, delay: int) -> None:
    """Keep an event for `delay` steps."""
    free = s.counts[FREE]
    if free == NOBODY:
        s.counts[LOST] += 1
        return
    s.counts[FREE] = s.after[free]
    slot = (s.counts[NOW] + delay) % s.slot.size
    s.event[free], s.after[free] = event, s.slot[slot]
    s.slot[slot] = free


@_compiled
def _deliver_due(w: Wiring, s: State) -> None:
    """Deliver all that was put off until this step."""
    slot = s.counts[NOW] % s.slot.size
    k = s.slot[slot]
    s.slot[slot] = NOBODY
    while k != NOBODY:
        event, following = s.event[k], s.after[k]
        s.after[k], s.counts[FREE] = s.counts[FREE], k
        if event >= 0:
            _deliver(w, s, event)
        else:
            i = w.target[~event] - w.conductors
            s.current[i] -= w.weight[~event]
            _wake(s, i)
        k = following


@_compiled
def _release(w: Wiring, s: State) -> None:
    """Bring the released neurons to their reset, and end latched currents."""
    for synapse in range(s.latched.size):
        s.latched[synapse] = False
    for i in range(w.released.size):
        s.held[i] = 0.0
        if w.released[i]:
            s.v[i], s.wait[i] = 0.0, 0
            _wake(s, i)


@_inlined
def _voltage(w: Wiring, s: State, neuron: int) -> float:
    if neuron < w.conductors:
        return float(s.blocks[neuron // LANES * BLOCK + V * LANES + neuron % LANES])
    return float(s.v[neuron - w.conductors])
