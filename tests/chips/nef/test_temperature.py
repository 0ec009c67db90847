"""The NEF chip while its temperature moves, against the transistors of its neurons and filters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.nef.build import build as build_network
from chips.nef.build import moved
from chips.nef.circuit import chip_biases
from chips.nef.devices import PLACE, design_tau
from chips.nef.model import Filters, filters_on, neurons_on
from chips.nef.network.network import Connection, Ensemble, Network, Node, Probe
from chips.nef.simulation import Simulation
from chips.nef.temperature import moved_filters, moved_neurons
from circuits.blocks.nef import neuron as nef_neuron
from circuits.blocks.nef import synapse as nef_synapse
from circuits.blocks.nef.neuron import LEAK
from circuits.silicon.course import Course
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.temperature import simulate_course
from tests.chips.nef.paper import paper_chip

NUMBER, CURRENT = 5, 0.25e-9  # of the neuron, and A into it
SILICON = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=3104))
NETWORK = Network(
    (Ensemble("x", 30),), (Node("in", 1),), (Connection("in", "x"),), (Probe("x?", "x", synapse=0.02),)
)


@pytest.mark.parametrize("to", [7.0, 47.0])
def test_a_step_of_20_degrees_moves_a_neuron_s_spikes_as_the_circuit_s(to: float) -> None:
    there = replace(SILICON, place=(*PLACE, ("neuron", (NUMBER,))))
    bench = nef_neuron.testbench(
        nef_neuron.build(), {"current": CURRENT, "duration": 0.1}, ROLLS_180_IDEAL.v_dd
    )
    spikes = simulate_course(bench, there, Course(((0.0, 27.0),)), record=()).spikes["spike"]
    last, period = spikes[-4], spikes[-3] - spikes[-4]
    step = last + 0.6 * period
    course = Course(((0.0, 27.0), (step - 1e-7, 27.0), (step, to)))
    theirs = simulate_course(bench, there, course, record=()).spikes["spike"]
    old, new = (neurons_on(replace(SILICON, temperature_c=t), NUMBER + 1, chip_biases()) for t in (27.0, to))
    charged = step - last - old.refractory[NUMBER]
    u = (CURRENT / LEAK - old.leak) / old.charge * charged
    after, _ = moved_neurons(u, np.zeros(u.size), old, new)
    left = (1.0 - after) * new.charge / (CURRENT / LEAK - new.leak)
    following = theirs[theirs > step]
    mean = np.diff(following).mean() if following.size > 1 else period
    assert step + left[NUMBER] - following[0] == pytest.approx(0.0, abs=0.03 * mean)


@pytest.mark.parametrize("to", [7.0, 47.0])
def test_a_filter_goes_on_from_its_voltage_as_the_circuit_does(to: float) -> None:
    silicon, step, stop = replace(SILICON, die=Die(number=3104, mismatch=False)), 0.07, 0.3
    bench = nef_synapse.testbench(nef_synapse.build(), {"step": 0.3, "duration": stop}, ROLLS_180_IDEAL.v_dd)
    course = Course(((0.0, 27.0), (step - 1e-7, 27.0), (step, to)))
    found = simulate_course(bench, silicon, course, record=("v_syn",))
    taus = np.array([design_tau()])
    old, new = (filters_on(replace(silicon, temperature_c=t), taus, chip_biases()) for t in (27.0, to))

    def ratio(time: float, at: Filters) -> float:
        below = ROLLS_180_IDEAL.v_dd - float(np.interp(time, found.time, found["v_syn"]))
        return float(np.exp((below - at.middle[0]) / at.fold))

    assert ratio(step - 1e-4, old) == pytest.approx(1.3, rel=0.03)
    begin, end = float(moved_filters(np.array([1.3]), old, new)[0]), ratio(stop, new)
    assert abs(begin / end - 1.0) > 0.05
    for after in (0.5, 1.0, 2.0):
        expected = end + (begin - end) * np.exp(-after)
        assert ratio(step + after * new.tau[0], new) == pytest.approx(expected, rel=0.03)


def test_a_network_goes_on_and_a_temperature_that_stays_changes_nothing() -> None:
    chip = paper_chip(Die(number=42), neurons=64)
    built = build_network(NETWORK, chip.at(27.0), 0)
    runs = [Simulation(built) for _ in range(3)]
    for run in runs:
        run.set("in", 0.5)
        run.advance(0.2)
    runs[1].move(moved(built, chip.at(27.0)))
    runs[2].move(moved(built, chip.at(30.0)))
    seen = []
    for run in runs:
        run.advance(0.1)
        seen.append(run.read("x?")[0])
    assert seen[1] == pytest.approx(seen[0], rel=1e-9)
    # other currents from the same codes, but no jump to where a run at 30 degC begins
    assert seen[2] != pytest.approx(seen[0], rel=1e-3)
    assert seen[2] == pytest.approx(seen[0], abs=0.3)
