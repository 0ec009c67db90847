"""A network of values that is trained on the form of the NEF chip (`system.mapping.train.value_form`).

What is trained are the transforms that are given as matrices. Decoders are not: a bench solves them on each
die of the curves that it measures there, so that no program has any of its own to keep.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.mapping.certify.task import Samples
from system.mapping.nef.mapped import MappedValues, map_on_nef
from system.mapping.nef.network import ValueNetwork
from system.mapping.train.learner import Gradient, Learner, Progress, judged
from system.mapping.train.value_form import ValueForm, backward, forward, value_form

MARGIN = 0.1  # of the largest radius that is probed, by which one that is e times as likely is ahead; ours
STEP = 4e-3  # s, about a step of the form; ours


@dataclass(frozen=True, slots=True, eq=False)
class Transforms:
    """Transforms of a network of values.

    asked : the network; matrices : T of each connection, float64[results, size]; free : which are trained.
    """

    asked: ValueNetwork
    matrices: tuple[F64, ...]
    free: tuple[Bools, ...]

    def moved(self, matrices: Sequence[F64], by: Sequence[F64]) -> tuple[F64, ...]:
        """Return matrices moved; nothing bounds them but the converters, which clip."""
        every = zip(matrices, by, self.free, strict=True)
        return tuple(np.where(free, m + change, m) for m, change, free in every)

    def network(self, matrices: Sequence[F64]) -> ValueNetwork:
        """Return the network with other matrices."""
        every = zip(self.asked.connections, matrices, self.free, strict=True)
        found = (replace(c, transform=m) if free.any() else c for c, m, free in every)  # type: ignore[arg-type]
        return replace(self.asked, connections=tuple(found))


def value_learner(network: ValueNetwork) -> Learner:
    """Return a network of values as it is trained.

    Raises `ParameterError` where no transform is a matrix, or it is not possible on the chip.
    """
    free = tuple(
        np.array(c.transform) != 0.0 if isinstance(c.transform, tuple) else np.zeros((1, 1), np.bool_)
        for c in network.connections
    )
    if not any(each.any() for each in free):
        raise ParameterError("connection: none with a transform in a matrix, which is trained; give it one")
    mapped = map_on_nef(network)
    found = form_on(mapped, NOMINAL)
    matrices = tuple(
        np.array(c.transform) if isinstance(c.transform, tuple) else c.transform * np.eye(lane.full.size)
        for c, lane in zip(network.connections, (found.lanes[way.lane] for way in found.ways), strict=True)
    )
    weights = Transforms(network, matrices, free)
    return Learner(weights, partial(_dies, mapped), partial(_gradient, network))


def form_on(mapped: MappedValues, die: Die) -> ValueForm:
    """Return the form of a mapped network on a die, measured and with its decoders solved as on a bench."""
    built = mapped.on(Silicon(ROLLS_180, die=die), "generator", solved=True)
    return value_form(mapped.network, built)


def _dies(mapped: MappedValues, count: int, progress: Progress) -> list[ValueForm]:
    if not count:
        return [form_on(mapped, NOMINAL)]
    found = []
    for number in range(count):
        found.append(form_on(mapped, Die("A", number)))
        progress((number + 1) / count)
    return found


def _gradient(
    network: ValueNetwork, matrices: tuple[F64, ...], dies: list[ValueForm], samples: Samples, rows: I64
) -> Gradient:
    steps = max(round(samples.window / STEP), 1)
    step, margin = samples.window / steps, MARGIN * _radius(network)
    loss, right, by = 0.0, 0.0, tuple(np.zeros_like(m) for m in matrices)
    for form in dies:
        outputs, tape = forward(form, matrices, samples.inputs[rows], steps, step)
        lost, share, back = judged(outputs, samples.labels[rows], margin)
        own = backward(form, matrices, tape, back / len(dies), step)
        loss, right = loss + lost / len(dies), right + share / len(dies)
        by = tuple(one + other for one, other in zip(by, own, strict=True))
    return loss, right, by


def _radius(network: ValueNetwork) -> float:
    probed = {probe.ensemble for probe in network.probes}
    return max(e.radius for e in network.ensembles if e.name in probed)
