"""A network of populations that is trained on the form of ROLLS (`system.mapping.train.form`)."""

from __future__ import annotations

from functools import partial

import numpy as np

from circuits.arrays import F64, I64
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.mapping.certify.task import Samples
from system.mapping.clock import with_own_rates
from system.mapping.network import Network, spans
from system.mapping.rolls.map import map_on_rolls
from system.mapping.rolls.mapped import Mapped
from system.mapping.train.form import backward, form_of, forward
from system.mapping.train.learner import Gradient, Learner, Progress, judged
from system.mapping.train.ratios import Ratios, calibrated_form, nominal_ratios, ratios_of
from system.mapping.train.weights import Trainable, trainable

MARGIN = 2.0  # spikes by which an output that is e times as likely is ahead; ours
STEP = 0.8e-3  # s, about a step of the equations: two of the chip's; ours


def spiking_learner(network: Network) -> Learner:
    """Return a network of populations as it is trained.

    Raises `ParameterError` where no weights are in a matrix, or it is not possible on the chip.
    """
    mapped = map_on_rolls(network)
    weights = trainable(mapped)
    return Learner(weights, partial(_dies, mapped), partial(_gradient, weights))


def _dies(mapped: Mapped, count: int, progress: Progress) -> list[Ratios]:
    if not count:
        return [nominal_ratios(mapped)]
    of, found = ratios_of(mapped), []
    for number in range(count):
        found.append(calibrated_form(mapped, of(Silicon(ROLLS_180, die=Die("A", number)))))
        progress((number + 1) / count)
    return found


def _gradient(
    weights: Trainable, matrices: tuple[F64, ...], dies: list[Ratios], samples: Samples, rows: I64
) -> Gradient:
    form, on = form_of(weights.mapped, tuple(dies)), weights.on_dies(matrices, dies)
    steps = max(round(samples.window / STEP), 1)
    events = binned(with_own_rates(weights.mapped.network, samples.inputs[rows]), samples.window, steps)
    count, tape = forward(form, on.weights, events, samples.window / steps)
    outputs = _outputs(weights.mapped.network)
    loss, right, by = judged(count @ outputs, samples.labels[rows], MARGIN)
    back = np.asarray(by @ outputs.T)
    return loss, right, weights.derivatives(matrices, on, backward(form, on.weights, tape, back))


def binned(rates: F64, window: float, steps: int) -> F64:
    """Return events of channels at some rates in each step of a window, float64[steps, samples, channels].

    They are those that a task's network gets (`system.mapping.certify.spiking`).
    """
    phase = np.linspace(0.0, 1.0, rates.shape[1], endpoint=False)
    times = np.linspace(0.0, window, steps + 1)[:, None, None]
    return np.diff(np.floor(phase + rates * times + 1e-9), axis=0)


def _outputs(network: Network) -> F64:
    """Which neurons belong to each output, float64[n, outputs]."""
    at = spans(network.populations)
    found = np.zeros((network.neurons, len(network.probes)))
    for k, probe in enumerate(network.probes):
        found[at[probe.population], k] = 1.0
    return found
