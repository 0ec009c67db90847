"""Static currents of a ROLLS neuron over the voltage of its membrane, and the capacitance of the membrane.

Everything but v_mem is at rest: each chain of devices is solved with the EKV law on a grid of v_mem.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from chips.rolls.lumped.network import amplifier, diode, pair, stack
from circuits.arrays import F64, Bools, in_rows
from circuits.devices.softplus import inverse_softplus_of
from circuits.lowering.on_die import DieDevices


class Membrane:
    """Static currents of n neurons over a grid of v_mem, A, float64[n, points]; v: the grid, V.

    What several of them are made of is solved once.
    """

    def __init__(self, d: DieDevices, v: F64) -> None:
        """Take the devices `d` of the neurons, and the grid."""
        self.d, self.v, self._over_v = d, v, d.columns()

    def _flat(self, x: F64 | float) -> F64:
        """One a neuron, or one a point, as one a point."""
        x = np.asarray(x, dtype=np.float64)
        return in_rows(np.broadcast_to(x if x.ndim == 2 else np.reshape(x, (-1, 1)), self.v.shape).ravel())

    def _at(self, device: str, gate: F64 | float) -> tuple[F64, F64]:
        """Specific current and pinch-off voltage of a device, one a point."""
        gate = np.asarray(gate, dtype=np.float64)
        gate = gate if gate.ndim == 2 else np.reshape(gate, (-1, 1))
        return self._flat(self.d.fet[device].current), self._flat(self._over_v.pinch(device, gate))

    def _new(self) -> F64:
        return np.empty(self.v.size)

    def leak(self, select: Bools) -> F64:
        """Return the current of both branches of the leak; select: whether tau1 is on, else tau2, bool[n]."""
        total = np.zeros(self.v.shape)
        for bias, low, switch, on in (
            ("v_tau1", "leak.ml3", "leak.ml5", select),
            ("v_tau2", "leak.ml4", "leak.ml6", ~select),
        ):
            out = self._new()
            gate = np.where(on, self.d.v_dd, 0.0)
            stack(
                *self._at(low, self.d.gate[bias]),
                *self._at(switch, gate),
                self._flat(self.v) / self.d.u_t,
                out,
            )
            total += out.reshape(self.v.shape)
        return total

    def off(self) -> F64:
        """Return the off current of the reset transistor."""
        return self._over_v.channel("reset.mk8", 0.0, self.v)

    def feedback(self) -> F64:
        """Return the sodium feedback: the mirrored current of the nFET whose source is at v_shift."""
        return self._feedback

    @cached_property
    def _feedback(self) -> F64:
        drawn = self._over_v.saturated("sodium.mn1", self.v, self._over_v.gate["v_shift"])
        x = self._diode("sodium.mn3", np.ascontiguousarray(drawn.ravel()))
        return self._over_v.saturated("sodium.mn4", x)

    def _diode(self, device: str, current: F64) -> F64:
        """Voltage across a diode-connected transistor, V, float64[n, GRID]."""
        fet, out = self.d.fet[device], self._new()
        u_t = self.d.u_t
        diode(
            self._flat(fet.current),
            self._flat(fet.threshold / u_t),
            fet.kappa,
            current,
            self.d.v_dd / u_t,
            out,
        )
        return u_t * out.reshape(self.v.shape)

    def drop(self) -> F64:
        """Return how far v_o1 is below the supply as mc1 and mc2 hold it, V."""
        return self._drop

    @cached_property
    def _drop(self) -> F64:
        d, out = self.d, self._new()
        amplifier(
            *self._at("reset.mc1", self.v), *self._at("reset.mc2", d.below("v_buf")), d.v_dd / d.u_t, out
        )
        return np.asarray(out.reshape(self.v.shape) * d.u_t)

    def pull(self) -> F64:
        """Return what mc4 brings while v_o1 falls."""
        return self._over_v.saturated("reset.mc4", self.drop())

    def approach(self) -> F64:
        """Return what more v_o1 lets into the adaptation's pair than at rest."""
        d, out = self.d, self._new()
        stack(
            *self._at("adaptation.ma1", self.drop()), *self._at("adaptation.ma2", d.below("v_ahw")),
            self._flat(np.full_like(self.v, 0.6 * d.v_dd / d.u_t)), out,
        )  # fmt: skip
        found = out.reshape(self.v.shape)
        return np.asarray(found - found[:, :1])

    def nmda(self, current: float) -> F64:
        """Return what the NMDA gate's mirrors bring into the input; current: into the gate, A."""
        d, passed = self.d, self._new()
        pair(
            *self._at("nmda_gate.mg2", d.v_dd - self.v), *self._at("nmda_gate.mg1", d.below("v_nmda")),
            np.full(self.v.size, current), passed,
        )  # fmt: skip
        for diode_name, copy in (("nmda_gate.mg4", "nmda_gate.mg5"), ("nmda_gate.mg6", "nmda_gate.mg7")):
            passed = self._over_v.saturated(copy, self._diode(diode_name, passed)).ravel()
        return passed.reshape(self.v.shape)

    def couplings(self) -> tuple[float, float, float]:
        """Return kappa of mn1, of mn3, and of the membrane's device of the leak's pair."""
        fet = self.d.fet
        return fet["sodium.mn1"].kappa, fet["sodium.mn3"].kappa, fet["leak.ml2"].kappa

    def direct(self) -> F64:
        """Return I_dc, float64[n, 1]."""
        return np.broadcast_to(self.d.saturated("leak.ml9", self.d.below("v_dc")), self.d.copies)[:, None]

    def inside(self) -> F64:
        """Return the pinch-off voltage of the membrane's device of the leak's pair, U_T."""
        kappa = self.d.fet["leak.ml2"].kappa
        return self.d.pinch("leak.ml2", self.d.v_dd)[:, None] - kappa * self.v / self.d.u_t

    def ground(self) -> F64:
        """Return the pinch-off voltage of the pair's other device, U_T, float64[n]."""
        return np.broadcast_to(self.d.pinch("leak.ml1", self.d.below("v_thr")), self.d.copies).copy()

    def reverse(self) -> F64:
        """Return what a device that draws from the membrane draws at v, over what it draws in saturation."""
        return np.asarray(-np.expm1(-self.v / self.d.u_t))


def membrane_capacitance(couplings: tuple[float, float, float], c: F64) -> tuple[float, float, float]:
    """Return the coefficients (F) of C(v) = fixed + linear share + square share^2.

    share is the part of the input that enters the membrane. nf follows v_mem by -(kappa_n / kappa_p); a
    charge that nf takes is missing in the mirror. i_in follows by kappa_p times the share, and passes the
    share on. couplings: kappa of mn1, of mn3, and of the pair; c: capacitance matrix of the neuron's nodes,
    F.
    """
    k_n, k_m, k_p = couplings
    slope = np.array([1.0, -k_n / k_m])
    weight = np.array([1.0, -1.0])
    return float(weight @ c[:2, :2] @ slope), float((1.0 + k_p) * c[0, 2]), float(k_p * c[2, 2])


def balance(d: DieDevices) -> F64:
    """Return v_mem at which mc1 carries what mc2 gives in saturation, V."""
    mc1 = d.fet["reset.mc1"]
    given = np.broadcast_to(d.saturated("reset.mc2", d.below("v_buf")), d.copies)
    # as `gate_for`, in the form that no current overflows
    root = inverse_softplus_of(np.sqrt(given / mc1.current))
    return np.asarray(mc1.threshold + d.u_t / mc1.kappa * 2.0 * root)
