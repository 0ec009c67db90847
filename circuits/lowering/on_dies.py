"""Many dies of one machine at once: `on_die` of each, with the draws of all dies made together.

The machines are those of `circuits.lowering.kernel.on_die` to the bit (tested). Dies that have more than
plain draws of their own (edits, plans, components of variation), circuits whose biases stand on the die or
whose diodes deviate, and processes whose law follows the size are put on their dies one by one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.lowering.kernel import Machine, on_die, transistors_of
from circuits.silicon.die import NOMINAL, Die, alike, mismatch_of, shared_of
from circuits.silicon.passive import deviates
from circuits.silicon.process import POLARITIES
from circuits.silicon.silicon import Silicon


def on_dies(machine: Machine, dies: Sequence[Die]) -> list[Machine]:
    """The machine on each of several dies, without the work of lowering its testbench again."""
    if not dies:
        return []
    place = ((machine.flat.circuit.name, ()),)
    on_the_die = any(bias.kind in {"ideal", "generator"} for bias in machine.testbench.circuit.biases)
    process = machine.silicon.process
    sized = any(process.model(polarity).size is not None for polarity in POLARITIES)
    if (
        on_the_die
        or sized
        or (process.diodes is not None and machine.kernel.diodes.saturation.size > 0)
        or not alike(dies)
        or deviates(machine.silicon.die, machine.silicon.place or place)
    ):
        return [on_die(machine, die) for die in dies]
    v_t0, specific = _coefficients(machine, dies)
    kernel, t = machine.kernel, machine.kernel.transistors
    return [
        replace(
            machine,
            silicon=replace(machine.silicon, die=die),
            kernel=kernel._replace(transistors=t._replace(v_t0=v_t0[k], specific_current=specific[k])),
        )
        for k, die in enumerate(dies)
    ]


def _coefficients(machine: Machine, dies: Sequence[Die]) -> tuple[F64, F64]:
    """V_T0 (V) and specific currents (A) of all transistors on all dies, float64[dies, transistors] each."""
    silicon: Silicon = replace(machine.silicon, die=NOMINAL)
    paths, _, is_n, (width, length, multiplicity) = transistors_of(machine.flat)
    place = silicon.place or ((machine.flat.circuit.name, ()),)
    delta, relative = mismatch_of(dies, silicon.process, place, paths, width * length * multiplicity)
    v_t0, specific = np.empty_like(delta), np.empty_like(delta)
    for polarity in POLARITIES:
        own = is_n == (polarity == "n")
        shift, beta = (x[:, None] for x in shared_of(dies, silicon.process, polarity))
        law = silicon.law(polarity)
        square = law.square_current * (1.0 + beta) * multiplicity[own] * width[own] / length[own]
        v_t0[:, own] = law.v_t0 + shift + delta[:, own]
        specific[:, own] = square * (1.0 + relative[:, own])
    return v_t0, specific
