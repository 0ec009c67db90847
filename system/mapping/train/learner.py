"""What a training asks of a network on a chip, whichever it is, and the loss that all have.

loss = cross-entropy of softmax(outputs / margin), mean over samples and dies
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from circuits.arrays import F64, I64, Bools
from system.mapping.certify.task import Samples
from system.mapping.chips import AnyNetwork

Progress = Callable[[float], None]
Gradient = tuple[float, float, tuple[F64, ...]]  # loss, share that is right, derivatives by the matrices


class Weights(Protocol):
    """Weights of a network that are trained: matrices of all connections, of which some entries are free."""

    @property
    def matrices(self) -> tuple[F64, ...]:
        """Where they begin."""

    @property
    def free(self) -> tuple[Bools, ...]:
        """Which entries are trained."""

    def moved(self, matrices: Sequence[F64], by: Sequence[F64]) -> tuple[F64, ...]:
        """Return matrices moved, within what they may be."""

    def network(self, matrices: Sequence[F64]) -> AnyNetwork:
        """Return the network with other matrices."""


class Learner(NamedTuple):
    """A network on a chip in a form that can be followed backwards.

    weights : what is trained; dies : makes what the form has of so many drawn dies, from die 0 on, or of the
    nominal one for none; gradient : of some rows of samples on some of these.
    """

    weights: Weights
    dies: Callable[[int, Progress], list[Any]]
    gradient: Callable[[tuple[F64, ...], list[Any], Samples, I64], Gradient]


def judged(outputs: F64, labels: I64, margin: float) -> tuple[float, float, F64]:
    """Return loss, share that is right, and the derivatives of the loss by the outputs.

    outputs: float64[..., samples, outputs]; margin: by which one that is e times as likely is ahead.
    """
    ahead = (outputs - outputs.max(axis=-1, keepdims=True)) / margin
    share = np.exp(ahead)
    share /= share.sum(axis=-1, keepdims=True)
    asked = np.eye(outputs.shape[-1])[labels]
    loss = -(asked * np.log(np.maximum(share, 1e-300))).sum(axis=-1).mean()
    right = (outputs.argmax(axis=-1) == labels) & outputs.any(axis=-1)
    back = (share - asked) / (margin * right.size)
    return float(loss), float(right.mean()), np.asarray(back)
