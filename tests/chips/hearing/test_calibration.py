"""The hearing on the bench: a deaf onset neuron hears, and a trimmer is a threshold of its follower."""

from __future__ import annotations

import pytest

from chips.hearing.calibration import LEVELS, RESERVE, WITHIN, calibrate, level_of
from chips.hearing.mismatch import LEVEL
from chips.hearing.mismatch_measure import Deviating, rest_margin
from chips.hearing.model import hearing_on, rest_margin_on
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

NOMINAL = Silicon(AMI_1500)
DEAF = Silicon(AMI_1500, die=Die(number=1072))


def test_a_deaf_die_hears() -> None:
    assert rest_margin_on(DEAF) < 0.0
    codes = calibrate(DEAF, "generator")
    margin = rest_margin_on(DEAF, level_of(codes))
    assert RESERVE - WITHIN < margin < RESERVE + 2.0 * WITHIN
    assert codes.failed == ""
    assert 0.0 < codes.bench_s < 10.0
    # without a warning, which is an error here
    assert hearing_on(DEAF, v_level=level_of(codes)).onset.threshold > 0.0


def test_the_nominal_die_stays_where_it_is() -> None:
    assert level_of(calibrate(NOMINAL, "generator")) == pytest.approx(LEVEL, abs=2.0 * WITHIN)
    assert level_of(None) == LEVEL


def test_a_trimmer_is_a_threshold_that_is_lower_by_as_much() -> None:
    shifted = rest_margin(Deviating(NOMINAL, "onset_neuron/mt.v_t0", -10e-3))
    assert rest_margin_on(NOMINAL, LEVEL + 10e-3) == pytest.approx(shifted, abs=1e-3)


def test_a_neuron_that_hears_at_no_level_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("chips.hearing.calibration.rest_margin_on", lambda *_: -1.0)
    assert calibrate(NOMINAL, "generator").failed == "its onset neuron hears at no level"
    assert LEVELS[0] < LEVEL < LEVELS[1]


def test_silicon_outside_the_model_s_box_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"hearing.temperature: 90 degC, must be"):
        calibrate(Silicon(AMI_1500, 90.0), "generator")
