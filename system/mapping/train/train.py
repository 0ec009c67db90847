"""Training of a network for silicon: samples with labels, and drawn dies in the loop.

    loss = cross-entropy of softmax(spikes of each output / `MARGIN`), mean over samples and dies

Each step takes some samples and some of the dies, drawn by (seed, step), and moves the weights by Adam, whose
pace falls to 0 on a straight line. Dies are those from 0 on, which are never judged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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
from system.mapping.train.ratios import Ratios, calibrated_form, nominal_ratios, ratios_of
from system.mapping.train.recipe import Recipe
from system.mapping.train.weights import Trainable, trainable

MARGIN = 2.0  # spikes by which an output that is e times as likely is ahead; ours
STEP = 0.8e-3  # s, about a step of the equations: two of the chip's; ours
FIRST, SECOND, TINY = 0.9, 0.999, 1e-8  # of Adam


@dataclass(frozen=True, slots=True, eq=False)
class Trained:
    """What a training leaves.

    network : with the weights that were found; weights : how many were trained; losses, right : of each step,
    mean loss and share of samples that the differentiable form labels right, float64[steps].
    """

    network: Network
    weights: int
    losses: F64
    right: F64


def train(
    network: Network, samples: Samples, recipe: Recipe | None = None,
    progress: Callable[[float], None] = lambda _: None,
) -> Trained:  # fmt: skip
    """Find weights of a network that hold on many dies of ROLLS.

    Parameters
    ----------
    network
        The network; weights that it gives as a matrix are trained, but for zeros. Its probes are the outputs.
    samples
        Inputs and labels, as `task_of` reads them.
    recipe
        How; the usual way unless given.
    progress
        Called with the share that is done.

    Raises
    ------
    ParameterError
        No weights are in a matrix, there is no probe, the samples do not fit the network, or it is not
        possible on the chip.
    """
    recipe = Recipe() if recipe is None else recipe
    samples.check(network)
    mapped = map_on_rolls(network)
    weights = trainable(mapped)
    dies = _dies(mapped, recipe, lambda share: progress(0.5 * share))
    descent = _Descent(weights, recipe)
    losses, right = np.zeros((2, recipe.steps))
    for k in range(recipe.steps):
        rng = np.random.Generator(np.random.Philox(key=np.array([recipe.seed, k], dtype=np.uint64)))
        some = rng.choice(len(dies), min(recipe.together, len(dies)), replace=False)
        rows = rng.choice(len(samples.labels), min(recipe.batch, len(samples.labels)), replace=False)
        with_dies = tuple(dies[i] for i in np.sort(some))
        losses[k], right[k], by = _gradient(weights, descent.matrices, with_dies, samples, rows)
        descent.step(k, by)
        progress(0.5 + 0.5 * (k + 1) / recipe.steps)
    count = sum(int(each.sum()) for each in weights.free)
    return Trained(weights.network(descent.matrices), count, losses, right)


def _dies(mapped: Mapped, recipe: Recipe, progress: Callable[[float], None]) -> list[Ratios]:
    if not recipe.dies:
        return [nominal_ratios(mapped)]
    of, found = ratios_of(mapped), []
    for number in range(recipe.dies):
        found.append(calibrated_form(mapped, of(Silicon(ROLLS_180, die=Die("A", number)))))
        progress((number + 1) / recipe.dies)
    return found


class _Descent:
    """Weights that go down by Adam."""

    def __init__(self, weights: Trainable, recipe: Recipe) -> None:
        self.matrices, self._weights, self._recipe = weights.matrices, weights, recipe
        self._first, self._second = ([np.zeros_like(m) for m in self.matrices] for _ in range(2))

    def step(self, k: int, by: tuple[F64, ...]) -> None:
        """Take step `k` down the derivatives `by`."""
        pace, moves = self._recipe.pace * (1.0 - k / self._recipe.steps), []
        for m, v, g, matrix in zip(self._first, self._second, by, self._weights.matrices, strict=True):
            m[...] = FIRST * m + (1.0 - FIRST) * g
            v[...] = SECOND * v + (1.0 - SECOND) * g * g
            ahead = m / (1.0 - FIRST ** (k + 1)) / (np.sqrt(v / (1.0 - SECOND ** (k + 1))) + TINY)
            moves.append(-pace * np.abs(matrix).max() * ahead)
        self.matrices = self._weights.moved(self.matrices, moves)


def _gradient(
    weights: Trainable, matrices: tuple[F64, ...], dies: tuple[Ratios, ...], samples: Samples, rows: I64
) -> tuple[float, float, tuple[F64, ...]]:
    """Loss and share that is right of some samples on some dies, and the derivatives by the matrices."""
    form, on = form_of(weights.mapped, dies), weights.on_dies(matrices, dies)
    steps = max(round(samples.window / STEP), 1)
    events = binned(with_own_rates(weights.mapped.network, samples.inputs[rows]), samples.window, steps)
    count, tape = forward(form, on.weights, events, samples.window / steps)
    loss, right, back = judged(count, _outputs(weights.mapped.network), samples.labels[rows])
    return loss, right, weights.derivatives(matrices, on, backward(form, on.weights, tape, back))


def judged(count: F64, outputs: F64, labels: I64) -> tuple[float, float, F64]:
    """Return loss, share that is right, and the derivatives of the loss by counts of spikes.

    count: float64[dies, samples, n]; outputs: which neurons belong to each, float64[n, outputs].
    """
    spikes = count @ outputs
    ahead = (spikes - spikes.max(axis=2, keepdims=True)) / MARGIN
    share = np.exp(ahead)
    share /= share.sum(axis=2, keepdims=True)
    asked = np.eye(outputs.shape[1])[labels]
    loss = -(asked * np.log(np.maximum(share, 1e-300))).sum(axis=2).mean()
    right = (spikes.argmax(axis=2) == labels) & (spikes.max(axis=2) > 0.0)
    back = (share - asked) / (MARGIN * share.shape[0] * share.shape[1])
    return float(loss), float(right.mean()), np.asarray(back @ outputs.T)


def binned(rates: F64, window: float, steps: int) -> F64:
    """Return events of channels at some rates in each step of a window, float64[steps, samples, channels].

    They are those that a task's network gets (`system.mapping.certify.player`).
    """
    phase = np.linspace(0.0, 1.0, rates.shape[1], endpoint=False)
    times = np.linspace(0.0, window, steps + 1)[:, None, None]
    return np.diff(np.floor(phase + rates * times + 1e-9), axis=0)


def _outputs(network: Network) -> F64:
    at = spans(network.populations)
    found = np.zeros((network.neurons, len(network.probes)))
    for k, probe in enumerate(network.probes):
        found[at[probe.population], k] = 1.0
    return found
