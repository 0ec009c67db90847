"""What devices behind biases move their lines by, against differences of moved dies."""

import numpy as np
import pytest

from circuits.bias import bias_voltages, rebias
from circuits.lowering.bias_moves import bias_families, bias_moves
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, ROLLS_180
from circuits.silicon.sampling import labels
from circuits.silicon.silicon import Silicon

STEP = {"v_t0": 1e-4, "beta": 1e-3}


@pytest.mark.parametrize("kind", ["ideal", "generator"])
@pytest.mark.parametrize(
    ("block", "process", "bias"),
    [("rebound-neuron", AMI_1500, "i_rtau"), ("rolls-neuron", ROLLS_180, "i_thr")],
)
def test_moves_are_those_of_moved_dies(block, process, bias, kind):
    circuit = rebias(load_block(block).build(), kind=kind)
    silicon = Silicon(process, die=Die(number=3))
    for moves in bias_moves(circuit, circuit.bias(bias), silicon):
        family = moves.family
        for parameter, by in (("v_t0", moves.by_v_t0), ("beta", moves.by_beta)):
            names = labels(family.place, family.paths, parameter)
            assert by.shape == (1, len(names))
            largest = np.abs(by[0]).max()
            for k in np.argsort(-np.abs(by[0]))[:3]:
                ends = []
                for step in (STEP[parameter], -STEP[parameter]):
                    path = names[k].rpartition(".")[0]
                    drawn = _drawn(family, silicon, parameter)[k]
                    there = Silicon(process, die=silicon.die.with_(path, parameter, drawn + step))
                    ends.append(float(bias_voltages(circuit, circuit.bias(bias), there)))
                told = (ends[0] - ends[1]) / (2.0 * STEP[parameter])
                assert by[0, k] == pytest.approx(told, rel=2e-3, abs=1e-4 * largest)


def _drawn(family, silicon, parameter):
    polarity = ["n"] * len(family.paths)  # of a plain die, which does not ask for it
    there = Silicon(silicon.process, die=silicon.die, place=family.place)
    return np.ravel(getattr(there.deviations("", family.paths, family.area, polarity), parameter))


def test_every_device_stands_once_and_fixed_gates_have_none():
    circuit = load_block("rebound-neuron").build()
    assert bias_families(circuit, Silicon(AMI_1500)) == ()
    copies = bias_families(rebias(circuit, kind="ideal"), Silicon(AMI_1500))
    currents = [b for b in circuit.biases if b.kind != "voltage"]
    assert [each.area.size for each in copies] == [1] * len(currents)
    lines = bias_families(rebias(circuit, kind="generator"), Silicon(AMI_1500))
    assert len(lines) == len(currents) + 1  # and what they share
