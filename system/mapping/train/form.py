"""A mapped network on several dies at once, in a form that can be followed backwards.

Forwards these are the equations of `system.mapping.dynamics`, each die with its own neurons, filters and
weights. Backwards a spike counts as the rate at which its neuron fires at the drive of that step,

    d(spike) / d(drive) = step * d(rate) / d(drive),   drive - 1 softened over `SOFT` about the rheobase

which is a straight line through the stairs of a count. Filters are linear but for the power of their output,
so that the way back through them is exact: with g the derivative of the loss,

    g_drive = g_spike rate' step,   g_S = fall g_S(next step) + g_drive dI/dS / unit
    g_spike = g_count + sum of weights^T g_S(next step),   g_weights = g_S (events or spikes)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, Bools
from system.mapping.dynamics import Cells, move
from system.mapping.rolls.mapped import Mapped
from system.mapping.rolls.neuron import period
from system.mapping.train.ratios import Ratios

SOFT = 0.2  # of a rheobase, about which a rate begins smoothly on the way back; ours
FLOOR = 1e-3  # of a filter's pivot, below which its slope grows no more; ours


class Weights(NamedTuple):
    """Jumps of S (A) that a filter's events bring, from neurons and from channels, [dies, n, sources]."""

    neurons: F64
    channels: F64


@dataclass(frozen=True, slots=True, eq=False)
class Bank:
    """A filter on several dies: sign, power and pivot (A) as of `Filter`, tau in s, float64[dies, 1, n]."""

    sign: float
    power: float
    pivot: float
    tau: F64


@dataclass(frozen=True, slots=True, eq=False)
class Form:
    """A mapped network's neurons and filters on several dies.

    cells : its neurons, float64[dies, 1, n] each; unit in A; banks : its filters, in the order of the mapped.
    """

    cells: Cells
    banks: tuple[Bank, ...]


class Tape(NamedTuple):
    """What a run leaves for the way back: of each step the filters' S, drives' slopes and the spikes.

    events : of channels, float64[steps, samples, channels]; spikes : those that are heard in each step.
    """

    step: float
    events: F64
    spikes: list[Bools]
    strengths: list[list[F64]]
    slopes: list[F64]


def form_of(mapped: Mapped, dies: tuple[Ratios, ...]) -> Form:
    """Return the form of a mapped network on some dies."""
    at, one = mapped.neurons, mapped.dynamics()

    def each(nominal: F64 | float, found: list[F64]) -> F64:
        return nominal * np.stack([ratio[at] for ratio in found])[:, None]

    cells = Cells(
        each(one.cells.tau, [d.tau for d in dies]),
        each(one.cells.unit, [d.rheobase for d in dies]),
        each(one.cells.refractory, [d.refractory for d in dies]),
        one.cells.constant,
        one.cells.slope,
    )
    banks = tuple(
        Bank(f.sign, f.power, f.pivot, each(f.tau, [d.filters[name.name] for d in dies]))
        for name, f in zip(mapped.filters, one.filters, strict=True)
    )
    return Form(cells, banks)


def forward(form: Form, weights: tuple[Weights, ...], events: F64, step: float) -> tuple[F64, Tape]:
    """Run a form from rest; return spikes of each neuron, float64[dies, samples, n], and the tape.

    weights: of each filter; events: of the channels in each step of `step` s.
    """
    shape = form.cells.tau.shape[0], events.shape[1], form.cells.tau.shape[2]
    v, wait, count = np.zeros((3, *shape))
    falls = [np.exp(-step / bank.tau) for bank in form.banks]
    state = [np.zeros(shape) for _ in form.banks]
    fired: Bools = np.zeros(shape, dtype=np.bool_)
    tape = Tape(step, events, [], [], [])
    for come in events:
        tape.spikes.append(fired)
        for k, w in enumerate(weights):
            state[k] = falls[k] * state[k] + come @ w.channels.swapaxes(1, 2)
            if w.neurons.any():
                state[k] += fired.astype(np.float64) @ w.neurons.swapaxes(1, 2)
        drive = _drive(form, state)
        fired, _ = move(form.cells, v, wait, drive, step)
        count += fired
        tape.strengths.append(list(state))
        tape.slopes.append(step * slope_of(form.cells, drive))
    return count, tape


def backward(form: Form, weights: tuple[Weights, ...], tape: Tape, count: F64) -> tuple[Weights, ...]:
    """Return the derivatives of a loss by the weights, of those by the neurons' counts."""
    found = [Weights(np.zeros_like(w.neurons), np.zeros_like(w.channels)) for w in weights]
    falls = [np.exp(-tape.step / bank.tau) for bank in form.banks]
    later = [np.zeros_like(count) for _ in weights]
    heard = np.zeros_like(count)  # derivative by the spikes that the step behind hears
    for come, fired, state, slope in zip(*(reversed(x) for x in tape[1:]), strict=True):
        drive = (count + heard) * slope / form.cells.unit
        heard = np.zeros_like(count)
        for k, (bank, w) in enumerate(zip(form.banks, weights, strict=True)):
            steep = np.maximum(state[k] / bank.pivot, FLOOR) ** (bank.power - 1.0)
            own = later[k] + drive * bank.sign * bank.power * steep
            later[k] = falls[k] * own
            back = own.swapaxes(1, 2)
            found[k].channels[...] += back @ come
            if w.neurons.any():
                found[k].neurons[...] += back @ fired.astype(np.float64)
                heard += own @ w.neurons
    return tuple(found)


def slope_of(cells: Cells, drive: F64) -> F64:
    """Derivative of a neuron's rate by its drive, Hz, softened about the rheobase."""
    over = SOFT * np.logaddexp(0.0, (drive - 1.0) / SOFT)
    d = 1.0 if cells.slope is None else cells.slope
    over = np.maximum(over, 1e-6)
    between = period(over, cells.tau, d, cells.refractory)
    change = (between - cells.refractory) / over - cells.tau * d / (over * (over + np.exp(-1.0 / d)))
    return np.asarray(change / between**2 / (1.0 + np.exp((1.0 - drive) / SOFT)))


def _drive(form: Form, state: list[F64]) -> F64:
    """Drive of the neurons, in rheobases."""
    each = (
        bank.sign * bank.pivot * (s / bank.pivot) ** bank.power
        for bank, s in zip(form.banks, state, strict=True)
    )
    return np.asarray(sum(each, np.zeros(1)) / form.cells.unit)
