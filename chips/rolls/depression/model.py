"""Short-term depression of ROLLS' synapses at behavioural level, with a die's own devices.

Of `circuits.blocks.rolls.depressing_synapse`, x the voltage of a weight's gate above its bias and
`R = e^(-x / U_T)`, one for each of the devices me2, me4 and me6 that a level turns on, since each has a cell:

    step:      d = (I t - Q) / C; the source's edge lifts the mirror's gate by delta, and until that is gone,
               with the time constant T = C_m U_T / (kappa I_m), the current is less:
               I t - Q = I T ln((y - 1 + e^(t / T)) / y),  y = e^(kappa delta / U_T), at any t of the pulse
    lift:      as the pulse begins, the source es of the weights comes up by D_s, from where they carried the
               off current of their switch, and the mirror's gate em by D_m: the gates of the weights are
               (C_s D_s + C_m D_m) / C higher until the pulse ends, whatever R is
    recovery:  dR/dt = (1 - R) / tau,  tau = C U_T / I_rec
    train:     R -> 1 - (1 - R e^(-d / U_T)) e^(-interval / tau)
    pulse:     share = sum I_S F(p - kappa x / U_T) / sum I_S F(p), the mean over the x of the pulse, which
               are those before it, the lift, and I t - Q over C
    charge:    of `chips.rolls.synapse.charge` (switch, mirror, its lateness) with all gates moved alike, as a
    cubic
               through SPENT of the share; exact at rest

I and I_rec are the die's, through its own mirrors. Nothing is fitted. Left out: that em comes up less where
the weights are depressed, and that gates that have moved apart share the switch otherwise.

Error on dies 1000 to 1004, all levels, default weights, 0, 27 and 60 degC, both kinds of bias, 8 pulses at
20, 100 and 500 Hz, steps of 0.1 to 2.4 U_T: of a charge over the first one 0.004 at the worst, 0.0007 in the
median; of a charge 0.8 % and 0.24 %. Level 1 of 2 nA: 0.011 and 3.0 %; of 0.6 nA, whose mirror does not come
up in a pulse, 0.033 and 9.5 %; a step of 5 U_T: 0.007 and 4.4 %.

A state is one synapse's, since the capacitors are: the synapses of a column see the same pulses, but those of
one sign and latch alone take steps, and each by its own devices. `chips.rolls.depression.kernel` has this in
a chip's steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from chips.rolls.depression.whole_cell import currents_of, slope_of, whole_rises
from chips.rolls.lumped.whole import middle_of
from chips.rolls.lumped.whole_filter import held_line
from chips.rolls.synapse.charge import QUIET, charge_of, draw_of, mirror_of, pulse_length
from chips.rolls.synapse.model import SynapseModel, model_of
from chips.rolls.synapse.weight import BITS, branches
from chips.rolls.synapse.whole_weight import HELD
from circuits.arrays import F64
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls.depressing_synapse import WEIGHTS, Params, build
from circuits.circuit import Bias, Circuit
from circuits.devices.ekv import argument, interpolation, steepness
from circuits.errors import ParameterError
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.capacitors_on_die import with_capacitors
from circuits.lowering.on_die import DieDevices, standing
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

DEVICES = dict(zip(WEIGHTS, ("me2", "me4", "me6"), strict=True))
CELL_DEVICES = ("ms1", "ms2", "ms3", "mr1", "mr2", "mr3")
POINTS, SHARES = np.polynomial.legendre.leggauss(4)  # of a pulse's mean
MIRRORED = 2.0  # electrons of noise that a step's diode and its bias add to one of its mirror
NEWTON = 8  # steps on the logarithm of a current, which is nearly a line
SPENT = (0.0, 0.7, 2.0, 5.0)  # x / U_T, ours: where a charge is computed; shares of about 1, 0.6, 0.3, 0.04


@dataclass(frozen=True, slots=True)
class CellModel:
    """Capacitances of a cell of depression, F."""

    gate: float  # at the weight's gate
    mirror: float  # at the gate of the step's mirror
    coupling: float  # from the step's source to that gate
    lifts: tuple[float, float]  # from es and from em to the weight's gate


@dataclass(frozen=True, slots=True)
class DepressionModel:
    """A depressing synapse that stands alone."""

    circuit: Circuit
    synapse: SynapseModel  # of its pulse and charge
    cell: CellModel


class Branches(NamedTuple):
    """The weight devices of a level that are on, float64[devices, n] each unless said.

    path: x above that before the pulse at POINTS of it, V, float64[points, devices, n]; electrons: of shot
    noise that an electron of a step has, `1 + 2 [1 - (T / t)(1 - e^(-t / T))]`, as T takes some off those of
    its diode and bias; rest: of the gate above its bias, which leaks let it rest at, V.
    """

    step: F64  # V
    tau: F64  # s
    pinch: F64  # kappa (v_g - V_T0) / U_T at rest
    current: F64  # I_S, A
    kappa: float
    u_t: float  # V
    path: F64
    electrons: F64
    rest: F64

    @property
    def mean(self) -> F64:
        """Mean of `path`, V, float64[devices, n]."""
        return np.tensordot(0.5 * SHARES, self.path, 1)

    @property
    def variance(self) -> F64:
        """Variance of `path`, V^2, float64[devices, n]."""
        return np.tensordot(0.5 * SHARES, (self.path - self.mean) ** 2, 1)


class Depression(NamedTuple):
    """Synapses of a level on a die.

    curve: coefficients of the charge (C) over powers of the share, float64[n, 4].
    """

    branches: Branches
    curve: F64


def cell_model(params: Params, process: Process) -> CellModel:
    """Return the capacitances of a cell in a process."""
    c = capacitance_matrix(build(params), process, ("depression_exc.step", "depression_exc.s"))
    gate = capacitance_matrix(build(params), process, ("w_exc", "synapse.es", "synapse.em"))
    lifts = -float(gate[0, 1]), -float(gate[0, 2])
    return CellModel(float(gate[0, 0]), float(c[0, 0]), -float(c[0, 1]), lifts)


def depression_model(params: Params, biases: Sequence[Bias], process: Process) -> DepressionModel:
    """Prepare the model of a depressing synapse with these biases."""
    circuit = replace(build(params), biases=tuple(biases))
    synapse = model_of(dpi_synapse.build(params.synapse), process)
    return DepressionModel(circuit, synapse, cell_model(params, process))


def depression_on(model: DepressionModel, silicon: Silicon, level: int = 1) -> Depression:
    """Return the synapse of `model` at `level` on a silicon.

    Raises `ParameterError` unless that is 1 to 4.
    """
    _check_level(level)
    d = with_capacitors(standing(model.circuit, silicon), model.circuit, silicon)
    line = _line(d, draw_of(model.synapse, d, level, HELD * d.v_dd).current)
    return depression_of(model.cell, model.synapse, d, level, line, pulse_length(model.synapse, d))


def _line(d: DieDevices, current: F64) -> float:
    """Where the filter's line stands while `current` (A) passes through its pair, V."""
    if d.full:
        gate = float(d.gate["v_ethr"])
        return held_line(middle_of(d, "excitatory.md1"), gate, d.v_dd, float(np.mean(current)))
    held = d.pinch("excitatory.md1", d.gate["v_ethr"])
    return d.u_t * float(np.mean(held - argument(current / d.fet["excitatory.md1"].current)))


