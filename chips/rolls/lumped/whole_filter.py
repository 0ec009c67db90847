"""Filters of a ROLLS chip under the law with all its effects, in the form of `chips.rolls.lumped.filter`.

`x = start + depth / fold`, depth = v_dd - v_syn, is the logarithm of I_1 / I_2 where v_syn is at v_thr, and a
measure of v_syn elsewhere. Over it the mean of a kind's filters is solved once: how the pair divides what the
synapses draw, the leak with its Early effect, the line that follows v_syn by kappa_n as it is there, and the
output as its node has it. A step reads the same tables as under the ideal law. What one filter differs by is
to first order, by the slopes where v_syn is at work.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.whole import coupling, diode, middle_of, pair, terms_at
from chips.rolls.synapse.whole_kernel import (
    FIRST_GATE,
    MD1,
    MD2,
    MD3,
    MD5,
    MD6,
    MD7,
    ROUNDS,
    SAME_GATE,
    TAU,
    THR,
)
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import pinched
from circuits.devices.packable import even_channel, even_leaked
from circuits.lowering.on_die import DieDevices

INPUT, MEMBRANE = 0.75, 0.3  # V, ours: of the nodes into which excitatory and inhibitory filters flow
ABOVE = 4.0  # e-folds of I_1 / I_2, ours: of a filter at work, where its time constant is taken
SATURATED = 0.25  # V, ours: depth from which the leak is out of its triode region
DEEPEST = 1e8  # I_1 / I_2, ours: beyond what the table of a filter's charge reaches
CUT_OFF = -10.0  # V, a gate at which a device carries nothing
BESIDE, _POINTS = 2.0, 257  # e-folds, ours: around the wanted ratios, and points of a curve there
LEAKAGE, INDUCED = 9, 10  # rows of a device's numbers


class WholeFilter(NamedTuple):
    """The mean of a kind's filters: its devices as `WholeFilters` has them, at one place, without junctions.

    rows: float64[6, TERMS, 1]; gates: float64[2, 1]; ends: supply and the output's node, V; mirrored:
    whether the output is; leak: I_tau with v_syn at v_thr, A; specific: I_S of md5, A; line: C_line / C.
    """

    rows: F64
    gates: F64
    ends: tuple[float, float]
    mirrored: bool
    leak: float
    specific: float
    line: float
    start: float
    fold: float  # V


class Own(NamedTuple):
    """What is each filter's own, float64[n]: as the fields of `Filter` that have these names."""

    leak: F64
    start: F64
    scale: F64
    specific: F64


def at_work(d: DieDevices) -> float:
    """Return where v_syn typically is while its output is large, V."""
    gate = float(d.gate["v_thr"])
    return gate - ABOVE * d.u_t / coupling(d, "md2", gate)


def slopes(d: DieDevices) -> tuple[float, float]:
    """Return kappa of the pair and of the output where v_syn typically is."""
    gate = at_work(d)
    return coupling(d, "md2", gate), coupling(d, "md5", d.v_dd - gate)


def own_of(d: DieDevices, *, inhibitory: bool) -> Own:
    """Return what is each filter's own; inhibitory: whether the output passes a mirror."""
    u_t, gate = d.u_t, float(d.gate["v_thr"])
    k_n, k_p = slopes(d)
    md1, md2, md5 = (d.fet[name] for name in ("md1", "md2", "md5"))
    start = np.log(md1.current / md2.current) + d.pinch("md1", gate) - d.pinch("md2", gate)
    start = start - (d.v_dd - gate) * k_n / u_t
    lower = k_p / u_t * (md5.threshold - md5.threshold.mean()) + k_p / k_n * (start - start.mean())
    specific = md5.current.copy()
    if inhibitory:
        md6, md7 = d.fet["md6"], d.fet["md7"]
        kappa = coupling(d, "md6", float(np.mean(md6.gate_for(1e-10))))
        gain = np.log(md7.current / md6.current) + kappa / u_t * (md6.threshold - md7.threshold)
        specific *= np.exp(gain - gain.mean())
    leak = d.current("md3", d.below("v_tau"), d.v_dd - at_work(d))
    return Own(np.broadcast_to(leak, d.copies).copy(), start, np.exp(-lower), specific)


def whole_of(d: DieDevices, own: Own, line: float, *, inhibitory: bool) -> WholeFilter:
    """Return the mean of filters `d`; line: capacitance of the line over that at v_syn, a ratio."""
    numbers = (1, 2, 3, 5, 6, 7) if inhibitory else (1, 2, 3, 5, 5, 5)
    rows = np.array([middle_of(d, f"md{k}") for k in numbers])
    rows[:, [LEAKAGE, INDUCED]] = 0.0
    gates = np.array([[float(d.gate["v_thr"])], [float(d.below("v_tau"))]])
    end = MEMBRANE if inhibitory else INPUT
    return WholeFilter(
        rows, gates, (d.v_dd, end), inhibitory, float(own.leak.mean()), float(own.specific.mean()), line,
        float(own.start.mean()), d.u_t / slopes(d)[0],
    )  # fmt: skip


