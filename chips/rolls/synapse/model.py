"""Behavioural model of ROLLS' synapse: its pulse, its weight current and its filter's two equations.

* pulse: from the event until I_pwlk has brought `v_p` to the threshold of its inverter after the event's end,
  `t = t_event + C_p V_inv / I_pwlk`, C_p the capacitor and what hangs on it;
* weight: the saturated currents of the level's devices (`chips.rolls.synapse.weight`); the excitatory ones
come late
  by the charge that their mirror's gate takes, `C_m (V_on - V_before) / I`, V_before falling since the last
  pulse by the mirror's own current;
* filter: the nonlinear equations of v_syn and the line (`chips.rolls.synapse.kernel`).

All device deviations are those of the transistor level (`circuits.lowering.on_die`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chips.rolls.lumped.whole import coupling, rows_of
from chips.rolls.synapse.kernel import FILTER_COLUMNS, Filters, WholeFilters, follow, rest_of
from chips.rolls.synapse.opening import opened
from chips.rolls.synapse.weight import Weights, weights_on
from chips.rolls.synapse.whole_weight import fall, recharge
from circuits.arrays import F64
from circuits.blocks.rolls.dpi_synapse import MEMBRANE
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.event import EDGE, WIDTH
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.capacitors_on_die import with_capacitors
from circuits.lowering.on_die import DieDevices, array_of, standing
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

LATE = 1e-10  # A, ours: at which the slope of the mirror that follows late is taken


@dataclass(frozen=True, slots=True)
class SynapseModel:
    """A synapse with its filters, or an array of them; capacitances in F."""

    circuit: Circuit
    array: str
    pulse_capacitance: float  # at v_p
    event_coupling: float  # from the event to v_p
    inverter_coupling: float  # from v_p to its inverter's output
    inverter_capacitance: float  # at that output
    mirror_capacitance: float  # at the gate of the excitatory mirror
    mirror_coupling: float  # from that gate to the mirror's drain
    filter_capacitance: tuple[F64, F64]  # of v_syn and the line, excitatory and inhibitory, float64[2, 2]
    output_capacitance: float  # at the gate of the inhibitory output's mirror
    switch_capacitance: tuple[float, float]  # at the far nodes of the switch to the line
    switch_held: tuple[float, float]  # share of it that is at v_shift between pulses
    switch_coupling: tuple[float, float]  # from its gate to the line


@dataclass(frozen=True, slots=True)
class SynapsesOnDie:
    """Synapses of one level on a die; begin, width: of a pulse, from its event's beginning, s."""

    begin: F64
    width: F64
    weights: Weights
    filters: Filters
    whole: WholeFilters | None
    slope: F64  # of the logarithm of the mirror's current over its gate, 1/V
    mirror_capacitance: float


def model_of(circuit: Circuit, process: Process, array: str = "") -> SynapseModel:
    """Prepare the model of a ROLLS synapse with its filters, or of a circuit's instance array `array`."""
    lone = array_of(circuit, array).circuit if array else circuit
    pulse = capacitance_matrix(lone, process, ("extender.v_p", "event", "extender.p1"))
    filters, switches, shares, couplings = [], [], [], []
    for line, held, far in (("exc", "ed", ()), ("inh", "ix", ("is",))):
        nodes = tuple(f"synapse.{name}" for name in (f"{line}_on", held, *far))
        c = capacitance_matrix(lone, process, (f"v_{line}_syn", line, *nodes))
        filters.append(c[:2, :2])
        switches.append(float(c[3:, 3:].sum()))
        shares.append(float(c[3, 3] / c[3:, 3:].sum()))
        couplings.append(-float(c[1, 2]))
    mirror = capacitance_matrix(lone, process, ("synapse.em", "synapse.ed"))
    at_v_p = (float(pulse[0, 0]), -float(pulse[0, 1]), -float(pulse[0, 2]), float(pulse[2, 2]))
    return SynapseModel(
        circuit, array, *at_v_p, float(mirror[0, 0]), -float(mirror[0, 1]), (filters[0], filters[1]),
        float(capacitance_matrix(lone, process, ("inhibitory.vm",))[0, 0]),
        (switches[0], switches[1]), (shares[0], shares[1]), (couplings[0], couplings[1]),
    )  # fmt: skip


