"""A head that follows, on dies and in the wirings, and what it refuses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.head.run import SUMMARY, SYSTEM, Trace
from system.papers.conditions import FIXED_GATES
from system.system import ENTRIES
from tests.refusals import refusals


def run(**options: Any) -> Trace:
    return SYSTEM.run(SYSTEM.scenario(**{"duration": 8.0, **options}))


def error(**options: Any) -> float:
    found = SYSTEM.summarise(run(**options))["error_rms_deg"]
    assert found is not None
    return found


def test_it_follows_a_target_whatever_its_range_does() -> None:
    # at 2.5 deg a ping a head that is a ping and a half behind is off by 4 deg
    assert error() < 5.0
    assert error(swing=0.0) == pytest.approx(error(), abs=1.0)
    assert error(motion="walk", seed=3) < 6.0


def test_a_step_is_reached_and_kept() -> None:
    found = SYSTEM.summarise(run(motion="step", noise=0.0))
    assert found["error_max_deg"] == pytest.approx(40.0, abs=2.0)
    assert found["settled_rms_deg"] is not None
    # a level of 3 dB is 5 deg: between two levels' edges nothing turns the head
    assert found["settled_rms_deg"] < 2.5


def test_one_ear_loses_what_moves_in_range() -> None:
    found = SYSTEM.summarise(run(wiring="one-ear"))
    assert found["error_rms_deg"] is not None
    assert found["error_rms_deg"] > 5.0 * error()
    assert found["lost"] == found["faint"] + found["blanked"] + found["behind"] + found["late"]  # type: ignore[operator]
    assert found["lost"] > 0.0  # type: ignore[operator]


def test_excitation_alone_costs_many_spikes() -> None:
    lso, excited = (SYSTEM.summarise(run(wiring=w))["spikes_a_ping"] for w in ("lso", "excitation"))
    assert lso is not None
    assert excited is not None
    assert excited > 5.0 * lso > 0.0


def test_a_die_and_a_seed_are_the_same_again() -> None:
    one, again, other = (run(die=Die(number=n), seed=n) for n in (1000, 1000, 6))
    assert np.array_equal(one.log.head, again.log.head)
    assert not np.array_equal(one.log.head, other.log.head)


def test_small_devices_are_deaf_and_it_is_counted() -> None:
    found = SYSTEM.summarise(run(die=Die(number=2), area=1.0 / 16.0, **FIXED_GATES))
    assert found["deaf_levels"] is not None
    assert found["deaf_levels"] > 0.0
    assert set(found) == {*ENTRIES, *SUMMARY}


test_what_cannot_be_is_refused = refusals(
    ParameterError,
    lambda options: SYSTEM.scenario(**options),
    [
        ({"ping_rate": 0.0}, r"ping_rate: 0 Hz, must be > 0"),
        (
            {"ping_rate": 100.0},
            r"ping_rate: 100 Hz, an echo from 1.4 m takes 0.00816 s, must be below 0.6 of",
        ),
        ({"azimuth": 120.0}, r"target\.azimuth: 120 deg, must be below 90 deg; what is further is behind"),
        ({"gain": -1.0}, r"gain: -1 deg, must be >= 0"),
        ({"noise": math.nan}, r"noise: nan, must be >= 0"),
        ({"area": 0.0}, r"area: 0, must be > 0"),
        ({"motion": "jump"}, r"motion: jump, must be sine, step or walk"),
        ({"wiring": "none"}, r"wiring: none, must be lso, excitation or one-ear"),
        ({"duration": 0.01}, r"duration: 0.01 s, must be at least a ping's period, 0.1 s"),
        ({"seed": -1}, r"seed: -1, must be >= 0"),
        ({"swing": 1.5}, r"target\.swing: 1.5 m, must be below the distance, 1 m"),
    ],
)


def test_a_study_takes_the_runs_options() -> None:
    found = SYSTEM.study_options("behavioural", "ideal", {"area": "0.25", "motion": "step"})
    assert found == {"area": 0.25, "motion": "step", "bias_kind": "ideal"}
    with pytest.raises(ParameterError, match=r"map: not an option of head"):
        SYSTEM.study_options("behavioural", None, {"map": "x"})
    with pytest.raises(ParameterError, match=r"level: transistor, is no choice of head"):
        SYSTEM.study_options("transistor", None, {})


def test_the_picture_has_angles_and_rasters() -> None:
    figure = Figure(layout="constrained")
    SYSTEM.draw(run(duration=2.0), figure)
    assert [ax.get_ylabel().split("\n")[0] for ax in figure.axes] == [
        "azimuth (deg)", "range (m)", "LSO spikes", "level units",
    ]  # fmt: skip
    assert "lso, die nominal, 27 °C" in figure.get_suptitle()