class Curves(NamedTuple):
    """What a filter does over x, float64[points].

    ratio: `(1 + I_1 / I_2) I_tau / I_tau0 - 1`; density: dz/dx; output: E, with which the output's current is
    `I_S ln^2(1 + sqrt(E))`.
    """

    ratio: F64
    density: F64
    output: F64


def curves_of(f: WholeFilter, drawn: float, x: F64) -> Curves:
    """Return the curves of a filter whose synapses draw `drawn`, A, in their pulses, over x."""
    found, shape = np.empty((3, x.size)), (1, x.size)
    depth = f.fold * (x - f.start)
    inside, source = np.reshape(f.ends[0] - depth, shape), np.empty(shape)
    gates = np.full(shape, f.gates[THR, 0]), inside
    drains = np.full(shape, f.ends[0]), inside
    pair(f.rows[MD1], f.rows[MD2], gates, drains, np.full(shape, drawn), source)
    ratio, leak, kappa = found
    _fill(f, depth, source[0], ratio, leak, kappa)
    current = _outputs(f, depth)
    # deeper, v_syn would be below its line: no charge brings it there
    end = int(np.argmax(ratio > DEEPEST)) if (ratio > DEEPEST).any() else x.size
    ratio[end:] = DEEPEST * np.exp(x[end:] - x[min(end, x.size - 1)])
    density = 1.0 + ratio + kappa * f.line / (1.0 + ratio)
    return Curves((1.0 + ratio) * leak - 1.0, density, np.expm1(np.sqrt(current / f.specific)) ** 2)


def output_at(f: WholeFilter, drawn: float, ratio: F64) -> F64:
    """Return E of the mean filter where `(1 + I_1 / I_2) I_tau / I_tau0 - 1` is `ratio`, in its shape.

    drawn: by the synapses, A. E is as in `Curves`.
    """
    x = np.log(ratio)
    grid = np.linspace(x.min() - BESIDE, x.max() + BESIDE, _POINTS)
    curves = curves_of(f, drawn, grid)
    at = np.interp(x, np.log(curves.ratio), grid)
    return np.asarray(np.exp(np.interp(at, grid, np.log(curves.output))))


@compiled()
def _fill(f: WholeFilter, depth: F64, source: F64, ratio: F64, leak: F64, kappa: F64) -> None:
    """Fill I_1 / I_2, I_tau over that at v_thr but for its triode region, and kappa_n."""
    md1, md2, md3 = terms_at(f.rows[MD1], 0), terms_at(f.rows[MD2], 0), terms_at(f.rows[MD3], 0)
    supply, gate, own, leaking = f.ends[0], f.gates[THR, 0], f.gates[TAU, 0], f.leak
    for j in range(depth.size):
        v = supply - depth[j]
        first = even_channel(md1, supply, gate, source[j])[0]
        second = even_channel(md2, v, v, source[j])[0]
        ratio[j] = first / second if second * DEEPEST > first else 2.0 * DEEPEST
        leak[j] = even_channel(md3, max(depth[j], SATURATED), own, 0.0)[0] / leaking
        kappa[j] = pinched(md2, v)[1]


@compiled()
def _fill_drained(rows: F64, drain: F64, gate: F64, out: F64) -> None:
    """Fill the current into a drain, A, with the source at the bulk; rows: of one device."""
    t = terms_at(rows, 0)
    for j in range(out.size):
        out[j] = even_channel(t, drain[j], gate[j], 0.0)[0] + even_leaked(t, drain[j], gate[j])[0]


def _drained(rows: F64, drain: F64 | float, gate: F64) -> F64:
    out = np.empty(gate.size)
    _fill_drained(rows, np.broadcast_to(drain, gate.shape).copy(), gate, out)
    return out


def _outputs(f: WholeFilter, depth: F64) -> F64:
    """The output's current at each depth, A: `chips.rolls.synapse.whole_kernel.output` of all at once."""
    supply, held = f.ends
    if not f.mirrored:
        return _drained(f.rows[MD5], supply - held, depth)
    gate, left = np.full(depth.size, FIRST_GATE * supply), np.arange(depth.size)
    for _ in range(ROUNDS):
        drawn = _drained(f.rows[MD5], supply - gate[left], depth[left])
        new = np.empty((left.size, 1))
        diode(np.repeat(f.rows[MD6], left.size, axis=1), drawn[:, None], supply, new)
        moved = ~(np.abs(new[:, 0] - gate[left]) < SAME_GATE)
        left = left[moved]
        if left.size == 0:
            break
        gate[left] = new[moved, 0]
    return _drained(f.rows[MD7], held, gate)


def whole_line_voltage(f: WholeFilter, current: float) -> float:
    """Return where the line stands while `current` (A) passes through md1, V."""
    return held_line(f.rows[MD1], f.gates[THR, 0], f.ends[0], current)


def held_line(md1: F64, gate: float, supply: float, current: float) -> float:
    """Return what `whole_line_voltage` does; md1: its numbers at one place; gate, supply: V."""
    one, out = np.ones((1, 1)), np.empty((1, 1))
    gates, drains = (gate * one, CUT_OFF * one), (supply * one, supply * one)
    pair(md1, md1, gates, drains, current * one, out)
    return float(out[0, 0])