def synapses_on(model: SynapseModel, silicon: Silicon, level: int) -> SynapsesOnDie:
    """Return the synapses of `level` (-4 to 4, not 0) on a silicon.

    Raises `ParameterError` for another level.
    """
    if level not in (-4, -3, -2, -1, 1, 2, 3, 4):
        raise ParameterError(f"level: {level}, must be -4 to 4 and not 0; 0 lets nothing in")
    d = standing(model.circuit, silicon, model.array)
    return synapses_of(model, with_capacitors(d, model.circuit, silicon, inside=model.array), level)


def synapses_of(model: SynapseModel, d: DieDevices, level: int, end: float = MEMBRANE) -> SynapsesOnDie:
    """Return synapses with the devices `d`, each with filters of its own, whose output flows to `end` V."""
    weights = weights_on(d, level, model.mirror_capacitance, model.mirror_coupling)
    begin, width = pulse_of(model, d)
    slope = np.full(d.copies, d.fet["synapse.me7"].kappa / d.u_t)
    if d.full and level > 0:
        slope, _ = fall(d, weights.mirror_level)
    whole = _whole(d, level > 0, end) if d.full else None
    return SynapsesOnDie(
        begin, width, weights, _filters(model, d, level, weights), whole, slope, model.mirror_capacitance
    )  # fmt: skip


def pulse_of(model: SynapseModel, d: DieDevices) -> tuple[F64, F64]:
    """Return beginning and end of a pulse after an event's beginning, s."""
    u_t = d.u_t
    threshold, follower = d.inverter_threshold("extender.mp3"), d.inverter_threshold("extender.mp4")
    i_pwlk = d.saturated("extender.mp2", d.below("v_pwlk"))
    c = np.broadcast_to(model.pulse_capacitance + d.added("extender.c_pw"), d.copies)
    # event at which mp1 has emptied v_p down to the threshold, and at which it no longer carries I_pwlk
    needed = c * (d.v_dd - threshold)
    rising, falling = opened(d, "extender.mp1", needed, np.broadcast_to(i_pwlk, d.copies), EDGE)
    begin = EDGE * rising / d.v_dd
    released = EDGE + WIDTH + EDGE * (1.0 - falling / d.v_dd)
    # v_p starts a little below ground, and p1 draws on it while it falls to the next inverter's threshold
    moved = c * threshold + model.event_coupling * falling + model.inverter_coupling * (d.v_dd - follower)
    # p1 moves from where the pFET leaves its triode region
    edge = d.v_dd - u_t * d.pinch("extender.mp3p", d.v_dd - threshold)
    if d.full:
        i_pwlk = d.current("extender.mp2", d.below("v_pwlk"), d.v_dd - threshold)
    speed = i_pwlk / c
    lag = d.inverter_lag("extender.mp3", edge - follower, model.inverter_capacitance, speed, threshold)
    if d.full:
        more = model.event_coupling * falling, model.inverter_coupling * (d.v_dd - follower)
        return begin, np.asarray(released + recharge(d, c, threshold, more) + lag)
    return begin, np.asarray(released + moved / i_pwlk + lag)


def _filters(model: SynapseModel, d: DieDevices, level: int, weights: Weights) -> Filters:
    n, u_t, excites = d.copies, d.u_t, level > 0
    name, letter = ("excitatory", "e") if excites else ("inhibitory", "i")
    md1, md2, md3, md5 = (d.fet[f"{name}.md{k}"] for k in (1, 2, 3, 5))
    md6, md7 = (md2, md2) if excites else (d.fet[f"{name}.md6"], d.fet[f"{name}.md7"])
    sign = 0 if excites else 1
    inverse, line = _own_capacitance(model.filter_capacitance[sign], d, name)
    switch = d.pinch("synapse.me9" if excites else "synapse.mi1", d.v_dd) * u_t
    kappa = md1.kappa
    if d.full and not excites:
        # of the mirror, which follows late
        kappa = coupling(d, f"{name}.md6", d.gate_for(f"{name}.md6", np.asarray(LATE)))
    return Filters(
        u_t=np.full(n, u_t),
        kappa_n=np.full(n, kappa),
        kappa_p=np.full(n, md3.kappa),
        v_dd=np.full(n, d.v_dd),
        i1=md1.current,
        p_thr=np.broadcast_to(d.pinch(f"{name}.md1", d.gate[f"v_{letter}thr"]), n).copy(),
        i2=md2.current,
        t2=md2.threshold / u_t,
        i3=md3.current,
        p_tau=np.broadcast_to(d.pinch(f"{name}.md3", d.below(f"v_{letter}tau")), n).copy(),
        i5=md5.current,
        t5=md5.threshold / u_t,
        i6=md6.current,
        t6=md6.threshold / u_t,
        i7=md7.current,
        t7=md7.threshold / u_t,
        mirrored=np.full(n, not excites),
        mirror_capacitance=np.full(n, model.output_capacitance),
        inverse=inverse,
        off=weights.off,
        shared=model.switch_capacitance[sign] / line,
        highest=switch,
        lift=model.switch_coupling[sign] * d.v_dd / line,
        shape=weights.shape,
        held=np.full(n, model.switch_held[sign]) * d.gate["v_shift"],
    )


