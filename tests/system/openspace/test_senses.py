"""Options of the senses: what is refused, and what reaches the compiled loop."""

from __future__ import annotations

import math

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.openspace.flight import fly_sample, planter
from system.openspace.law import ARCS, Bat, arcs_of
from system.openspace.selecting import projection
from system.openspace.senses import EXACT, Sensing, senses_of, with_area
from tests.refusals import refusals

test_what_is_refused = refusals(
    ParameterError,
    lambda options: Sensing(**options),
    [
        ({"ranges": "radar"}, "ranges: radar, must be exact, sonar or chip"),
        ({"selection": "best"}, "selection: best, must be ideal or chip"),
        ({"ranges": "chip", "reader": "x"}, "reader: x, must be nominal or calibrated"),
        ({"ranges": "sonar", "azimuth_noise": math.nan}, "azimuth_noise: nan degrees"),
        ({"ranges": "sonar", "azimuth_noise": -0.1}, "azimuth_noise: -5.7"),
        ({"occlusion": True}, "occlusion: not with `ranges=exact`; give `ranges=sonar` or `ranges=chip`"),
        ({"multipath": True}, "multipath: not with"),
        ({"azimuth_noise": 0.1}, "azimuth_noise: not with"),
        ({"ranges": "sonar", "reader": "calibrated"}, "reader: not with `ranges=sonar`; give"),
    ],
)


def test_areas_that_are_none_are_refused() -> None:
    for ranges, selection in (("chip", "ideal"), ("exact", "chip")):
        with pytest.raises(ParameterError, match="area: 0 times"):
            senses_of(with_area(Sensing(ranges, selection), 0.0), Bat())


def test_exact_is_the_paper() -> None:
    assert (EXACT.exact, EXACT.selecting, EXACT.reading.size) == (1, 0, 0)
    assert not Sensing("sonar").silicon
    assert Sensing(selection="chip").silicon


def test_the_circuit_has_the_bats_width() -> None:
    found = projection(Bat(suppression_sigma=2.0))
    assert (found.cells, found.sigma, found.reach) == (ARCS, 2.0, 3)  # the block's own, with all cells
    assert projection(Bat(suppression_sigma=0.4)).reach == 1


def test_noise_is_the_seeds() -> None:
    noisy = Sensing("sonar", azimuth_noise=math.radians(5.0))
    one, again, other = (senses_of(noisy, Bat(), seed=(s, 0)).noise for s in (1, 1, 2))
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)
    assert one.std() == pytest.approx(math.radians(5.0), rel=0.02)  # 65,521 draws: 0.3 % standard error


def test_a_die_is_a_die() -> None:
    both = Sensing("chip", "chip")
    one, again, other = (
        senses_of(both, Bat(), Silicon(AMI_1500_IDEAL, die=Die(number=n))) for n in (1000, 1000, 1001)
    )
    assert np.array_equal(one.reading, again.reading, equal_nan=True)
    assert np.array_equal(one.chip.cell_threshold, again.chip.cell_threshold)
    assert not np.array_equal(one.reading, other.reading, equal_nan=True)
    assert not np.array_equal(one.chip.cell_threshold, other.chip.cell_threshold)


def test_what_is_counted_along_a_sample() -> None:
    arcs = arcs_of(Bat())
    sonar = senses_of(Sensing("sonar", occlusion=True, multipath=True), Bat())
    chip = senses_of(Sensing("chip", "chip"), Bat())
    one = fly_sample(arcs, planter(1200), (4, 0), 400, senses=sonar)[0]
    assert min(one.heard, one.masked, one.occluded, one.ghosts) > 0
    assert one.missed == one.late == 0
    other = fly_sample(arcs, planter(1200), (4, 0), 400, senses=chip)[0]
    assert other.missed > 0
    assert other.masked == other.occluded == other.ghosts == 0
    # a decision takes some tens of microseconds where it is clear, and at most a millisecond
    assert 1e-6 * other.pings < other.deciding_s < 1e-3 * other.pings
