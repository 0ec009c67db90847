"""A network of values on a die, in a form that can be followed backwards: rates in the place of spikes.

Its parts are the die's own, as the chip's model has them. In a step of `h` s, with f of the step before,

    converter   c = clip(sum of T f / (span full), -1, 1),  span full: what the lane's converter takes
    filter      z <- z + (1 - e^(-h / tau)) (c - z),        tau: the die's
    line        y = sum of Y(z) - zero,  p = above bend(y) or n = below bend(-y), as the sign of y is
    neuron      J = bias + sum of (a p + b n),  r = 1 / (t_ref + Q / E(J - leak))
    decoder     f = r D,  D: solved of the curves that were measured on the die

E is the current that charges as fast as one that falls while the membrane rises, by what leak and mirrors
draw more:  E = R / ln(1 + R / e),  e = J - leak - R / 2. Followed backwards are

    dr/de = r^2 Q / (e (e + R)),  dr/dR at e = r^2 Q (1 - E / (e + R)) / (E R)

and for e below `SOFT`, where the first grows without end, the mean slope from 0 to there. What is clipped has
no way back. Left out are spikes with their ripple, the steps of converters and of decoding weights, noise,
what the router drops, and the time that a converter takes to catch up with what it clipped.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from chips.nef.build import Built
from chips.nef.chip import HEADROOM
from chips.nef.kernel import ChipNet
from chips.nef.model import NeuronLaw
from chips.nef.network.kernel import DT
from chips.nef.whole.filter import LOG_S
from chips.nef.whole.kernel import Bends
from chips.nef.whole.line import APART
from circuits.arrays import F64, Bools
from circuits.errors import ParameterError
from system.mapping.nef.network import ValueNetwork

SOFT = 0.05  # thresholds above a neuron's rheobase, below which its slope is the mean one; ours
POINTS = 257  # of a filter's output over what it gets; ours
_LEAST = 1e-9  # of s and of R, from which on a logarithm is taken


class Table(NamedTuple):
    """Values at evenly spaced points, float64[rows, points], from `low` on, `step` apart; straight beyond."""

    low: float
    step: float
    values: F64

    def at(self, x: F64) -> tuple[F64, F64]:
        """Return values and slopes at x, float64[samples, rows]."""
        k = np.clip(((x - self.low) / self.step).astype(np.int64), 0, self.values.shape[1] - 2)
        rows = np.arange(self.values.shape[0])
        below = self.values[rows, k]
        slope = (self.values[rows, k + 1] - below) / self.step
        return below + slope * (x - self.low - k * self.step), slope


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """An ensemble on a die; n neurons, d numbers.

    leak, charge, refractory, rise, bias, sunk : in thresholds and s, soft : mean slope below `SOFT`, Hz a
    threshold, float64[n]; mirrored : a share; up, down : currents of its stages, float64[d, n]; zero, above,
    below : of its lines, float64[d]; bend : of all of them.
    """

    leak: F64
    charge: F64
    refractory: F64
    rise: F64
    soft: F64
    mirrored: float
    bias: F64
    sunk: F64
    up: F64
    down: F64
    zero: F64
    above: F64
    below: F64
    bend: Table


@dataclass(frozen=True, slots=True, eq=False)
class Lane:
    """What comes to an ensemble with one time constant, of d numbers.

    group : number of the ensemble; full : at which converters clip, float64[d]; tau : s, float64[d];
    output : of the filters over what they get, full scales.
    """

    group: int
    full: F64
    tau: F64
    output: Table


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """A connection, or a probe: group : that it decodes, -1 for an input; decoders : float64[n, results].

    lane : where it ends, -1 for a probe; channels : of an input; tau : of a probe's filter, s.
    """

    group: int
    decoders: F64
    lane: int = -1
    channels: slice = field(default_factory=lambda: slice(0))
    tau: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class ValueForm:
    """A network of values on a die: its ensembles, lanes, connections and probes, in the network's order."""

    groups: tuple[Group, ...]
    lanes: tuple[Lane, ...]
    ways: tuple[Way, ...]
    probes: tuple[Way, ...]


class Moment(NamedTuple):
    """What a step leaves for the way back.

    given : f of each connection; free : lanes whose converters do not clip; filters : slopes of their
    outputs; lines : derivatives of p and n by y, of each group; neurons : those of its rates by J and by R.
    """

    given: list[F64]
    free: list[Bools]
    filters: list[F64]
    lines: list[tuple[F64, F64]]
    neurons: list[tuple[F64, F64]]


