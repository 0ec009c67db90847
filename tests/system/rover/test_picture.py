"""Pictures: the map's colours, the ways, and room for what leaves the map."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from system.rover.cost_map import CostMap, load_map
from system.rover.picture import draw_map, draw_scale_bar, draw_ways
from system.rover.run import SYSTEM, run
from system.rover.scenario import Scenario


def test_a_cost_has_one_colour_on_all_maps() -> None:
    ax = Figure().subplots()
    colours = []
    for costs in ([[1, 9]], [[9, 31]]):
        draw_map(CostMap("two", np.array(costs)), None, ax)
        image = ax.images[-1]
        colours.append({c: tuple(image.to_rgba(k)) for k, c in enumerate(costs[0])})
    assert colours[0][9] == colours[1][9]
    assert colours[0][1] != colours[0][9]


def test_the_bar_names_few_costs_and_blocked_cells() -> None:
    figure = Figure()
    draw_map(CostMap("some", np.array([[0, 1, 6]])), figure, figure.subplots())
    names = [tick.get_text() for tick in figure.axes[-1].get_yticklabels()]
    assert names == ["blocked", "1", "6"]


def test_many_costs_share_a_dozen_shades() -> None:
    figure = Figure()
    draw_map(CostMap("many", np.arange(400).reshape(20, 20)), figure, figure.subplots())
    names = [tick.get_text() for tick in figure.axes[-1].get_yticklabels()]
    assert names[0] == "blocked"
    assert 3 < len(names) <= 13


def test_a_rover_arrives_within_the_circle_that_is_drawn() -> None:
    trace, figure = run(Scenario()), Figure()
    SYSTEM.draw(trace, figure)
    ways = {str(line.get_label()): np.asarray(line.get_xydata()) for line in figure.axes[0].lines}
    goal, fix, circle = (ways[name] for name in ("goal", "last fix", "arrived with a fix within 10 m"))
    assert np.allclose(np.hypot(*(circle - goal).T), trace.scenario.rover.reach)
    assert np.hypot(*(fix - goal).T) <= trace.scenario.rover.reach


def test_ways_beyond_the_map_are_seen() -> None:
    park = load_map("map2")
    ax = Figure().subplots()
    draw_map(park, None, ax)
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.0, 180.0), (0.0, 120.0))
    draw_ways(np.array([[5.0, 5.0], [10.0, 5.0]]), [np.array([[5.0, 5.0], [200.0, -9.0]])], ax)
    draw_scale_bar(park, ax)
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.0, 201.0), (-10.0, 120.0))
    bar = ax.lines[-1].get_xydata()
    assert np.ptp(np.asarray(bar), axis=0).tolist() == [10.0, 10.0]
