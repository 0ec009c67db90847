"""What resolution of weights a network needs: its equations at the task, with weights of few bits.

A weight of b bits is a whole number of steps, `2^(b-1) - 1` of them at most either way. All connections from
one source have a step in common, of which the largest weight is the last one. Nothing of silicon is in it: on
a die the rest of what is lost is the chip's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.mapping.certify.chips import certified
from system.mapping.certify.system import (
    NEAR,
    Scenario,
    contents_of,
    ideal_score,
    opened,
    score_of,
    world_of,
)
from system.mapping.nef.network import ValueNetwork
from system.mapping.network import Network

FEWEST, MOST = 2, 16  # bits: a sign and one step; as many as no weight needs; ours


@dataclass(frozen=True, slots=True)
class Resolved:
    """A score with weights of so many bits, and by how much it is below that of the weights as they are.

    Attributes
    ----------
    bits : int
        Bits of a weight, its sign among them.
    score, lost : float
        Score of the task, 0 to 1, and what is lost of it.
    """

    bits: int
    score: float
    lost: float


def bits_of(text: str) -> tuple[int, ...]:
    """Return numbers of bits of a text, as 2,3,4; raises `ParameterError` for what is none."""
    found = []
    for word in text.split(",") if text else ():
        if not word.strip().isdecimal() or not FEWEST <= int(word) <= MOST:
            raise ParameterError(
                f'bits: "{word.strip()}", must be whole numbers from {FEWEST} to {MOST}; write 2,3,4'
            )
        found.append(int(word))
    return tuple(sorted({*found}))


def resolved(scenario: Scenario, bits: Sequence[int]) -> tuple[Resolved, ...]:
    """Return the scores of a network's equations with weights of so many bits, in a scenario's world.

    Of the scenario only program, task and seed count. Raises as `system.mapping.certify.system.run`.
    """
    if not bits:
        return ()
    contents = contents_of(scenario.program, scenario.task)
    (mapped, task), whole = opened(scenario, contents), ideal_score(scenario, contents)
    found = []
    for count in bits:
        network: Any = of_bits(mapped.network, count)
        player = certified(mapped).ideal(replace(mapped, network=network))
        score = score_of(scenario.task, task, player, world_of(task, scenario.seed))
        found.append(Resolved(count, score, whole - score))
    return tuple(found)


def fewest_bits(found: Sequence[Resolved]) -> int | None:
    """Return the least number of bits from which on no more than `NEAR` is lost; None where there is none."""
    least = None
    for each in sorted(found, key=lambda r: -r.bits):
        if each.lost > NEAR:
            break
        least = each.bits
    return least


def of_bits(network: Network | ValueNetwork, bits: int) -> Network | ValueNetwork:
    """Return a network whose weights have so many bits."""
    largest: dict[str, float] = {}
    for c in network.connections:
        largest[c.source] = max(largest.get(c.source, 0.0), float(np.abs(_weights(c)).max(initial=0.0)))
    steps = {name: most / (2.0 ** (bits - 1) - 1.0) for name, most in largest.items()}
    changed: Any = tuple(_rounded(c, steps[c.source]) for c in network.connections)
    return replace(network, connections=changed)


def _weights(connection: Any) -> F64:
    name = _field(connection)
    return np.asarray(getattr(connection, name), dtype=np.float64)


def _field(connection: Any) -> str:
    """Where a connection, of populations or of values, has its weights."""
    if hasattr(connection, "transform"):
        return "transform"
    return "matrix" if connection.rule == "matrix" else "weight"


def _rounded(connection: Any, step: float) -> Any:
    if step == 0.0:
        return connection
    found = step * np.round(_weights(connection) / step)
    value = float(found) if found.ndim == 0 else tuple(map(tuple, found.tolist()))
    return replace(connection, **{_field(connection): value})
