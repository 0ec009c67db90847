"""What the full law moves in a ROLLS chip: the Early effect moves charges and times as its drains stand."""

import numpy as np
import pytest

from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.papers.checks import rolls_law
from system.papers.checks.rolls_law import charge_error, moved, of_neuron, of_synapses
from system.papers.checks.second_order import EFFECTS, percent


def test_the_early_effect_alone_moves_charges_and_times_as_its_drains_stand() -> None:
    ideal, early = of_synapses(()), of_synapses(EFFECTS["Early effect"])
    # I_pwlk's drain is further from its source than its gate, so that it is larger and the pulse shorter
    assert early["pulse_s"] < 0.98 * ideal["pulse_s"]
    # and the excitatory mirror's copy draws more than its diode gets
    assert (
        early["charge_of_level_1_C"] / early["pulse_s"]
        > 1.05 * ideal["charge_of_level_1_C"] / ideal["pulse_s"]
    )
    assert percent(ideal["pulse_s"], None) != percent(ideal["pulse_s"], early["pulse_s"])
    # 122.6 pA without: of the ideal law (docs/evidence/rolls.md)
    assert of_neuron(())["least_current_A"] == pytest.approx(0.12256e-9, rel=1e-3)


def test_depressed_charges_and_plastic_moves_are_held_against_their_transistors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(rolls_law, "LENGTH", 120)
    monkeypatch.setattr(rolls_law, "EVENTS", 12)
    monkeypatch.setattr(rolls_law, "PULSES", 3)
    silicon = Silicon(ROLLS_180, 27.0, Die(number=1003))
    assert 1e-6 < charge_error(silicon, "gate", 2) < 0.02
    ours, theirs = moved(silicon, "gate")
    assert ours.size == theirs.size == 12
    assert np.abs(ours - theirs).max() < 0.05
