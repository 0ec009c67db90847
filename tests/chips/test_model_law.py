"""What a die must be for behavioural models: they follow the gradients of their places."""

import numpy as np

from chips.rolls.parts import devices_at, row_place
from circuits.blocks.rolls import dpi_synapse
from circuits.silicon.components import ROLLS_180_COMPONENTS
from circuits.silicon.die import Die
from circuits.silicon.floor_plan import FLOOR_PLANS
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon


def test_a_chip_s_transistors_have_the_gradients_of_their_places() -> None:
    """Differences from the plain die are a plane over rows and columns, of the stated slope's size."""
    place = row_place(256, ("synapse", (256,)))
    circuit = dpi_synapse.synapse(dpi_synapse.Params())
    dies = Die(number=3), Die(number=3, variation="transistors")
    plain, more = (devices_at(circuit, place, Silicon(ROLLS_180_IDEAL, die=d), {}, ("me1",)) for d in dies)
    plane = (more.fet["me1"].v_t0 - plain.fet["me1"].v_t0).reshape(256, 256)
    down, right = np.diff(plane, axis=0), np.diff(plane, axis=1)
    np.testing.assert_allclose(down, down[0, 0], rtol=1e-6)
    np.testing.assert_allclose(right, right[0, 0], rtol=1e-6)
    pitches = FLOOR_PLANS["rolls_chip"]["row"].pitch[1], FLOOR_PLANS["rolls_chip"]["synapse"].pitch[0]
    for step, pitch in zip((down, right), pitches, strict=True):
        assert 0.0 < abs(step[0, 0]) < 5.0 * ROLLS_180_COMPONENTS.distance_v_t0 * pitch
