"""Pictures of a ROLLS die."""

import numpy as np
from matplotlib.figure import Figure

from system.rolls.picture import draw_curves


def test_curves_show_every_neuron_their_mean_and_the_nominal_one() -> None:
    ax = Figure().subplots()
    currents = np.array([1e-10, 1e-9])
    rates = np.array([[0.0, 10.0, 20.0], [100.0, 110.0, 120.0]])
    draw_curves(currents, rates, np.array([8.0, 105.0]), ax)
    lines = ax.get_lines()
    assert len(lines) == 3 + 3
    assert np.asarray(lines[4].get_ydata()).tolist() == [10.0, 110.0]
    assert np.asarray(lines[5].get_ydata()).tolist() == [8.0, 105.0]