def depression_of(
    cell: CellModel, synapse: SynapseModel, d: DieDevices, level: int, line: float, length: F64
) -> Depression:
    """Return the synapses `d`, with their cells, at `level`.

    line: of their filter's line, V; length: of their pulses, s. Raises `ParameterError` for a level that does
    not excite.
    """
    _check_level(level)
    on = (True, *BITS[level - 1])
    names = [name for name, each in zip(WEIGHTS, on, strict=True) if each]
    cells = [_cell(cell, d, name, length) for name in names]
    step, tau, moved, electrons, rest = zip(*cells, strict=True)
    slope, gates = slope_of(d), np.array([_gate(cell, d, name) for name in names])
    if d.full:
        resting = {f"v_{name}": d.gate[f"v_{name}"] + x for name, x in zip(names, rest, strict=True)}
        d = d._replace(gate={**d.gate, **resting})
    path = np.array(moved).swapaxes(0, 1) + _lift(cell, synapse, d, level) / gates
    own = [f"synapse.{DEVICES[name]}" for name in names]
    pinch = [
        np.broadcast_to(d.pinch(o, d.below(f"v_{n}")), d.copies) for o, n in zip(own, names, strict=True)
    ]
    current = [d.fet[each].current for each in own]
    found = Branches(
        np.array(step), np.array(tau), np.array(pinch), np.array(current), slope, d.u_t, path,
        np.array(electrons), np.array(rest),
    )  # fmt: skip
    return Depression(found, _curve(found, synapse, d, level, line, length))


def _check_level(level: int) -> None:
    if level not in (1, 2, 3, 4):
        raise ParameterError(f"level: {level}, must be 1 to 4; inhibitory weights are not depressed")


