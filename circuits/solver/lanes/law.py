"""The transistor's law with second-order effects, in all lanes at once.

The channel is that of `circuits.devices.channel_lanes`; equations of the junctions stand in
`circuits.devices.transistor`, powers are those of `circuits.devices.softplus`.
"""

from __future__ import annotations

from circuits.compiled import compiled
from circuits.devices.channel_lanes import Effects, bent, channel_affected, channel_plain
from circuits.devices.softplus import power_of_lanes
from circuits.devices.transistor import FORWARD, INDUCED_LIMIT
from circuits.solver.lanes.layout import ROW, TERM, Team, Wiring
from circuits.vectors import vector
from circuits.vectors.vector import Lanes

every, larger, load = vector.every, vector.larger, vector.load
select, smaller, store = vector.select, vector.smaller, vector.store


@compiled(forceinline=True)
def _term(c: Wiring, x: Team, term: int, i: int) -> Lanes:
    """A coefficient of transistor i."""
    return load(x.coefficient, term * c.polarity.size + i)


@compiled(forceinline=True)
def _pinched(c: Wiring, x: Team, i: int, above: Lanes) -> tuple[Lanes, Lanes]:
    """v_p (V) of transistor i and dv_p/dv_g; above: of the gate over the bulk, V, mirrored for a pFET."""
    kappa = _term(c, x, TERM.kappa, i)
    v_p = kappa * (above - _term(c, x, TERM.v_t0, i))
    if c.body_effect:
        gamma, phi = (
            _term(c, x, TERM.gamma, i),
            _term(c, x, TERM.surface_potential, i),
        )
        v_p, kappa = bent(v_p, kappa, above + _term(c, x, TERM.lift, i), gamma, phi)
    return v_p, kappa


@compiled(forceinline=True)
def _channel(c: Wiring, x: Team, i: int, devices: Lanes) -> None:
    """Current of the channel of transistor i and its slopes, these times `devices`."""
    n = c.polarity.size
    s = c.polarity[i]
    v_b = load(x.v, c.terminal[3, i])
    v_d, v_s = s * (load(x.v, c.terminal[0, i]) - v_b), s * (load(x.v, c.terminal[2, i]) - v_b)
    v_p, kappa = _pinched(c, x, i, s * (load(x.v, c.terminal[1, i]) - v_b))
    half, specific = _term(c, x, TERM.inverse_2ut, i), _term(c, x, TERM.specific_current, i)
    if c.effects:
        effects = Effects(
            _term(c, x, TERM.early, i), _term(c, x, TERM.early_rise, i), _term(c, x, TERM.reduction, i),
            _term(c, x, TERM.spread, i),
        )  # fmt: skip
        found = channel_affected(specific, half, effects, v_d, v_p, v_s)
    else:
        found = channel_plain(specific, half, v_d, v_p, v_s)
    current, by_drain, by_pinch, by_source = found
    store(x.current, i, s * current)
    store(x.device_slope, i, devices * by_drain)
    store(x.device_slope, n + i, devices * kappa * by_pinch)
    store(x.device_slope, 2 * n + i, devices * by_source)


@compiled(forceinline=True)
def flow(u: Lanes) -> tuple[Lanes, Lanes]:
    """`1 - e^-u` and `e^-u`, u being a junction's voltage in U_T, along the tangent beyond `FORWARD`."""
    e = power_of_lanes(smaller(0.0 - u, every(FORWARD)))
    return 1.0 - e - e * larger(0.0 - u - FORWARD, every(0.0)), e


@compiled(forceinline=True)
def _junction(c: Wiring, x: Team, i: int, side: int, devices: Lanes) -> None:
    """Current of a junction of transistor i, at side 0 (drain) or 1, and its slopes times `devices`."""
    n = c.polarity.size
    s = c.polarity[i]
    v_j, v_b = load(x.v, c.terminal[2 * side, i]), load(x.v, c.terminal[3, i])
    per_volt, total = 2.0 * _term(c, x, TERM.inverse_2ut, i), _term(c, x, TERM.leakage, i)
    taken, e = flow(per_volt * (s * (v_j - v_b)))
    by_gate = every(0.0)
    if c.induces:
        slope = _term(c, x, TERM.induced_per_volt, i)
        over = s * (v_j - load(x.v, c.terminal[1, i]))
        y = slope * (over - _term(c, x, TERM.induced_from, i))
        induced = _term(c, x, TERM.induced, i) * power_of_lanes(smaller(y, every(INDUCED_LIMIT)))
        total = total + induced
        by_gate = select(y < INDUCED_LIMIT, induced * slope * taken, every(0.0))
    store(x.current, (1 + side) * n + i, s * total * taken)
    store(x.device_slope, (3 + side) * n + i, devices * (total * per_volt * e + by_gate))
    store(x.device_slope, (5 + side) * n + i, 0.0 - devices * by_gate)


@compiled()
def device_currents(c: Wiring, x: Team) -> None:
    """Currents of all transistors at the voltages in all lanes, and their slopes, none where none count."""
    devices = load(x.control, ROW.devices)
    for i in range(c.polarity.size):
        _channel(c, x, i, devices)
    if c.leaks:
        for side in range(2):
            for i in range(c.polarity.size):
                if c.terminal[2 * side, i] != c.terminal[3, i]:  # else there is no voltage across it
                    _junction(c, x, i, side, devices)
