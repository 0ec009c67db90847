"""The draws behind a circuit's transistors, and what one sigma of each is."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Diode, Resistor, Transistor
from circuits.lowering.flatten import flatten
from circuits.lowering.variation import (
    drawn_families,
    variation_draws,
    variation_labels,
    variation_sigma,
)
from circuits.silicon.die import Die, shared
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon


def test_a_draw_times_its_sigma_is_what_a_device_deviates_by() -> None:
    silicon = Silicon(die=Die(number=3))
    flat = flatten(rebound_neuron.build())
    sigma, drawn = variation_sigma(flat, silicon), variation_draws(flat, silicon, silicon.die)
    moved = dict(zip(variation_labels(flat, silicon), drawn * sigma, strict=True))
    paths = [((*g.path, (g.device.name, ())), g) for g in flat.groups if isinstance(g.device, Transistor)]
    for path, group in paths:
        sizes = (group.parameters[name] for name in ("width", "length", "multiplicity"))
        found = silicon.deviation(flat.circuit.name, path, np.prod(list(sizes), axis=0))
        owner = ".".join((flat.circuit.name, *(name for name, _ in path)))
        assert moved[f"{owner}.v_t0"] == pytest.approx(float(np.ravel(found.v_t0)[0]))
        assert moved[f"{owner}.beta"] == pytest.approx(float(np.ravel(found.beta)[0]))
    shift = shared(silicon.die, silicon.process, "n")
    assert moved["process.n.shared.v_t0"] == pytest.approx(shift.v_t0)
    full = Silicon(die=Die(number=3, variation="full"))
    assert np.isnan(variation_sigma(flat, full)).any()


def test_edits_can_set_each_device_on_a_process_that_states_no_components() -> None:
    devices = (Resistor("r", "a", "0", 1e6), Diode("d", "a", "0"), Capacitor("c", "a", "0", 1e-12))
    flat = flatten(Circuit("rows", (Port("a", "supply"),), devices))
    bare = Silicon(replace(AMI_1500, components=None))
    found = {(paths[0][-1][0], name) for _, paths, name in drawn_families(flat, bare)}
    assert {("r", "resistance"), ("d", "saturation_current"), ("c", "capacitance")} <= found
