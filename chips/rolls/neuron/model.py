"""Behavioural model of ROLLS' neuron: an equation of v_mem and one of v_ahp, with a die's own devices.

All that is faster than the membrane is at rest at every moment: it is solved once a neuron over a grid of
v_mem, with the EKV law and the deviations of the very devices of the transistor level, and tabulated:

    C(v) dv_mem/dt = I_0(v) + S(v, J) - I_ahp(v_ahp) (1 - e^(-v / U_T)),   J = I_in + I_dc + I_gate(v)
    C_ahp dv_ahp/dt = A(v_ahp) + B(v_ahp) E(v_mem)

* I_0: sodium feedback, mc4's pull while v_o1 falls, both leak branches (each its bias transistor in series
  with its switch, so in triode near 0 V), and the off current of the reset;
* S: share of J that the pair of the leak lets into the membrane, solved from the law;
* I_gate: what the NMDA gate's mirrors bring into the input; i_nmda is constant;
* A: what the adaptation's pair brings at rest, less its leak; E: what more v_o1 lets into the pair as it
  falls towards the spike, B: the share of it that the pair passes on. A spike adds its whole charge at once.

A spike begins where mc1 nearly carries what mc2 can give; when it comes, how long v_mem is then at 0 V and
what the adaptation gets is run once a neuron (`chips.rolls.neuron.spike`). C(v) is the membrane's capacitance
and what the nodes that follow it add: nf by its slope, i_in by the share that goes on into the membrane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chips.rolls.lumped.network import pair, stack
from chips.rolls.neuron.kernel import GRID, NEURON_COLUMNS, Neurons, advance_neurons, rest_of
from chips.rolls.neuron.membrane import Membrane, balance, membrane_capacitance
from chips.rolls.neuron.spike import START, run_spikes
from chips.rolls.neuron.whole_membrane import MIDDLE, WholeMembrane, taken_in, whole_adaptation, whole_balance
from chips.rolls.neuron.whole_spike import BEFORE, run_whole_spikes
from circuits.arrays import F64, Bools
from circuits.blocks.rolls.neuron import RESTING
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.capacitors_on_die import with_capacitors
from circuits.lowering.on_die import DieDevices, array_of, standing
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

NODES = (
    "v_mem", "sodium.nf", "i_in", "v_ref", "v_ahp", "v_o1", "reset.k1", "reset.kp",
)  # fmt: skip
AHP_HIGH = 1.2  # V, ours: end of the grid of v_ahp, above what I_ahw of 1 uA reaches
ROOM = 4096  # spikes of a neuron that one call keeps


@dataclass(frozen=True, slots=True)
class NeuronModel:
    """A neuron, or an array of them, with the capacitances of NODES, F, float64[8, 8]."""

    circuit: Circuit
    array: str
    capacitance: F64


def model_of(circuit: Circuit, process: Process, array: str = "") -> NeuronModel:
    """Prepare the model of `circuit`, a ROLLS neuron, or of its instance array called `array`."""
    lone = array_of(circuit, array).circuit if array else circuit
    return NeuronModel(circuit, array, capacitance_matrix(lone, process, NODES))


def neurons_on(
    model: NeuronModel, silicon: Silicon, select: Bools | None = None, i_nmda: float = RESTING
) -> Neurons:
    """Return all neurons of the model on a silicon.

    select: whether the slower leak, tau1, is on, bool[n], off unless given; i_nmda: current into every NMDA
    gate, A.
    """
    d = standing(model.circuit, silicon, model.array)
    d = with_capacitors(d, model.circuit, silicon, inside=model.array)
    return neurons_of(d, model.capacitance, select, i_nmda)


def neurons_of(d: DieDevices, c: F64, select: Bools | None = None, i_nmda: float = RESTING) -> Neurons:
    """Return the neurons of the devices `d`; c: capacitances of NODES, F; the others as in `neurons_on`."""
    n, u_t = d.copies, d.u_t
    latch = np.zeros(n, np.bool_) if select is None else select
    top = whole_balance(d) if d.full else balance(d)
    v = np.linspace(0.0, 1.0, GRID)[None, :] * (top - START)[:, None]
    membrane = WholeMembrane(d, v) if d.full else Membrane(d, v)
    couplings = membrane.couplings()
    fixed, in_linear, in_square = membrane_capacitance(couplings, c)
    own = np.broadcast_to(fixed + d.added("leak.c_mem"), n)
    c_ahp = np.broadcast_to(c[4, 4] + d.added("adaptation.c_ahp"), n)
    ahp = np.linspace(0.0, AHP_HIGH, GRID)
    if d.full:
        quiet, share = whole_adaptation(d, ahp)
        drawn = d.columns().current("adaptation.ma6", ahp, MIDDLE)
    else:
        quiet, share = _adaptation(d, ahp)
        drawn = d.columns().saturated("adaptation.ma6", ahp)
    feedback, inside = membrane.feedback(), membrane.inside()
    drive = np.ascontiguousarray(feedback[:, -1])
    if d.full:
        drives = np.stack((WholeMembrane(d, v[:, -1:] - BEFORE).feedback()[:, 0], drive))
        spikes = run_whole_spikes(d, c, own, drives, top)
    else:
        spikes = run_spikes(d, c, own, drive, top)
    kick = spikes.charge / c_ahp
    return Neurons(
        u_t=np.full(n, u_t),
        top=top - START,
        table=_table(membrane, latch, i_nmda, c_ahp),
        ground_current=d.fet["leak.ml1"].current,
        ground_pinch=membrane.ground(),
        membrane_current=d.fet["leak.ml2"].current,
        membrane_pinch=inside[:, 0].copy(),
        kappa_p=np.full(n, couplings[2]),
        inside=inside,
        capacitance=own.copy(),
        input_linear=np.full(n, in_linear),
        input_square=np.full(n, in_square),
        quiet=quiet / c_ahp[:, None],
        share=share,
        taken=taken_in(share, ahp, kick) if d.full else share,
        drawn=drawn,
        ahp_step=np.full(n, ahp[1]),
        delay=spikes.delay,
        delay_exponent=spikes.exponent,
        delay_speed=feedback[:, -1] / own,
        refractory=spikes.refractory,
        kick=kick,
    )


def _table(membrane: Membrane | WholeMembrane, latch: Bools, i_nmda: float, c_ahp: F64) -> F64:
    """Columns over v_mem, float64[n, GRID, COLUMNS]."""
    columns = (
        membrane.feedback() + membrane.pull() - membrane.leak(latch) - membrane.off(),
        membrane.nmda(i_nmda) + membrane.direct(),
        np.exp(0.5 * (membrane.inside() - membrane.ground()[:, None])),
        membrane.reverse(),
        membrane.approach() / c_ahp[:, None],
    )
    return np.ascontiguousarray(np.stack(columns, axis=-1))


def _adaptation(d: DieDevices, ahp: F64) -> tuple[F64, F64]:
    """Net current into v_ahp at rest (A) and share of a spike's that the pair passes, float64[n, GRID]."""
    n, u_t = d.copies, d.u_t
    ma3, ma4 = d.fet["adaptation.ma3"], d.fet["adaptation.ma4"]
    over_ahp = d.columns()
    leak = over_ahp.channel("adaptation.ma5", over_ahp.gate["v_ahtau"], ahp)
    rest = np.empty(n)
    ma2 = np.broadcast_to(d.pinch("adaptation.ma2", d.below("v_ahw")), n).copy()
    stack(
        d.fet["adaptation.ma1"].current, d.pinch("adaptation.ma1", 0.0), d.fet["adaptation.ma2"].current, ma2,
        np.full(n, 0.6 * d.v_dd / u_t), rest,
    )  # fmt: skip
    ground = np.broadcast_to(d.pinch("adaptation.ma3", d.below("v_athr")), n)
    membrane = over_ahp.pinch("adaptation.ma4", d.v_dd - ahp)
    found = []
    # a spike's current is that of I_ahw's device
    for total in (rest, np.broadcast_to(d.saturated("adaptation.ma2", d.below("v_ahw")), n)):
        each = np.empty(n * ahp.size)
        pair(
            np.repeat(ma3.current, ahp.size), np.repeat(ground, ahp.size), np.repeat(ma4.current, ahp.size),
            membrane.ravel(), np.repeat(total, ahp.size), each,
        )  # fmt: skip
        found.append((each.reshape(n, -1), total))
    return found[0][0] - leak, found[1][0] / found[1][1][:, None]


