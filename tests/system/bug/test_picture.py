"""The Bug robot's picture: what it ran on, and a title that stays in the figure."""

from __future__ import annotations

from circuits.silicon.die import Die
from system.bug.run import SYSTEM, run
from system.bug.scenario import Scenario
from tests.pictures import figure_of_files, leaving, legend_of

SHORT = Scenario(brain="chip", die=Die(number=4001), duration=0.2, codes="default", neurons=500)


def test_the_picture_names_its_silicon_and_all_that_is_drawn() -> None:
    trace, figure = run(SHORT), figure_of_files()
    SYSTEM.draw(trace, figure)
    title = figure.axes[0].get_title()
    assert "die A/4001, 27 °C, biases of kind generator" in title
    assert SYSTEM.account(trace).headline in title.replace("\n", " ")
    assert legend_of(figure) == {"obstacle", "start", "goal", "path", "shortest path of a point"}
    assert leaving(figure) == []


def test_a_program_has_no_silicon() -> None:
    trace, figure = run(Scenario(duration=1.0)), figure_of_files()
    SYSTEM.draw(trace, figure)
    assert "die" not in figure.axes[0].get_title()
    assert leaving(figure) == []