def value_form(network: ValueNetwork, built: Built) -> ValueForm:
    """Return the form of a network on a die; built: the same there, with its decoders."""
    chip, placed, where = built.chip, built.placed, built.where
    if chip is None or placed is None or where is None:
        raise ParameterError("network: on ideal neurons, which have no form; build it on a chip")
    names = [e.name for e in network.ensembles]
    groups = tuple(
        _group(built.neurons(name), p, chip, built.bends, where.law) for p, name in enumerate(names)
    )
    ends = list(dict.fromkeys((c.target, c.synapse) for c in network.connections))
    lanes = []
    for target, synapse in ends:
        p = names.index(target)
        slots = range(chip.net.slot[p], chip.net.slot[p + 1])
        at = [int(np.flatnonzero((chip.net.goes == k) & (placed.tau == synapse))[0]) for k in slots]
        full = placed.span[at] * HEADROOM * network.ensembles[p].radius
        lanes.append(Lane(p, full, -DT / np.log(chip.net.keep[at]), _outputs(chip, built.bends, at)))
    ways = []
    for c, own in zip(network.connections, built.network.connections, strict=True):
        lane = ends.index((c.target, c.synapse))
        if c.source in names:
            ways.append(Way(names.index(c.source), built.solved[own][0], lane))
        else:
            ways.append(Way(-1, np.zeros((0, 0)), lane, built.given[c.source]))
    probes = tuple(
        Way(names.index(p.ensemble), built.solved[own][0], tau=p.synapse)
        for p, own in zip(network.probes, built.network.probes, strict=True)
    )
    return ValueForm(groups, tuple(lanes), tuple(ways), probes)


def _group(own: slice, p: int, chip: ChipNet, bends: Bends | None, law: NeuronLaw) -> Group:
    """Ensemble number p, whose neurons are `own`."""
    slots = slice(chip.net.slot[p], chip.net.slot[p + 1])
    rows = [slice(row, row + own.stop - own.start) for row in chip.net.row[slots].tolist()]
    rise = np.maximum(law.rise[own] + law.mirrored * chip.sunk[own], _LEAST)
    soft = rise / np.log1p(rise / SOFT)  # E at `SOFT`
    zero, above, below = chip.lines[:, slots]
    return Group(
        law.leak[own],
        law.charge[own],
        law.refractory[own],
        law.rise[own],
        1.0 / (law.refractory[own] + law.charge[own] / soft) / SOFT,
        law.mirrored,
        chip.net.bias[own],
        chip.sunk[own],
        np.stack([chip.net.encoder[row] for row in rows]),
        np.stack([chip.below[row] for row in rows]),
        zero,
        above,
        below,
        _bend(bends),
    )


def forward(
    form: ValueForm, matrices: tuple[F64, ...], inputs: F64, steps: int, step: float
) -> tuple[F64, list[Moment]]:
    """Run a form from rest; return the mean of each output, float64[samples, outputs], and the tape.

    matrices: T of each connection; inputs: float64[samples, channels]; steps: how many, of `step` s each.
    """
    count = len(inputs)
    z = [np.zeros((count, lane.tau.size)) for lane in form.lanes]
    given = [
        inputs[:, way.channels] if way.group < 0 else np.zeros((count, way.decoders.shape[1]))
        for way in form.ways
    ]
    shown = [np.zeros((count, probe.decoders.shape[1])) for probe in form.probes]
    told = [np.zeros_like(p) for p in shown]
    total = [np.zeros_like(p) for p in shown]
    tape: list[Moment] = []
    for _ in range(steps):
        moment = Moment(list(given), [], [], [], [])
        for j, probe in enumerate(form.probes):
            told[j] = told[j] + _fresh(probe.tau, step) * (shown[j] - told[j])
            total[j] += told[j]
        sums = [-np.ones((count, 1)) * group.zero for group in form.groups]
        for k, lane in enumerate(form.lanes):
            came = sum(
                (given[i] @ matrices[i].T for i, way in enumerate(form.ways) if way.lane == k),
                np.zeros((count, lane.tau.size)),
            )
            came = came / lane.full
            z[k] = z[k] + _fresh(lane.tau, step) * (np.clip(came, -1.0, 1.0) - z[k])
            y, slope = lane.output.at(z[k])
            sums[lane.group] += y
            moment.free.append(np.abs(came) < 1.0)
            moment.filters.append(slope)
        rates = []
        for group, y in zip(form.groups, sums, strict=True):
            bent, slope = group.bend.at(y)
            p, n = group.above * np.maximum(bent, 0.0), group.below * np.maximum(-bent, 0.0)
            r, by_j, by_rise = fired(group, p, n)
            rates.append(r)
            moment.lines.append(
                (
                    np.where(bent > 0.0, group.above * slope, 0.0),
                    np.where(bent < 0.0, -group.below * slope, 0.0),
                )
            )
            moment.neurons.append((by_j, by_rise))
        given = [
            g if way.group < 0 else rates[way.group] @ way.decoders
            for g, way in zip(given, form.ways, strict=True)
        ]
        shown = [rates[probe.group] @ probe.decoders for probe in form.probes]
        tape.append(moment)
    return np.concatenate(total, axis=1) / steps, tape


