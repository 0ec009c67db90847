"""The connectivity picture: its cells have the colour of their level, its frames the place of the groups."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle

from chips.rolls.program.connectivity_picture import draw_connectivity
from chips.rolls.program.network import Network
from chips.rolls.program.population import Population, all_to_all
from system.pushbot.network.plain import pushbot_network


def test_colours_frames_and_names() -> None:
    groups = (Population("left", (0, 1, 4)), Population("right", (2, 3)))
    network = Network(groups, (all_to_all(groups[0], groups[1], 4), all_to_all(groups[1], groups[0], -1)))
    figure = Figure()
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    draw_connectivity(network, axes)
    figure.canvas.draw()
    image = next(a for a in axes.get_children() if isinstance(a, AxesImage))
    rgba = image.to_rgba(image.get_array())
    assert rgba.shape == (5, 5, 4)
    excited, inhibited, none = rgba[2, 0], rgba[0, 2], rgba[0, 0]
    assert excited[0] > excited[2]  # red
    assert inhibited[2] > inhibited[0]  # blue
    assert none.tolist() == [1.0, 1.0, 1.0, 1.0]
    frames = [p for p in axes.patches if isinstance(p, Rectangle)]
    assert sorted((f.get_x(), f.get_width()) for f in frames) == [(-0.5, 2), (1.5, 2), (3.5, 1)]
    assert {text.get_text() for text in axes.texts} == {"left", "right"}


def test_every_level_has_its_own_colour() -> None:
    figure = Figure()
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    network = pushbot_network()
    draw_connectivity(network, axes)
    figure.canvas.draw()
    image = next(a for a in axes.get_children() if isinstance(a, AxesImage))
    colours = {int(k): tuple(image.to_rgba(np.array([[k]]))[0, 0]) for k in range(-4, 5)}
    assert len(set(colours.values())) == 9
    assert image.get_array().shape == (224, 224)
