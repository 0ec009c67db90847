"""The codes by which a network is written to the NEF chip, and what they are worth at a temperature.

Codes are chosen where the chip is calibrated and then stay: at another temperature the same codes are other
currents, the same filters have other time constants, and decoders are those that were solved before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from chips.nef.chip import (
    CODE,
    EVENTS,
    INPUT_BITS,
    MOST_COLUMNS,
    WEIGHT_BITS,
    Conditions,
    check_columns,
    check_filters,
    check_room,
)
from chips.nef.devices import POWER
from chips.nef.kernel import ChipNet
from chips.nef.network.kernel import DT, Net
from chips.nef.population import Population
from chips.nef.whole.filter import LOG_S
from chips.nef.whole.kernel import Bends
from circuits.arrays import F64, I64, Bools

_LEVELS = 2 ** (INPUT_BITS - 1)
_FINE = 16 * _LEVELS  # of a middle: accumulators have four bits more than converters, which follow on average


class Row(NamedTuple):
    """Stages of a slot: currents a unit of x, thresholds, float64[n]; its full scale.

    Columns that it takes.
    """

    values: F64
    full: float
    columns: int


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Codes of a network: of biases, int64[n] a population, and of stages, int64[columns, n] a slot.

    calibrated: the chip for which they were chosen; net: with the decoders as quantised; tau: s,
    float64[lanes]; analog: whether a lane is a filter of the chip; full: full scale, float64[lanes]; line: of
    a slot, int64[slots]; cut: how many stages should give more than their highest code does; span: of a
    filter's output over that of one without deviations, by which its converter's step is set, float64[lanes].
    """

    calibrated: Conditions
    net: Net
    bias: tuple[I64, ...]
    stages: tuple[tuple[I64, ...], ...]
    tau: F64
    analog: Bools
    full: F64
    line: I64
    cut: int
    span: F64


def row_of_currents(values: F64, chip: Conditions) -> Row:
    """Return the stages of a slot of currents; at its full scale the neuron that takes most is full."""
    most = float(np.abs(values).max(initial=0.0))
    full = CODE * MOST_COLUMNS * chip.power * chip.unit / most if most else 1.0
    return Row(values, full, MOST_COLUMNS)


def place(
    net: Net, populations: Sequence[Population], rows: Sequence[Sequence[Row]], tau: F64, chip: Conditions
) -> Placed:
    """Choose the codes of a network; raises `ParameterError` for what the chip has no room for."""
    names = [p.ensemble.name for p in populations]
    for name, p, held in zip(names, populations, rows, strict=True):
        dimensions = p.ensemble.dimensions
        check_columns(name, dimensions, len(held) - dimensions)
        check_room(name, p.first + p.ensemble.neurons, chip.chip)
    analog = net.goes >= 0
    check_filters(int(analog.sum()))
    stages = tuple(tuple(chip.codes(r.values, r.full, r.columns) for r in held) for held in rows)
    cut = sum(
        int((np.abs(r.values) * r.full > (CODE * r.columns + 0.5) * chip.power * chip.unit).sum())
        for held in rows
        for r in held
    )
    full_of_slot = np.array([r.full for held in rows for r in held])
    full = np.where(analog, full_of_slot[np.maximum(net.goes, 0)] if full_of_slot.size else 1.0, 1.0)
    placed = Placed(
        chip, net._replace(decoder=_quantised(net)), tuple(chip.bias_codes(p.bias) for p in populations),
        stages, tau, analog, full, _lines_of(populations, stages), cut, np.ones(len(analog)),
    )  # fmt: skip
    return replace(placed, span=_spans(placed)) if chip.full else placed


def at(placed: Placed, populations: Sequence[Population], chip: Conditions) -> ChipNet:
    """Return what the codes are worth on the chip as it is now."""
    net, law = placed.net, chip.law.head(len(placed.net.bias))
    bias, sunk = np.empty_like(net.bias), np.empty_like(net.bias)
    above, below = np.empty_like(net.encoder), np.empty_like(net.encoder)
    at_row = 0
    for p, codes, held in zip(populations, placed.bias, placed.stages, strict=True):
        n, column = p.ensemble.neurons, 1
        there = slice(p.first, p.first + n)
        bias[there], sunk[there] = chip.standing(p.first, codes, [row for stage in held for row in stage])
        for stage in held:
            own = slice(at_row, at_row + n)
            above[own], below[own] = chip.stage(p.first, column, stage)
            at_row += n
            column += len(stage)
    where = placed.analog
    tau, gain, scale = np.where(where, placed.tau, 1.0), np.ones(len(where)), np.ones(len(where))
    now = chip.filters(placed.tau[where])
    tau[where], gain[where] = now.tau, now.gain
    scale[where] = _middles(placed)
    lines = np.stack([part[placed.line] for part in chip.lines[:3]])
    lines[1:, np.setdiff1d(np.arange(lines.shape[1]), net.goes)] = 0.0  # of no signal: switched off
    return ChipNet(
        net=net._replace(bias=bias, encoder=above, keep=np.where(where, np.exp(-DT / tau), net.keep)),
        below=below,
        sunk=sunk,
        lines=lines,
        first=_firsts(net.goes, placed.tau),
        leak=law.leak,
        speed=1.0 / law.charge,
        refractory=law.refractory,
        floor=law.floor,
        step=np.where(where, placed.span * placed.full / _LEVELS, 0.0),
        levels=_LEVELS - 1.0,
        scale=scale,
        gain=gain,
        power=POWER,
        home=np.repeat(np.arange(len(populations)), [p.ensemble.neurons for p in populations]).astype(
            np.int64
        ),
        budget=round(EVENTS * DT / 1e-3),
    )


