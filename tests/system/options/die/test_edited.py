"""Paths of devices that biases stand on are those of a block whose biases are of that kind."""

import pytest

from circuits.bias import rebias
from circuits.errors import UnknownNameError
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.options.die.edited import check_edits, check_known

PATH = "rebound_neuron.bias generator.v_rtau.mo1"


def test_a_generators_devices_are_known_where_biases_stand_on_it() -> None:
    gates = load_block("rebound-neuron").build()
    lines = rebias(gates, kind="generator")
    for path in (PATH, "rebound_neuron.bias generator.shared masters.*"):
        check_edits(Die().healed(path), [(lines, Silicon(AMI_1500))])
    check_known(Die().healed(PATH), [gates])  # of a robot: its lines are known when they are drawn
    with pytest.raises(UnknownNameError, match="no bias stands on a generator here; take the bias kind"):
        check_edits(Die().healed(PATH), [(gates, Silicon(AMI_1500))])
    with pytest.raises(UnknownNameError, match=r"v_rtau\.mo9, is the path of no device; did you mean"):
        check_edits(Die().healed(PATH[:-1] + "9"), [(lines, Silicon(AMI_1500))])
