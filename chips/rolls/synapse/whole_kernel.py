"""The two equations of ROLLS' synaptic filter under the law with all its effects, compiled.

`C (dv_syn, dv_line)/dt = (I_tau + J_3 - I_2 - J_2, I_1 + I_2 - I_w - J_line)`, J of junctions: each current
is the law's at its drain (`circuits.devices.channel`). `chips.rolls.synapse.kernel` steps them.
"""

from __future__ import annotations

from chips.rolls.lumped.whole import diode_voltage, terms_at
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel, leaked

MD1, MD2, MD3, MD5, MD6, MD7 = range(6)  # rows of devices
THR, TAU = range(2)  # rows of gates: V, and V below the supply
ROUNDS = 12  # of a mirror and what draws on it
FIRST_GATE, SAME_GATE = 0.25, 1e-9  # of the supply, where a mirror is begun; V, of its last move
_compiled = compiled(fastmath={"contract"})
_Six = tuple[float, float, float, float, float, float]


@_compiled
def currents(rows: F64, gates: F64, k: int, v_dd: float, node: tuple[float, float]) -> _Six:
    """Net currents into v_syn and into the line, A, and their derivatives by either, S, row by row.

    node: v_syn and the line, V.
    """
    v, y = node
    md1, md2, md3 = terms_at(rows[MD1], k), terms_at(rows[MD2], k), terms_at(rows[MD3], k)
    i1, _, _, by_y1 = channel(md1, v_dd, gates[THR, k], y)
    i2, by_d2, by_g2, by_y2 = channel(md2, v, v, y)
    i3, by_d3, _, _ = channel(md3, v_dd - v, gates[TAU, k], 0.0)
    j1, by_j1, _ = leaked(md1, y, gates[THR, k])
    j2, by_j2, by_jg2 = leaked(md2, y, v)
    jd, by_jd, by_jgd = leaked(md2, v, v)
    j3, by_j3, _ = leaked(md3, v_dd - v, gates[TAU, k])
    by_s2 = by_d2 + by_g2
    return (
        i3 + j3 - i2 - jd, i1 + i2 - j1 - j2, -by_d3 - by_j3 - by_s2 - by_jd - by_jgd, -by_y2,
        by_s2 - by_jg2, by_y1 + by_y2 - by_j1 - by_j2,
    )  # fmt: skip


@_compiled
def _into(t: Terms, drain: float, gate: float) -> float:
    """Current into a drain whose source is at the bulk, A; V above the bulk."""
    return channel(t, drain, gate, 0.0)[0] + leaked(t, drain, gate)[0]


@_compiled
def output(
    rows: F64,
    k: int,
    depth: float,
    ends: tuple[float, float],
    mirrored: bool,  # noqa: FBT001
) -> float:
    """Return I_syn with v_syn at rest `depth` V below the supply, A, positive for both signs.

    ends: voltages of the supply and of the node into which it flows, V; mirrored: whether md6 and md7 follow.
    """
    supply, held = ends
    md5 = terms_at(rows[MD5], k)
    if not mirrored:
        return _into(md5, supply - held, depth)
    md6 = terms_at(rows[MD6], k)
    gate = FIRST_GATE * supply
    for _ in range(ROUNDS):
        new = diode_voltage(md6, _into(md5, supply - gate, depth), supply)
        if abs(new - gate) < SAME_GATE:
            break
        gate = new
    return _into(terms_at(rows[MD7], k), held, gate)
