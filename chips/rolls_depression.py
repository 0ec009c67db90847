"""Short-term depression of ROLLS synapses at behavioural level: R from event to event, with a die's devices.

Of `circuits.blocks.depressing_synapse`, x the gate's voltage above its bias and `R = e^(-x / U_T)`:

    step:      d = (I t - Q) / C; the source's edge lifts the mirror's gate by delta, and until that is gone,
               with the time constant T = C_m U_T / (kappa I_m), the current is less:
               I t - Q = I T ln((y - 1 + e^(t / T)) / y),  y = e^(kappa delta / U_T)
    recovery:  dR/dt = (1 - R) / tau,  tau = C U_T / I_rec
    train:     R -> 1 - (1 - R e^(-d / U_T)) e^(-interval / tau)
    pulse:     I_w / I_w0 of the weight's device, whole law, over the x that the pulse passes through

I and I_rec are the die's, through its own mirrors. The weight is the constant one (level 1). Nothing is
fitted. Left out: what the nodes es and em lift the gate by in a pulse (0.7 mV, the same in all), and how much
later a small current's mirror comes. Error on dies 1000 to 1004, 0, 27 and 60 degC, both kinds of bias,
trains at 20 and 100 Hz, as a share of the first pulse's charge: 0.012 at the worst, 0.0011 in the median.

A state is one synapse's, since the capacitor is: the synapses of a column see the same pulses, but those of
one sign and latch alone take steps, and each by its own devices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from chips.rolls_charge import pulse_length
from chips.rolls_devices import DieDevices, Part, capacitance_matrix, devices_on, interpolation, part_of
from chips.rolls_synapse_model import SynapseModel, model_of
from circuits.blocks import dpi_synapse
from circuits.blocks.depressing_synapse import Params, build
from circuits.circuit import Bias
from circuits.process import Process
from circuits.silicon import Silicon

F64 = NDArray[np.float64]

CELL = "depression_exc"
POINTS, SHARES = np.polynomial.legendre.leggauss(4)  # of a pulse's mean


@dataclass(frozen=True, slots=True)
class DepressionModel:
    """A depressing synapse; capacitances in F."""

    part: Part
    synapse: SynapseModel  # of its pulse
    gate: float  # at the weight's gate
    mirror: float  # at the gate of the step's mirror
    coupling: float  # from the step's source to that gate


class Depression(NamedTuple):
    """Synapses on a die, float64[n] each unless said."""

    step: F64  # V
    tau: F64  # s
    pinch: F64  # kappa (v_g - V_T0) / U_T of the weight's device at rest
    kappa: float
    u_t: float  # V


def depression_model(params: Params, biases: Sequence[Bias], process: Process) -> DepressionModel:
    """Prepare the model of a depressing synapse with these biases."""
    part = part_of(replace(build(params), biases=tuple(biases)), process)
    synapse = model_of(dpi_synapse.build(params.synapse), process)
    c = capacitance_matrix(part, (f"{CELL}.step", f"{CELL}.s"))
    gate = float(capacitance_matrix(part, ("w_exc",))[0, 0])
    return DepressionModel(part, synapse, gate, float(c[0, 0]), -float(c[0, 1]))


def depression_on(model: DepressionModel, silicon: Silicon) -> Depression:
    """The synapses of `model` on `silicon`."""
    d = devices_on(model.part, silicon)
    current = _through(d, d.saturated(f"{CELL}.ms1", d.gate["v_std"]), "ms2", "ms3")
    back = _through(d, d.saturated(f"{CELL}.mr1", d.gate["v_rec"]), "mr2", "mr3")
    return Depression(
        _moved(model, d, current) / model.gate,
        model.gate * d.u_t / back,
        np.broadcast_to(d.pinch("synapse.me2", d.below("v_exc")), d.copies),
        d.fet["synapse.me2"].kappa,
        d.u_t,
    )


def _through(d: DieDevices, current: F64, diode: str, copy: str) -> F64:
    """What a mirror makes of a current, A; weak inversion."""
    a, b = d.fet[f"{CELL}.{diode}"], d.fet[f"{CELL}.{copy}"]
    return np.asarray(current * b.current / a.current * np.exp(a.kappa * (a.threshold - b.threshold) / d.u_t))


def _moved(model: DepressionModel, d: DieDevices, current: F64) -> F64:
    """Charge of a step, C."""
    t = pulse_length(model.synapse, d)
    kappa, drawn = d.fet[f"{CELL}.ms2"].kappa, d.saturated(f"{CELL}.ms1", d.gate["v_std"])
    constant = model.mirror * d.u_t / (kappa * drawn)
    # the source comes from the weight's bias to the supply
    lift = kappa * model.coupling * d.below("v_exc") / (model.mirror * d.u_t)
    return np.asarray(current * constant * (np.log(np.expm1(lift) + np.exp(t / constant)) - lift))


def resources(on: Depression, events: Sequence[float]) -> F64:
    """R that pulses at `events` (s, rising) find, float64[n, events]; the first finds 1."""
    kept = np.exp(-on.step / on.u_t)
    found = np.ones((on.step.size, len(events)))
    for k in range(1, len(events)):
        interval = events[k] - events[k - 1]
        found[:, k] = 1.0 - (1.0 - found[:, k - 1] * kept) * np.exp(-interval / on.tau)
    return found


def depressed(on: Depression, resource: F64) -> F64:
    """Mean current of a pulse that finds R over that of the weight at rest, of R's shape (n first)."""
    spent = -np.log(resource)  # x / U_T
    shape = (-1, *(1,) * (resource.ndim - 1))
    per_step = (on.kappa * on.step / on.u_t).reshape(shape)
    rest = np.asarray(on.pinch).reshape(shape)
    total = np.zeros_like(spent)
    for point, share in zip(POINTS, SHARES, strict=True):
        total += 0.5 * share * interpolation(rest - on.kappa * spent - 0.5 * (1.0 + point) * per_step)
    return np.asarray(total / interpolation(rest))
