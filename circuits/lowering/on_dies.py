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
from circuits.silicon.die import NOMINAL, Die, Normals, alike, mismatch_of, shared_of
from circuits.silicon.passive import deviates
from circuits.silicon.process import POLARITIES
from circuits.silicon.silicon import Silicon


def on_dies(machine: Machine, dies: Sequence[Die]) -> list[Machine]:
    """The machine on each of several dies, without the work of lowering its testbench again."""
    if not dies:
        return []
    if not differ_in_transistors(machine, dies):
        return [on_die(machine, die) for die in dies]
    v_t0, specific = coefficients_on_dies(machine, dies)
    kernel, t = machine.kernel, machine.kernel.transistors
    return [
        replace(
            machine,
            silicon=replace(machine.silicon, die=die),
            kernel=kernel._replace(transistors=t._replace(v_t0=v_t0[k], specific_current=specific[k])),
        )
        for k, die in enumerate(dies)
    ]


def differ_in_transistors(machine: Machine, dies: Sequence[Die]) -> bool:
    """Whether a machine is on all these dies the same but for its transistors' V_T0 and specific currents."""
    place = ((machine.flat.circuit.name, ()),)
    on_the_die = any(bias.kind in {"ideal", "generator"} for bias in machine.testbench.circuit.biases)
    process = machine.silicon.process
    sized = any(process.model(polarity).size is not None for polarity in POLARITIES)
    diodes = process.diodes is not None and machine.kernel.diodes.saturation.size > 0
    passive = deviates(machine.silicon.die, machine.silicon.place or place)
    return not (on_the_die or sized or diodes or passive) and alike(dies)


def coefficients_on_dies(
    machine: Machine, dies: Sequence[Die], normals: Normals | None = None
) -> tuple[F64, F64]:
    """V_T0 (V) and specific currents (A) of all transistors on dies that `differ_in_transistors` alone.

    float64[dies, transistors] each. normals: what draws, `circuits.silicon.die.normals_of` unless given.
    """
    silicon: Silicon = replace(machine.silicon, die=NOMINAL)
    paths, _, is_n, (width, length, multiplicity) = transistors_of(machine.flat)
    place = silicon.place or ((machine.flat.circuit.name, ()),)
    area = width * length * multiplicity
    delta, relative = mismatch_of(dies, silicon.process, place, paths, area, normals)
    v_t0, specific = np.empty_like(delta), np.empty_like(delta)
    for polarity in POLARITIES:
        own = is_n == (polarity == "n")
        shift, beta = (x[:, None] for x in shared_of(dies, silicon.process, polarity, normals))
        law = silicon.law(polarity)
        square = law.square_current * (1.0 + beta) * multiplicity[own] * width[own] / length[own]
        v_t0[:, own] = law.v_t0 + shift + delta[:, own]
        specific[:, own] = square * (1.0 + relative[:, own])
    return v_t0, specific
