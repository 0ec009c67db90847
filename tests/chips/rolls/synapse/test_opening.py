"""Where an event opens the transistor that empties a pulse's node."""

from __future__ import annotations

import numpy as np
import pytest

from chips.rolls.parts import extenders_at, row_place
from chips.rolls.synapse.opening import POINTS, opened
from circuits.blocks.rolls import dpi_synapse
from circuits.event import EDGE
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL, Process
from circuits.silicon.silicon import Silicon

DEVICE = "extender.mp1"


@pytest.mark.parametrize("process", [ROLLS_180, ROLLS_180_IDEAL], ids=lambda p: p.name)
@pytest.mark.parametrize("celsius", [0.0, 60.0])
def test_it_is_where_the_law_over_the_whole_event_has_it_to_the_last_bit(
    process: Process, celsius: float
) -> None:
    silicon = Silicon(process, celsius, Die("A", 1003))
    d = extenders_at(dpi_synapse.Params(), row_place(40, ("extender", ())), silicon, {})
    event = np.linspace(0.0, d.v_dd, POINTS)
    carried = d.columns().saturated(DEVICE, event)
    passed = np.cumsum(carried, axis=1) * (event[1] / d.v_dd * EDGE)
    # before the event begins, in its middle, in the last block of points, and beyond its end
    needed = np.resize(passed[:, [0, 300, 719]] * [0.5, 1.01, 1.0], 40)
    current = np.resize(carried[:, [0, 250, 720]] * [0.5, 0.99, 1.5], 40)
    rising, falling = opened(d, DEVICE, needed, current, EDGE)
    for k in range(40):
        assert rising[k] == np.interp(needed[k], passed[k], event)
        assert falling[k] == np.interp(current[k], carried[k], event)
    assert falling.max() == event[-1]
    assert rising.min() == falling.min() == 0.0
