"""Static currents of a ROLLS neuron over the voltage of its membrane, under the law with all its effects.

The same networks as in `chips.rolls.neuron.membrane`, each solved with the Early effect of the drains where
they stand, body effect, mobility reduction and the junctions' leakage (`chips.rolls.lumped.whole`).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from chips.rolls.lumped.grid import integral, interpolated
from chips.rolls.lumped.whole import amplifier, coupling, diode, fed_diode, pair, points_of, rows_of, series
from circuits.arrays import F64, Bools
from circuits.lowering.on_die import DieDevices

TYPICAL_INPUT = 1e-9  # A, ours: at which the input's node stands for the drains that end there
WEAKEST = 1e-12  # A, ours: at which the pair's share is that of a weak input
_NO_SHARE = 1e-12  # least share of a weak current that the membrane gets; ours
MIDDLE = 0.3  # V, ours: of the membrane, at which currents that are tabulated over another voltage are taken
LEAST = 1e-12  # share of the adaptation's pair, ours: below it none passes
NEAR = 0.75  # of v_mem where a spike begins, ours: where the slopes of what follows it are taken
DROPPED = 0.2  # V, ours: of v_o1 below the supply where a spike begins
_HALVINGS = 50


class WholeMembrane:
    """Static currents of n neurons over a grid of v_mem, A, float64[n, points]; v: the grid, V.

    What several of them are made of is solved once.
    """

    def __init__(self, d: DieDevices, v: F64) -> None:
        """Take the devices `d` of the neurons, and the grid."""
        self.d, self.v, self._over_v = d, v, d.columns()

    def _points(self, value: F64 | float) -> F64:
        return points_of(value, *self.v.shape)

    def _rows(self, device: str) -> F64:
        return rows_of(self.d.fet[device])

    def _series(self, lower: str, upper: str, gates: tuple[F64 | float, F64 | float], drain: F64) -> F64:
        """Current of two devices in series; gates: of the lower and of the upper one, V."""
        out = np.empty(self.v.shape)
        low, high = (self._points(gate) for gate in gates)
        series(self._rows(lower), self._rows(upper), low, high, self._points(drain), out)
        return out

    def leak(self, select: Bools) -> F64:
        """Return the current of both branches of the leak; select: whether tau1 is on, else tau2, bool[n]."""
        total = np.zeros(self.v.shape)
        for bias, low, switch, on in (
            ("v_tau1", "leak.ml3", "leak.ml5", select),
            ("v_tau2", "leak.ml4", "leak.ml6", ~select),
        ):
            gates = self.d.gate[bias], np.where(on, self.d.v_dd, 0.0)
            total += self._series(low, switch, gates, self.v)
        return total

    def off(self) -> F64:
        """Return the off current of the reset transistor."""
        return self._over_v.current("reset.mk8", 0.0, self.v)

    def feedback(self) -> F64:
        """Return the sodium feedback: the mirrored current of the nFET whose source is at v_shift."""
        return self._feedback

    @cached_property
    def _feedback(self) -> F64:
        return self._over_v.current("sodium.mn4", self.mirrored(), self.d.v_dd - self.v)

    def mirrored(self) -> F64:
        """Return how far the gate of the feedback's mirror is below the supply, V."""
        out = np.empty(self.v.shape)
        drawing, mirror = self._rows("sodium.mn1"), self._rows("sodium.mn3")
        source = self._points(self.d.gate["v_shift"])
        fed_diode(drawing, mirror, self._points(self.v), source, self.d.v_dd, out, 0.0)
        return out

    def drop(self) -> F64:
        """Return how far v_o1 is below the supply as mc1 and mc2 hold it, V."""
        return self._drop

    @cached_property
    def _drop(self) -> F64:
        out = np.empty(self.v.shape)
        rows = self._rows("reset.mc1"), self._rows("reset.mc2")
        gates = self._points(self.v), self._points(self.d.below("v_buf"))
        amplifier(*rows, *gates, self.d.v_dd, out)
        return out

    def pull(self) -> F64:
        """Return what mc4 brings while v_o1 falls."""
        return self._over_v.current("reset.mc4", self.drop(), self.d.v_dd - self.v)

    def approach(self) -> F64:
        """Return what more v_o1 lets into the adaptation's pair than at rest."""
        gates, far = (self.drop(), self.d.below("v_ahw")), np.asarray(0.6 * self.d.v_dd)
        found = self._series("adaptation.ma1", "adaptation.ma2", gates, far)
        return np.asarray(found - found[:, :1])

    def nmda(self, current: float) -> F64:
        """Return what the NMDA gate's mirrors bring into the input; current: into the gate, A."""
        d, source, passed, gate = self.d, *(np.empty(self.v.shape) for _ in range(3))
        names = "nmda_gate.mg2", "nmda_gate.mg1"
        gates = self._points(d.v_dd - self.v), self._points(d.below("v_nmda"))
        # mg1's drain is at a diode of mg4
        drains = self._points(d.v_dd), self._points(d.v_dd - MIDDLE)
        first, second = (self._rows(name) for name in names)
        pair(first, second, gates, drains, self._points(current), source)
        through = d.columns().current(names[1], gates[1], drains[1], source)
        diode(self._rows("nmda_gate.mg4"), np.maximum(through, 0.0), d.v_dd, passed)
        fed_diode(
            self._rows("nmda_gate.mg5"), self._rows("nmda_gate.mg6"), passed, self._points(0.0), d.v_dd, gate,
            0.0,
        )  # fmt: skip
        return self._over_v.current("nmda_gate.mg7", gate, self._typical_drop)

    @cached_property
    def _typical_drop(self) -> F64:
        return self.input_drop()

    def input_drop(self, total: float = TYPICAL_INPUT) -> F64:
        """Return how far the input's node is below the supply while `total` (A) flows into the pair, V."""
        d, out = self.d, np.empty(self.v.shape)
        gates, drains = self._pair()
        rows = self._rows("leak.ml1"), self._rows("leak.ml2")
        pair(*rows, gates, drains, self._points(total), out)
        return np.asarray(np.minimum(out, d.v_dd))

    def _pair(self) -> tuple[tuple[F64, F64], tuple[F64, F64]]:
        """Gates and drains of the leak's pair, V below the supply."""
        d, inside = self.d, self._points(self.d.v_dd - self.v)
        return (self._points(d.below("v_thr")), inside), (self._points(d.v_dd), inside)

    def direct(self) -> F64:
        """Return I_dc, whose device ends at the input's node, and what the pair's junctions bring there."""
        d, over = self.d, self._over_v
        brought = over.current("leak.ml9", self._points(d.below("v_dc")), self._typical_drop)
        return np.asarray(brought + _leaking(d, "leak.ml1", "leak.ml2")[:, None])

    def inside(self) -> F64:
        """Return the pinch-off voltage (U_T) that the membrane's device of the pair has beside the other's.

        With it the law of weak inversion shares a weak current as the whole law does.
        """
        return self._inside

    @cached_property
    def _inside(self) -> F64:
        over = self._over_v
        source, (gates, drains) = self.input_drop(WEAKEST), self._pair()
        silent = over._replace(
            fet={n: f._replace(law=f.law.without_leakage()) for n, f in over.fet.items() if "ml" in n}
        )
        first, second = (
            silent.current(name, gate, drain, source)
            for name, gate, drain in zip(("leak.ml1", "leak.ml2"), gates, drains, strict=True)
        )
        ratio = second / first * (over.fet["leak.ml1"].current / over.fet["leak.ml2"].current)
        # a membrane that is nearer to the supply than the input's node gets nothing of it
        return np.asarray(self.ground()[:, None] + np.log(np.maximum(ratio, _NO_SHARE)))

    def ground(self) -> F64:
        """Return the pinch-off voltage of the pair's other device, U_T, float64[n]."""
        return np.broadcast_to(self.d.pinch("leak.ml1", self.d.below("v_thr")), self.d.copies).copy()

    def reverse(self) -> F64:
        """Return what a device that draws from the membrane draws at v, over what it draws at `MIDDLE`."""
        over, gate = self._over_v, self._points(0.5)
        drawn = over.current("adaptation.ma6", gate, self.v)
        return np.asarray(drawn / over.current("adaptation.ma6", gate, MIDDLE))

    def couplings(self) -> tuple[float, float, float]:
        """Return kappa of mn1, of mn3, and of the membrane's device of the leak's pair, below a spike."""
        d, v = self.d, NEAR * self.v[:, -1]
        gate = d.gate_for("sodium.mn3", self.feedback()[:, round(NEAR * (self.v.shape[1] - 1))])
        sensing, mirror = coupling(d, "sodium.mn1", v), coupling(d, "sodium.mn3", gate)
        return sensing, mirror, coupling(d, "leak.ml2", d.v_dd - v)


