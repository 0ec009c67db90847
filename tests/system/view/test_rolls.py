"""A ROLLS neuron's waveform by its transistors, driven by what it got in a run of the chip's model."""

import re

import numpy as np
import pytest

from chips.rolls.chip import RollsChip
from chips.rolls.program.bias_file import default_biases
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.rolls.drive import program_of, regular_events
from system.view import rolls
from system.view.rolls import Heard, neuron_inside


def test_its_spikes_are_those_of_the_model_at_a_short_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rolls, "STRETCH", 0.02)
    chip = RollsChip(program_of(default_biases()), Silicon(ROLLS_180, die=Die(number=1003)), step=0.05e-3)
    given = regular_events(100.0, 0.05, 0)
    spikes, _ = chip.run(chip.at_rest(), 0.05, given)
    heard = Heard(spikes.times, spikes.neurons, lambda *_: given)
    panel = neuron_inside(chip, "neuron[12]", heard).waveform
    assert panel is not None
    here, there = (int(n) for n in re.findall(r"(\d+) spikes, (\d+) of the run", panel.title)[0])
    assert there > 10
    assert abs(here - there) <= 0.1 * there
    lines = {line.name: line for line in panel.lines}
    assert [name for name, line in lines.items() if line.shown] == ["v_mem", "spike"]
    rises = np.flatnonzero((lines["spike"].value[:-1] < 0.9) & (lines["spike"].value[1:] >= 0.9))
    assert rises.size == here
    assert neuron_inside(chip, "neuron[12]").waveform is None