def backward(
    form: ValueForm, matrices: tuple[F64, ...], tape: list[Moment], by: F64, step: float
) -> tuple[F64, ...]:
    """Return the derivatives of a loss by the matrices; by: those by outputs, float64[samples, outputs]."""
    sizes = np.cumsum([probe.decoders.shape[1] for probe in form.probes])
    each = np.split(by / len(tape), sizes[:-1], axis=1)
    found = tuple(np.zeros_like(m) for m in matrices)
    count = len(by)
    told = [np.zeros_like(e) for e in each]  # derivatives by what probes show, and by the filters' z
    z = [np.zeros((count, lane.tau.size)) for lane in form.lanes]
    given = [np.zeros((count, way.decoders.shape[1])) for way in form.ways]  # by f, as of the step behind
    shown = [np.zeros_like(e) for e in each]
    for moment in reversed(tape):
        rates = [np.zeros((count, group.leak.size)) for group in form.groups]
        for way, back in zip((*form.ways, *form.probes), (*given, *shown), strict=True):
            if way.group >= 0:
                rates[way.group] += back @ way.decoders.T
        sums = [
            _through(group, back, lines, neurons)
            for group, back, lines, neurons in zip(
                form.groups, rates, moment.lines, moment.neurons, strict=True
            )
        ]
        for j, probe in enumerate(form.probes):
            fresh = _fresh(probe.tau, step)
            told[j] = each[j] + (1.0 - fresh) * told[j]
            shown[j] = fresh * told[j]
        for k, lane in enumerate(form.lanes):
            fresh = _fresh(lane.tau, step)
            z[k] = sums[lane.group] * moment.filters[k] + (1.0 - fresh) * z[k]
            came = fresh * z[k] * moment.free[k] / lane.full
            for i, way in enumerate(form.ways):
                if way.lane == k:
                    found[i][...] += came.T @ moment.given[i]
                    given[i] = came @ matrices[i]
    return found


def fired(group: Group, p: F64, n: F64) -> tuple[F64, F64, F64]:
    """Return rates of an ensemble's neurons, Hz, and their derivatives by J and by R, 1 / (threshold s).

    p, n: what its lines give, full scales, float64[samples, d]; all results are float64[samples, n].
    """
    current = group.bias + p @ group.up + n @ group.down
    rise = group.rise + group.mirrored * (group.sunk + p @ _mirrored(group.up) + n @ _mirrored(group.down))
    rise = np.maximum(rise, _LEAST)
    end = current - group.leak - 0.5 * rise
    above = np.maximum(end, _LEAST)
    charging = rise / np.log1p(rise / above)
    rate = np.where(end > 0.0, 1.0 / (group.refractory + group.charge / charging), 0.0)
    square, both = rate**2 * group.charge, above + rise
    by_end = np.where(end < SOFT, np.where(end > 0.0, group.soft, 0.0), square / (above * both))
    return rate, by_end, square * (1.0 - charging / both) / (charging * rise) - 0.5 * by_end


def _through(group: Group, rates: F64, lines: tuple[F64, F64], neurons: tuple[F64, F64]) -> F64:
    """Derivatives by y of a group's lines, of those by its rates."""
    by_j, by_rise = (rates * each for each in neurons)
    by_rise = group.mirrored * by_rise
    up = by_j @ group.up.T + by_rise @ _mirrored(group.up).T
    down = by_j @ group.down.T + by_rise @ _mirrored(group.down).T
    return lines[0] * up + lines[1] * down


def _mirrored(row: F64) -> F64:
    """What of a stage's current its mirror draws."""
    return np.maximum(-row, 0.0)


def _fresh(tau: F64 | float, step: float) -> F64:
    """What a filter takes of its input in a step, a share; all of it without a time constant."""
    return np.asarray(-np.expm1(-step / np.maximum(tau, _LEAST)))


def _outputs(chip: ChipNet, bends: Bends | None, at: list[int]) -> Table:
    """Outputs of filters over what they get, less the middle of those that are not a slot's first."""
    over = np.linspace(-1.0, 1.0, POINTS)
    s = np.maximum(chip.scale[at][:, None] * (1.0 + over), _LEAST)
    if bends is None:
        found = chip.gain[at][:, None] * s**chip.power
    else:
        found = np.stack(
            [np.exp(np.interp(np.log(row), LOG_S, bends.output[k])) for k, row in zip(at, s, strict=True)]
        )
    return Table(-1.0, 2.0 / (POINTS - 1), found - np.where(chip.first[at], 0.0, 1.0)[:, None])


def _bend(bends: Bends | None) -> Table:
    """What lines make of a sum, which is itself without second-order effects."""
    if bends is None:
        return Table(-1.0, 2.0, np.array([[-1.0, 1.0]]))
    return Table(float(APART[0]), float(APART[1] - APART[0]), bends.shape[None])
