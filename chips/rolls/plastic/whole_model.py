"""Plastic synapses and learning circuits under the law with all its effects.

As `chips.rolls.plastic.model`, each current at the drain where it ends (`chips.rolls.lumped.whole`):

    jump:       I depends on w by the Early effect, `I (1 - a (w - v_dd / 2))` upwards, so that a pulse of
                length t moves w by `(1 - e^(-a I t / C_w)) / a (1 - a (w - v_dd / 2))`
    drift:      the currents at w half-way between the middle of the supply and the rail to which it drifts,
                the junctions' leaks in them
    threshold:  where the first stage brings the second one to its own balance
                (`chips.rolls.plastic.comparator`)
"""

from __future__ import annotations

import numpy as np

from chips.rolls.lumped.whole import points_of, rows_of, series
from chips.rolls.plastic.comparator import Comparator, inputs_at_balance
from chips.rolls.synapse.whole_weight import HELD, joined
from circuits.arrays import F64
from circuits.devices.ekv import argument
from circuits.lowering.on_die import DieDevices

AROUND = 0.3  # V, ours: around the middle of the supply, over which a current's slope by w is taken
NEARER = 0.25  # of the supply, ours: of w from its rail where its drift is taken
_ROUNDS = 3  # of a gate and the drain's effect on its current


def moved_by(d: DieDevices, device: str, gate: F64) -> tuple[F64, float]:
    """Return the current that moves a weight at the middle of the supply, A, and its share by w, 1/V.

    gate: of the device, V from its bulk.
    """
    half = 0.5 * d.v_dd
    near, middle, far = (d.current(device, gate, half + x) for x in (-AROUND, 0.0, AROUND))
    return middle, float(np.mean((far - near) / (2.0 * AROUND * middle)))


def softness(d: DieDevices, names: tuple[str, ...]) -> tuple[float, float]:
    """Return the shares by their node's voltage of the calcium's copies and of their thresholds, 1/V.

    names: of the thresholds. A copy's gate is near that of the filter's threshold.
    """
    copies = [moved_by(d, f"mk_{name}", d.below("v_cathr"))[1] for name in names]
    thresholds = [moved_by(d, f"ms_{name}", d.gate[f"v_{name}"])[1] for name in names]
    return float(np.mean(copies)), float(np.mean(thresholds))


def shut(d: DieDevices) -> tuple[F64, F64]:
    """Return what the stacks that move a weight up, and down, leak while both switches are shut, A."""
    return _shut(d, "mu", d.below("v_up")), _shut(d, "md", d.gate["v_dn"])


def drifts(d: DieDevices, leaks: tuple[F64, F64]) -> tuple[F64, F64]:
    """Return what drives a weight up where it is high, and down where it is low, A; leaks: of `shut`."""
    up, down = (leaks[0] - leaks[1] + _junctions(d, w * d.v_dd) for w in (1.0 - NEARER, NEARER))
    rising, falling = d.below("v_driftup"), d.gate["v_driftdn"]
    high, low = (1.0 - NEARER) * d.v_dd, NEARER * d.v_dd
    rise = d.current("mr2", rising, d.v_dd - high) - _series(d, ("mr3", "mr4"), (0.0, falling), high)
    fall = d.current("mr4", falling, low) - _series(d, ("mr1", "mr2"), (0.0, rising), d.v_dd - low)
    return np.asarray(rise + up), np.asarray(fall - down)


def one_open(d: DieDevices, leaks: tuple[F64, F64]) -> tuple[F64, F64]:
    """Return what stacks leak more where one of their switches is on, A: upwards and downwards.

    leaks: of `shut`.
    """
    above, below = leaks
    return (
        np.asarray(d.current("mu1", 0.0, _far(d, "mu3", d.below("v_up"), above)) - above),
        np.asarray(d.current("md1", 0.0, _far(d, "md3", d.gate["v_dn"], below)) - below),
    )


