"""The transistor's law with second-order effects, in all lanes at once.

Its equations stand in `circuits.devices.transistor`, and their derivatives as here in
`circuits.devices.channel`. Logarithms and powers are those of `circuits.devices.softplus`.
"""

from __future__ import annotations

from circuits.compiled import compiled
from circuits.devices.softplus import power_of_lanes, softplus_of_two
from circuits.devices.transistor import INDUCED_LIMIT
from circuits.solver.lanes.layout import ROW, TERM, Team, Wiring
from circuits.vectors import vector
from circuits.vectors.vector import Lanes

every, larger, load, magnitude, root = vector.every, vector.larger, vector.load, vector.magnitude, vector.root
select, smaller, store = vector.select, vector.smaller, vector.store

_FORWARD = 20.0  # U_T, of a junction, beyond which the law goes on along its tangent


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
        v_x = above + _term(c, x, TERM.lift, i)
        # below flat band the square root has no meaning; the law goes on with its tangent there
        v_c = larger(v_x, every(0.0))
        inside = root(v_c + 0.25 * gamma * gamma)
        bent = gamma > 0.0
        slope = 1.0 - 0.5 * gamma / select(bent, inside, every(1.0))
        follows = v_c - phi - gamma * (inside - 0.5 * gamma) + slope * (v_x - v_c)
        v_p, kappa = select(bent, follows, v_p), select(bent, slope, kappa)
    return v_p, kappa


@compiled(forceinline=True)
def _channel(c: Wiring, x: Team, i: int, devices: Lanes) -> None:
    """Current of the channel of transistor i and its slopes, these times `devices`."""
    n = c.polarity.size
    s = c.polarity[i]
    v_b = load(x.v, c.terminal[3, i])
    v_d, v_s = s * (load(x.v, c.terminal[0, i]) - v_b), s * (load(x.v, c.terminal[2, i]) - v_b)
    v_p, kappa = _pinched(c, x, i, s * (load(x.v, c.terminal[1, i]) - v_b))
    half = _term(c, x, TERM.inverse_2ut, i)
    forward, reverse, forward_slope, reverse_slope = softplus_of_two((v_p - v_s) * half, (v_p - v_d) * half)
    specific = _term(c, x, TERM.specific_current, i)
    plain = specific * (forward - reverse) * (forward + reverse)
    twice = 2.0 * specific * half
    by_forward, by_reverse = twice * forward * forward_slope, twice * reverse * reverse_slope
    if c.effects:
        v_ds = v_d - v_s
        sign = select(v_ds >= 0.0, every(1.0), every(-1.0))
        v_ds = magnitude(v_ds)
        early, early_rise = (
            _term(c, x, TERM.early, i),
            _term(c, x, TERM.early_rise, i),
        )
        reduction = _term(c, x, TERM.reduction, i)
        rise = 1.0 + early_rise * (forward + reverse)
        around = root(v_p * v_p + _term(c, x, TERM.spread, i))
        v_m = 0.5 * (v_p + around)
        moves = 1.0 + reduction * v_m
        # one division for three
        inverse = 1.0 / (rise * moves * around)
        per_rise, moved = inverse * (moves * around), inverse * (rise * around)
        effect = 1.0 + early * v_ds * per_rise
        scale = effect * moved
        by_vp = 0.0 - scale * moved * reduction * v_m * (inverse * (rise * moves))
        by_vds = sign * moved * early * per_rise
        by_q = 0.0 - moved * early * early_rise * v_ds * per_rise * per_rise
        forward_q, reverse_q = half * forward_slope, half * reverse_slope
        by_drain = by_reverse * scale + plain * (by_vds - by_q * reverse_q)
        by_gate = (by_forward - by_reverse) * scale + plain * (by_q * (forward_q + reverse_q) + by_vp)
        by_source = 0.0 - by_forward * scale - plain * (by_vds + by_q * forward_q)
        plain = plain * scale
    else:
        by_drain, by_gate, by_source = by_reverse, by_forward - by_reverse, 0.0 - by_forward
    store(x.current, i, s * plain)
    store(x.device_slope, i, devices * by_drain)
    store(x.device_slope, n + i, devices * kappa * by_gate)
    store(x.device_slope, 2 * n + i, devices * by_source)


@compiled(forceinline=True)
def _junction(c: Wiring, x: Team, i: int, side: int, devices: Lanes) -> None:
    """Current of a junction of transistor i, at side 0 (drain) or 1, and its slopes times `devices`."""
    n = c.polarity.size
    s = c.polarity[i]
    v_j, v_b = load(x.v, c.terminal[2 * side, i]), load(x.v, c.terminal[3, i])
    per_volt, total = 2.0 * _term(c, x, TERM.inverse_2ut, i), _term(c, x, TERM.leakage, i)
    u = per_volt * (s * (v_j - v_b))
    e = power_of_lanes(smaller(0.0 - u, every(_FORWARD)))
    taken, by_gate = 1.0 - e - e * larger(0.0 - u - _FORWARD, every(0.0)), every(0.0)
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
