"""Training of a network for silicon: samples with labels, and drawn dies in the loop.

Each step takes some samples and some of the dies, drawn by (seed, step), and moves the weights by Adam, whose
pace falls to 0 on a straight line. Dies are those from 0 on, which are never judged.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar, cast

import numpy as np

from circuits.arrays import F64
from system.mapping.certify.task import Samples
from system.mapping.chips import AnyNetwork
from system.mapping.network import Network
from system.mapping.train.learner import Learner, Progress, Weights
from system.mapping.train.recipe import Recipe
from system.mapping.train.spiking import spiking_learner
from system.mapping.train.values import value_learner

FIRST, SECOND, TINY = 0.9, 0.999, 1e-8  # of Adam
N = TypeVar("N", bound=AnyNetwork)


@dataclass(frozen=True, slots=True, eq=False)
class Trained(Generic[N]):
    """What a training leaves.

    network : with the weights that were found; weights : how many were trained; losses, right : of each step,
    mean loss and share of samples that the differentiable form labels right, float64[steps].
    """

    network: N
    weights: int
    losses: F64
    right: F64


def train(
    network: N, samples: Samples, recipe: Recipe | None = None, progress: Progress = lambda _: None
) -> Trained[N]:
    """Find weights of a network that hold on many dies of its chip.

    Parameters
    ----------
    network
        The network, of populations for ROLLS or of values for the NEF chip. Weights that it gives as a matrix
        are trained, but for zeros. Its probes are the outputs.
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
    learner = learner_of(network)
    dies = learner.dies(recipe.dies, lambda share: progress(0.5 * share))
    descent = _Descent(learner.weights, recipe)
    losses, right = np.zeros((2, recipe.steps))
    for k in range(recipe.steps):
        rng = np.random.Generator(np.random.Philox(key=np.array([recipe.seed, k], dtype=np.uint64)))
        some = rng.choice(len(dies), min(recipe.together, len(dies)), replace=False)
        rows = rng.choice(len(samples.labels), min(recipe.batch, len(samples.labels)), replace=False)
        with_dies = [dies[i] for i in np.sort(some)]
        losses[k], right[k], by = learner.gradient(descent.matrices, with_dies, samples, rows)
        descent.step(k, by)
        progress(0.5 + 0.5 * (k + 1) / recipe.steps)
    count = sum(int(each.sum()) for each in learner.weights.free)
    found = cast("N", learner.weights.network(descent.matrices))  # of its own kind
    return Trained(found, count, losses, right)


def learner_of(network: AnyNetwork) -> Learner:
    """Return a network as its chip's form trains it; raises as `train`."""
    return spiking_learner(network) if isinstance(network, Network) else value_learner(network)


class _Descent:
    """Weights that go down by Adam."""

    def __init__(self, weights: Weights, recipe: Recipe) -> None:
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