def _cell(cell: CellModel, d: DieDevices, name: str, length: F64) -> tuple[F64, F64, F64, F64, F64]:
    """Step (V) and time constant (s) of a weight's cells, the step at POINTS (V), its electrons, the rest."""
    own, gate = currents_of(d, name), _gate(cell, d, name)
    constant = cell.mirror * d.u_t / (own.kappa * own.drawn)
    # the source comes from the weight's bias to the supply
    lift = cell.coupling * d.below(f"v_{name}") / (own.drawn * constant)
    # ln(e^lift - 1 + e^(t / T)) - lift, of which the exponentials may be beyond a float
    shares = np.array((*(0.5 + 0.5 * POINTS), 1.0))[:, None]
    late = np.logaddexp(np.log(-np.expm1(-lift)), shares * length / constant - lift)
    moved = own.step * constant * late / gate
    slow = length / constant
    electrons = 1.0 + MIRRORED * (1.0 + np.expm1(-slow) / slow)
    tau, rest = gate * d.u_t / (own.recovery + own.leak), d.u_t * np.log1p(own.leak / own.recovery)
    return moved[-1], tau, moved[:-1], electrons, rest


def _gate(cell: CellModel, d: DieDevices, name: str) -> F64:
    """Capacitance at a weight's gate, F, float64[n]."""
    return np.broadcast_to(cell.gate + d.added(f"depression_{name}.c_w"), d.copies)


def _lift(cell: CellModel, synapse: SynapseModel, d: DieDevices, level: int) -> F64:
    """What comes onto the gates of the weights in a pulse, C."""
    bits = BITS[level - 1]
    if d.full:
        es, em = whole_rises(d, bits, QUIET, synapse.mirror_capacitance)
        return np.asarray(cell.lifts[0] * es + cell.lifts[1] * em)
    pairs = branches(d, "e", bits)
    mirror = mirror_of(synapse, d, np.array([x for pair in pairs for x in pair]))
    y = _source(pairs, mirror.off) - _source(pairs, mirror.given)
    em = mirror.high - mirror.before
    return np.asarray(cell.lifts[0] * d.u_t * y + cell.lifts[1] * em)


def _source(pairs: list[tuple[F64, F64]], total: F64) -> F64:
    """Where the source of weights that carry `total` (A) together is below the supply, U_T."""
    y = np.zeros_like(total)
    for _ in range(NEWTON):
        sums = np.zeros((2, *total.shape))
        for current, pinch in pairs:
            f = interpolation(pinch - y)
            sums += current * np.array((f, f * steepness(f)))
        y += np.log(sums[0] / total) * sums[0] / sums[1]
    return y


def _curve(b: Branches, synapse: SynapseModel, d: DieDevices, level: int, line: float, length: F64) -> F64:
    shares, charges = [], []
    for spent in SPENT:
        moved = {f"v_{name}": d.gate[f"v_{name}"] + spent * d.u_t for name in WEIGHTS}
        shares.append(share_of(b, np.full_like(b.pinch, spent)))
        # the line is where the filter's pair carries the current
        higher = line - d.u_t * float(np.log(shares[-1]).mean())
        drawn = draw_of(synapse, d._replace(gate={**d.gate, **moved}), level, higher)
        charges.append(charge_of(drawn, length))
    powers = np.stack(shares, axis=1)[:, :, None] ** np.arange(len(SPENT))
    return np.asarray(np.linalg.solve(powers, np.stack(charges, axis=1)[:, :, None])[:, :, 0])


def share_of(b: Branches, spent: F64) -> F64:
    """Return the sum of the weights' currents over that at rest, float64[n, ...].

    spent: x / U_T, float64[devices, n, ...].
    """
    shape = (*b.pinch.shape, *(1,) * (spent.ndim - 2))
    rest, current = b.pinch.reshape(shape), b.current.reshape(shape)
    now = (current * interpolation(rest - b.kappa * spent)).sum(axis=0)
    return np.asarray(now / (current * interpolation(rest)).sum(axis=0))


def resources(b: Branches, events: Sequence[float]) -> F64:
    """Return R that pulses at `events` (s, rising) find, float64[devices, n, events]; the first finds 1."""
    kept = np.exp(-b.step / b.u_t)
    found = np.ones((*b.step.shape, len(events)))
    for k in range(1, len(events)):
        interval = events[k] - events[k - 1]
        found[..., k] = 1.0 - (1.0 - found[..., k - 1] * kept) * np.exp(-interval / b.tau)
    return found


def charges(on: Depression, resource: F64) -> F64:
    """Return the charge of pulses that find R, C, float64[n, ...] of R's shape behind its devices."""
    b = on.branches
    path = (b.path / b.u_t).reshape(*b.path.shape, *(1,) * (resource.ndim - 2))
    spent = -np.log(resource)
    share = np.zeros(resource.shape[1:])
    for moved, weight in zip(path, SHARES, strict=True):
        share += 0.5 * weight * share_of(b, spent + moved)
    powers = share[..., None] ** np.arange(len(SPENT))
    curve = on.curve.reshape(on.curve.shape[0], *(1,) * (share.ndim - 1), len(SPENT))
    return np.asarray(np.maximum((powers * curve).sum(axis=-1), 0.0))