def _lines_of(populations: Sequence[Population], stages: Sequence[Sequence[I64]]) -> I64:
    """Numbers of the slots' lines: vectors have the first ones, and currents into neurons what follows."""
    after = sum(p.ensemble.dimensions for p in populations)
    found: list[int] = []
    for p, held in zip(populations, stages, strict=True):
        d = p.ensemble.dimensions
        found += [p.line + k for k in range(d)]
        found += [after + k for k in range(len(held) - d)]
        after += len(held) - d
    return np.array(found, dtype=np.int64)


def _firsts(goes: I64, tau: F64) -> Bools:
    """Whether a lane is the filter that brings its slot the middle: the slowest, as curves are measured."""
    order = np.lexsort((-tau, goes))
    found = np.zeros(len(goes), dtype=np.bool_)
    found[order[np.unique(goes[order], return_index=True)[1]]] = True
    return found & (goes >= 0)


def _middles(placed: Placed) -> F64:
    """What converters are set to, so that each filter's middle is its line's reference, in their steps.

    A slot's first filter makes up for the line as well; lines and filters are as they were calibrated.
    """
    filters = placed.calibrated.filters(placed.tau[placed.analog])
    return np.asarray(np.rint(filters.scale_for(_references(placed)) * _FINE) / _FINE)


def _references(placed: Placed) -> F64:
    """What each filter's middle is set to, full scales, float64[filters]."""
    where, chip = placed.analog, placed.calibrated
    number = placed.line[placed.net.goes[where]]
    return np.where(_firsts(placed.net.goes, placed.tau)[where], chip.lines.zero[number], 1.0)


def _spans(placed: Placed) -> F64:
    """By what each filter's output swings more than one without deviations on its line, float64[lanes].

    A die's filters bend unlike each other, by some per mille, and a memory drifts by as much each time
    constant. So the converters' steps make up for it, as they do for the middles. Curves are measured with a
    filter whose middle is the line's reference, so that all filters of the line should swing as that one.
    """
    chip, found = placed.calibrated, np.ones(len(placed.analog))
    own = chip.filters(placed.tau[placed.analog])
    found[placed.analog] = own.swing(own.scale_for(_references(placed)))
    reference = chip.lines.zero[placed.line[placed.net.goes[placed.analog]]]
    slowest = _slowest(placed)
    for tau in np.unique(slowest):
        like = np.flatnonzero(placed.analog)[slowest == tau]
        usual = chip.typical(tau).repeated(len(like))
        found[like] /= usual.swing(usual.scale_for(reference[slowest == tau]))
    return found


def _slowest(placed: Placed) -> F64:
    """Longest time constant of the filters of each filter's slot, s, float64[filters]."""
    slots = placed.net.goes[placed.analog]
    longest = np.zeros(int(slots.max(initial=0)) + 1)
    np.maximum.at(longest, slots, placed.tau[placed.analog])
    return longest[slots]


def bends_of(placed: Placed, chip: Conditions) -> Bends | None:
    """Return what the law bends in a network on a chip, None under the law without second-order effects."""
    where, law = placed.analog, chip.law.head(len(placed.net.bias))
    curves, shape = chip.filters(placed.tau[where]).curves, chip.lines.shape
    if curves is None or shape is None:
        return None
    output, keep = np.zeros((2, len(where), LOG_S.size))
    output[where], keep[where] = curves.output, np.exp(-DT / curves.tau)
    return Bends(output, keep, shape, law.rise, law.mirrored, np.zeros_like(law.rise))


def with_decoders(placed: Placed, net: Net) -> Placed:
    """Return the same codes with decoders that were solved anew."""
    return replace(placed, net=net._replace(decoder=_quantised(net)))


def _quantised(net: Net) -> F64:
    """Decoding weights in the steps that the chip's memory has, a scale for each population and lane."""
    found = net.decoder.copy()
    most = 2 ** (WEIGHT_BITS - 1) - 1
    for p in range(len(net.begin) - 1):
        lanes, n = net.lane[p + 1] - net.lane[p], net.begin[p + 1] - net.begin[p]
        block = found[net.block[p] : net.block[p] + n * lanes].reshape(n, lanes)
        step = np.abs(block).max(axis=0, initial=0.0) / most
        block[:] = np.rint(block / np.where(step > 0.0, step, 1.0)) * step
    return found
