"""Directions in which a die is moved to find a metric's gradient without a run backwards.

A draw of a device of the circuit, or of the process, is a direction of its own. What stands behind a bias
(`circuits.lowering.bias_moves`), some hundred devices of a generator, reaches the circuit by the voltage of
its line alone, which is nearly linear in their draws. So a line is one direction, along which its own devices
move it most for their draws, and what that does is divided among them, and among those that lines share, in
proportion to what each moves the voltage by.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import F64
from circuits.lowering.bias_moves import bias_moves, by_sigma
from circuits.silicon.die import NOMINAL
from system.study.table import Condition
from system.study.target import BlockTarget, Target


@dataclass(frozen=True, slots=True, eq=False)
class Directions:
    """Directions from the nominal die.

    names : a draw's label, or a line's port.
    rows : draws of a die one sigma away, float64[directions, labels].
    by_label : what a slope along a direction is of a draw's, float64[labels, directions].
    """

    names: tuple[str, ...]
    rows: F64
    by_label: F64

    def gradient(self, along: F64) -> F64:
        """Slopes by each draw, float64[labels, ...], of those along directions; NaN where one of these is."""
        known = np.isfinite(along)
        found = np.tensordot(self.by_label, np.where(known, along, 0.0), 1)
        lost = np.tensordot((self.by_label != 0.0).astype(np.float64), (~known).astype(np.float64), 1)
        return np.asarray(np.where(lost > 0.0, np.nan, found))


def directions(target: Target, labels: Sequence[str], condition: Condition) -> Directions:
    """Find the directions for a target's draws; labels: of these; condition: gives the temperature."""
    behind, lines = _lines(target, {label: k for k, label in enumerate(labels)}, condition)
    one, plain = np.eye(len(labels)), [k for k in range(len(labels)) if k not in behind]
    lengths = [float(np.linalg.norm(own)) for own, _ in lines.values()]
    rows = [own / a for (own, _), a in zip(lines.values(), lengths, strict=True)]
    by = [(own + shared) / a for (own, shared), a in zip(lines.values(), lengths, strict=True)]
    names = (*(labels[k] for k in plain), *lines)
    return Directions(names, np.vstack([one[plain], *rows]), np.vstack([one[plain], *by]).T)


def _lines(
    target: Target, column: Mapping[str, int], condition: Condition
) -> tuple[set[int], dict[str, tuple[F64, F64]]]:
    """Columns of all draws behind biases, and what one sigma of each moves a line by, V, float64[labels].

    That is of the line's own devices, and of those that lines share. A line that biases have in common, as
    those of a block on a chip may, is one.
    """
    behind: set[int] = set()
    found: dict[str, tuple[F64, F64]] = {}
    if not isinstance(target, BlockTarget):
        return behind, found
    circuit = target.choice.circuit
    silicon = replace(target.choice.silicon, temperature_c=condition.temperature_c, die=NOMINAL)
    for bias in circuit.biases:
        each = [by_sigma(moves, silicon.process) for moves in bias_moves(circuit, bias, silicon)]
        if not each or each[0][0][0] not in column:
            continue
        at = [[column[label] for label in names] for names, _ in each]
        known = bool(behind.intersection(at[0]))
        behind.update(k for columns in at for k in columns)
        for k, own in enumerate(each[0][1] if not known else ()):
            whole, shared = np.zeros(len(column)), np.zeros(len(column))
            whole[at[0]] = own
            for columns, (_, by) in zip(at[1:], each[1:], strict=True):
                shared[columns] = by[k]
            if own.any():
                found[f"{bias.port}[{k}]"] = whole, shared
    return behind, found