def whole_adaptation(d: DieDevices, ahp: F64) -> tuple[F64, F64]:
    """Net current into v_ahp at rest (A) and share of a spike's that the pair passes, float64[n, points].

    ahp: v_ahp, V.
    """
    shape, over = (d.copies, ahp.size), d.columns()
    lower, upper, first, second = (rows_of(d.fet[f"adaptation.ma{k}"]) for k in (1, 2, 3, 4))
    on, weight = points_of(0.0, *shape), points_of(d.below("v_ahw"), *shape)
    inside, supply = points_of(d.v_dd - ahp[None, :], *shape), points_of(d.v_dd, *shape)
    gates, drains = (points_of(d.below("v_athr"), *shape), inside), (supply, inside)
    leaking = _leaking(d, "adaptation.ma3", "adaptation.ma4")[:, None]
    # the pair's source is what I_ahw's device ends at: a current by its drain twice, which leaves 1e-4 of it,
    # first with the same drain all over v_ahp
    begun, rest, source = np.empty((d.copies, 1)), np.empty(shape), np.empty(shape)
    once = [points_of(x, d.copies, 1) for x in (0.0, d.below("v_ahw"), 0.6 * d.v_dd)]
    series(lower, upper, once[0], once[1], once[2], begun)
    pair(first, second, gates, drains, points_of(begun + leaking, *shape), source)
    series(lower, upper, on, weight, source, rest)
    pair(first, second, gates, drains, rest + leaking, source)
    resting = over.current("adaptation.ma4", inside, inside, source)
    # a spike's current is that of I_ahw's device
    spiking = over.current("adaptation.ma2", weight, 0.6 * d.v_dd)
    pair(first, second, gates, drains, spiking, source)
    passed = over.current("adaptation.ma4", inside, inside, source) / spiking
    return resting - over.current("adaptation.ma5", over.gate["v_ahtau"], ahp), np.asarray(passed)


