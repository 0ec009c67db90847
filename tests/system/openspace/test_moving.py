"""Senses of chips whose temperature moves: a ping has those of its time."""

from __future__ import annotations

import numpy as np

from circuits.silicon.course import Course, Points, course_through
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.openspace.flight import fly_sample, planter
from system.openspace.law import Bat, arcs_of
from system.openspace.moving import Moving, along_jitter, still
from system.openspace.population import jitter_of
from system.openspace.senses import Sensing, senses_of
from system.openspace.senses_kernel import Senses

BAT, SENSING = Bat(), Sensing("chip", silicon_noise="white")
STEP: Points = ((0.0, 27.0), (2.0, 27.0), (2.000001, 40.0))  # of the temperature, after 20 pings


def made(celsius: float) -> Senses:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=celsius, die=Die(number=1003))
    return senses_of(SENSING, BAT, silicon, (5, 1), 27.0, "gate")


def moving(points: Points) -> Moving:
    return Moving(
        along_jitter(points, 27.0, made, lambda s: jitter_of(s.population, s.reader)), course_through(points)
    )


def test_pings_are_counted_up_to_a_change() -> None:
    senses = Moving(lambda _: made(27.0), Course(STEP))
    assert [senses.pings(time, 100) for time in (0.0, 1.99, 2.1)] == [1, 1, 100]
    assert senses.after(5.0).pings(0.0, 100) == still(made(27.0)).pings(0.0, 100) == 100


def test_each_ping_has_the_senses_of_its_time() -> None:
    logs = {}
    for name, senses in (("still", made(27.0)), ("flat", moving(((0.0, 27.0),))), ("step", moving(STEP))):
        sample, first = fly_sample(arcs_of(BAT), planter(300), (5, 1), 80, None, 80, None, senses)
        assert sample.pings == 80
        logs[name] = first.log
    assert np.array_equal(logs["still"], logs["flat"])
    early = logs["still"][:, 0] <= 2.0
    assert np.array_equal(logs["still"][early], logs["step"][early])
    assert not np.array_equal(logs["still"], logs["step"])


def test_the_noise_of_a_reader_goes_on() -> None:
    at = along_jitter(STEP, 27.0, made, lambda s: jitter_of(s.population, s.reader))
    cold = at(1.0)
    cold.reader.jitter.calls[0], cold.reader.jitter.last[0] = 7, 1.0
    cold.reader.jitter.relaxation[:] = 0.5
    warm = at(3.0)
    assert warm is not cold
    assert (warm.reader.jitter.calls[0], warm.reader.jitter.last[0]) == (7, 1.0)
    assert (warm.reader.jitter.relaxation == 0.5).all()
    assert at(4.0) is warm