def _own_capacitance(c: F64, d: DieDevices, name: str) -> tuple[F64, F64]:
    """C^-1 of each filter as `Filters` has it, 1/F, float64[3, n], and C of its line, F, float64[n].

    c: of v_syn and the line as drawn, F, float64[2, 2]; name: of the filter's instance.
    """
    each = np.repeat(c[None], d.copies, axis=0)
    for k, capacitor in enumerate(("c_syn", "c_line")):
        each[:, k, k] += d.added(f"{name}.{capacitor}")
    inverse = np.linalg.inv(each)
    return np.array([inverse[:, 0, 0], inverse[:, 0, 1], inverse[:, 1, 1]]), each[:, 1, 1]


def _whole(d: DieDevices, excites: bool, end: float) -> WholeFilters:  # noqa: FBT001 - which filter
    name, letter = ("excitatory", "e") if excites else ("inhibitory", "i")
    numbers = (1, 2, 3, 5, 5, 5) if excites else (1, 2, 3, 5, 6, 7)
    gates = (d.gate[f"v_{letter}thr"], d.below(f"v_{letter}tau"))
    return WholeFilters(
        np.array([rows_of(d.fet[f"{name}.md{k}"]) for k in numbers]),
        np.array([np.broadcast_to(x, d.copies) for x in gates]), end,
    )  # fmt: skip


def pulses(synapses: SynapsesOnDie, k: int, events: Sequence[float]) -> tuple[F64, F64]:
    """Return beginnings and ends (s) of the current of synapse k at events (s).

    Pulses that overlap are one.
    """
    starts: list[float] = []
    ends: list[float] = []
    for t in sorted(events):
        begin, end = t + float(synapses.begin[k]), t + float(synapses.width[k])
        if ends and begin < ends[-1]:
            ends[-1] = end
            continue
        starts.append(begin + _late(synapses, k, begin - ends[-1] if ends else np.inf))
        ends.append(end)
    kept = [(a, b) for a, b in zip(starts, ends, strict=True) if a < b]
    return np.array([a for a, _ in kept]), np.array([b for _, b in kept])


def _late(synapses: SynapsesOnDie, k: int, quiet: float) -> float:
    """Delay of the current after `quiet` s without one: the mirror's gate falls by its own current."""
    w = synapses.weights
    high, rest = float(w.mirror_level[k]), float(w.mirror_rest[k])
    if high == rest:
        return 0.0
    slope = float(synapses.slope[k])
    fall = np.exp(-slope * high) + slope * float(w.mirror_current[k]) * quiet / synapses.mirror_capacitance
    before = max(-np.log(fall) / slope, rest) if np.isfinite(fall) else rest
    return float(w.delay[k]) * (high - before) / (high - rest)


def respond(synapses: SynapsesOnDie, events: Sequence[float], times: F64) -> F64:
    """Return the output current (A, float64[n, times]) of synapses that rest before 0 s.

    events: s; times: s, from 0 up.
    """
    n = synapses.begin.size
    state = np.zeros((n, FILTER_COLUMNS))
    filters, whole = synapses.filters, synapses.whole
    rest_of(filters, whole, state)
    out = np.empty((n, times.size))
    for k in range(n):
        on = pulses(synapses, k, events)
        follow(filters, whole, k, state[k], synapses.weights.current[k], on, times, out[k])
    return out
