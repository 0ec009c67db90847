"""Synapses of a ROLLS chip by the behavioural model of their block, with the chip's own devices.

What a chip's step makes simple (`chips.rolls.kernel`) is held against this: the same transistors, pulse
extender and filter of a neuron, with the line and v_syn as two equations (`chips.rolls.synapse.kernel`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.lumped.whole_filter import INPUT, MEMBRANE
from chips.rolls.parts import devices_at, part_gates, row_place
from chips.rolls.program.address import NEURONS, NONPLASTIC
from chips.rolls.synapse.model import SynapsesOnDie, respond, synapses_of
from chips.rolls.tables import prepare
from circuits.arrays import F64
from circuits.blocks.rolls import dpi_synapse
from circuits.lowering.on_die import DieDevices, Fet

_FINE = 8  # points of the reference a step of the chip


def reference_synapses(chip: RollsChip, level: int, pre: int, rows: Sequence[int]) -> SynapsesOnDie:
    """Return the synapses from neuron `pre` to the neurons `rows`, each alone on its filter.

    Their lines carry the idle leaks of all synapses of the chip.
    """
    silicon, params, gates = chip.silicon, chip.params, chip.built().gates
    at = {"synapse": np.array(rows) * NEURONS + pre, "extender": np.full(len(rows), pre)}
    places = {
        "synapse": row_place(NEURONS, ("synapse", (NEURONS,))), "extender": (("extender", (NEURONS,)),),
        "excitatory": row_place(NEURONS, ("excitatory", ())),
        "inhibitory": row_place(NEURONS, ("inhibitory", ())),
    }  # fmt: skip
    makes = {
        "synapse": dpi_synapse.synapse, "extender": dpi_synapse.pulse_extender,
        "excitatory": dpi_synapse.excitatory_filter, "inhibitory": dpi_synapse.inhibitory_filter,
    }  # fmt: skip
    fets: dict[str, Fet] = {}
    ports: dict[str, F64] = {}
    for name, make in makes.items():
        own = part_gates(name, gates)
        d = devices_at(make(params.synapse), places[name], silicon, own, None, f"{name}.")
        fets.update(d.taken(at.get(name, np.array(rows))).fet)
        # a filter's v_tau is v_etau or v_itau of the block
        letter = {"excitatory": "e", "inhibitory": "i"}.get(name, "")
        ports.update({f"v_{letter}{port[2:]}": np.asarray(v) for port, v in own.items()})
    d = DieDevices(silicon.thermal_voltage, silicon.process.v_dd, len(rows), fets, ports)
    found = synapses_of(prepare(params, silicon.process).synapse, d, level, INPUT if level > 0 else MEMBRANE)
    idle = chip.built().loads[0 if level > 0 else 1].idle[list(rows)]
    return dataclasses.replace(found, filters=found.filters._replace(off=idle.copy()))


def filter_errors(
    chip: RollsChip, level: int, pre: int, rows: Sequence[int], times: F64, duration: float
) -> F64:
    """Return the mean current of the chip's filters over the reference's, less one, float64[rows].

    times: of the events of neuron `pre` to all `rows`, s, which the chip takes at the beginning of a step;
    duration: of the run, s.
    """
    step = chip.step
    times = np.unique(np.round(times / step)) * step
    state, total, n = chip.at_rest(), np.zeros(len(rows)), round(duration / step)
    fine = (np.arange(n * _FINE) + 0.5) * step / _FINE  # middles: the mean of what falls within a step
    for k in range(n):
        now = times[(times >= (k - 0.5) * step) & (times < (k + 0.5) * step)]
        inputs = Inputs(
            np.full(now.size * len(rows), state.time), np.array(list(rows) * now.size, dtype=np.int64),
            np.full(now.size * len(rows), NONPLASTIC + pre),
        )  # fmt: skip
        _, state = chip.run(state, step, inputs)
        total += chip.synaptic_currents()[0 if level > 0 else 1][list(rows)]
    reference = respond(reference_synapses(chip, level, pre, rows), list(times), fine)
    return np.asarray(total / n / reference.mean(axis=1) - 1.0)