def taken_in(share: F64, ahp: F64, kick: F64) -> F64:
    """Return the share of a spike's charge that v_ahp gets while its pair closes, float64[n, points].

    share: of a current, over v_ahp (`ahp`, V); kick: V of v_ahp where all of it enters, float64[n].
    """
    found, over = np.empty_like(share), np.broadcast_to(ahp, share.shape)
    needed = integral(over, 1.0 / np.maximum(share, LEAST))
    wanted = needed + kick[:, None]
    for k in range(kick.size):
        interpolated(wanted[k], needed[k], ahp, found[k])
    return np.asarray((found - ahp) / kick[:, None])


def _leaking(d: DieDevices, *names: str) -> F64:
    """What the source junctions of devices let through, far from forward bias and from their gates, A."""
    return np.asarray(sum(d.fet[name].law.junction_leakage * d.fet[name].width for name in names))


def whole_balance(d: DieDevices) -> F64:
    """Return v_mem at which v_o1 has fallen by `DROPPED`, where a spike begins, V."""
    given = np.broadcast_to(d.current("reset.mc2", d.below("v_buf"), DROPPED), d.copies)
    low, high = np.zeros(d.copies), np.full(d.copies, d.v_dd)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        above = d.current("reset.mc1", middle, d.v_dd - DROPPED) > given
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return high