def _junctions(d: DieDevices, w: float) -> F64:
    """What the stacks' junctions at w (V) bring, A."""
    above = junction(d, "mu3", d.below("v_up"), d.v_dd - w)
    return np.asarray(above - junction(d, "md3", d.gate["v_dn"], w))


def _shut(d: DieDevices, stack: str, gate: F64) -> F64:
    """What the two shut switches of a stack leak into its third device, A; gate: of that one, V."""
    names, found = (f"{stack}1", f"{stack}2"), np.full(d.copies, 1e-15)
    for _ in range(2):
        found = _series(d, names, (0.0, 0.0), _far(d, f"{stack}3", gate, found))
    return found


def _far(d: DieDevices, device: str, gate: F64, current: F64) -> F64:
    """Where the source of a device that carries `current` (A) is, V from the rail."""
    source = d.pinch(device, gate) - argument(np.maximum(current, 1e-21) / d.fet[device].current)
    return np.asarray(np.clip(d.u_t * source, 0.0, d.v_dd))


def junction(d: DieDevices, device: str, gate: F64 | float, drain: F64 | float) -> F64:
    """Return what a device's junction at its drain takes to the bulk, A."""
    return d.current(device, gate, drain, drain)


def _series(
    d: DieDevices, names: tuple[str, str], gates: tuple[F64 | float, F64 | float], drain: F64 | float
) -> F64:
    """Current of two devices in series, the lower one first, A."""
    out = np.empty((d.copies, 1))
    low, high, far = (points_of(x, d.copies, 1) for x in (*gates, drain))
    series(rows_of(d.fet[names[0]]), rows_of(d.fet[names[1]]), low, high, far, out)
    return out[:, 0].copy()


def whole_sunk(d: DieDevices, switches: tuple[str, str], sink: str, gate: str, line: float) -> F64:
    """Return what a transistor draws from a line (V) through two switches that are on, A.

    gate: its bias port.
    """
    out = np.empty((d.copies, 1))
    low, high, far = (points_of(x, d.copies, 1) for x in (d.gate[gate], d.v_dd, line))
    series(rows_of(d.fet[sink]), joined(d, *switches), low, high, far, out)
    return out[:, 0].copy()


def idle_through(d: DieDevices, switch: str) -> F64:
    """Return what a switch to a line leaks between pulses, A."""
    return d.current(switch, 0.0, HELD * d.v_dd, d.gate["v_shift"])


def weight_threshold(d: DieDevices) -> F64:
    """Return the voltage of a weight at which its comparator turns, V."""
    half = 0.5 * d.v_dd
    wanted = d.current("mb7", d.gate["v_cmp"], half)
    gate = d.gate_for("mb6", wanted)
    for _ in range(_ROUNDS):
        gate = d.gate_for("mb6", wanted * d.saturated("mb6", gate) / d.current("mb6", gate, half))
    names, gates = ("mb1", "mb3", "mb2", "mb5", "mb4"), (d.gate["v_cmp"], d.gate["v_wthr"])
    return inputs_at_balance(_comparator(d, names, gates, d.v_dd - gate, (0.0, 1.0)))


def membrane_threshold(d: DieDevices) -> F64:
    """Return the voltage of a membrane at which its comparator turns, V."""
    names, gates = ("mm1", "mm3", "mm2", "mm4", "mm5"), (d.gate["v_mcmp"], d.gate["v_memthr"])
    return inputs_at_balance(_comparator(d, names, gates, d.inverter_threshold("mq1"), (1.0, 0.0)))


def _comparator(
    d: DieDevices, names: tuple[str, ...], gates: tuple[F64, F64], output: F64, diode: tuple[float, float]
) -> Comparator:
    n = d.copies
    return Comparator(
        np.array([rows_of(d.fet[name]) for name in names]),
        np.array([np.broadcast_to(g, n) for g in gates]), np.broadcast_to(output, n).copy(), diode, d.v_dd,
        d.u_t,
    )  # fmt: skip