@dataclass(frozen=True, slots=True)
class Response:
    """Spikes of each neuron, s, and v_mem at the ends of the steps, V, float64[steps, n]."""

    spikes: tuple[F64, ...]
    v_mem: F64


def at_rest(neurons: Neurons) -> F64:
    """Return the state of neurons that rest without input, float64[n, NEURON_COLUMNS]."""
    state = np.zeros((neurons.top.size, NEURON_COLUMNS))
    rest_of(neurons, state)
    return state


def respond(neurons: Neurons, current: F64, step: float, state: F64 | None = None) -> Response:
    """Return the response of neurons that rest at first, or that begin at `state`.

    current: into i_in, constant over a step, A, float64[steps, n]; step: s. Raises `ParameterError` for more
    than ROOM spikes of one neuron.
    """
    n = neurons.top.size
    state = at_rest(neurons) if state is None else state
    times, counts, v_mem = np.zeros((n, ROOM)), np.zeros(n, np.int64), np.zeros((current.shape[0], n))
    for k in range(current.shape[0]):
        advance_neurons(neurons, state, current[k], k * step, step, times, counts)
        v_mem[k] = state[:, 0]
    if counts.max(initial=0) > ROOM:
        raise ParameterError(f"response: {counts.max()} spikes, must be <= {ROOM}; end it earlier")
    return Response(tuple(times[k, : counts[k]].copy() for k in range(n)), v_mem)
