"""The ranging chip of a die on the bench: its windows overlap and stand where the design has them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from chips.codes import Codes
from chips.ranging.calibration import calibrate as calibration
from chips.ranging.calibration import setting
from chips.ranging.calibration.bench import Bench
from chips.ranging.calibration.calibrate import CALIBRATION, calibrate, delays, windows
from chips.ranging.calibration.found import delays_of, off_of, values_of
from chips.ranging.chip import RangingChip
from chips.ranging.circuit import BEST_DELAYS, NEURONS
from chips.ranging.response import tune
from circuits.arrays import Bools
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

SILICON = Silicon(AMI_1500, die=Die(number=5))
SPACING = BEST_DELAYS[1] - BEST_DELAYS[0]


@pytest.fixture(scope="module")
def codes() -> Codes:
    return calibrate(SILICON, "generator")


def test_all_neurons_of_a_die_where_none_worked_answer_about_their_delays(codes: Codes) -> None:
    usual = tune(RangingChip(SILICON).neurons_at(27.0))
    assert set(usual.classes) == {"never"}
    chip = tune(RangingChip(SILICON, codes=codes).neurons_at(27.0))
    assert chip.classes == ["works"] * NEURONS
    middle = 0.5 * (chip.first + chip.last)
    # one line of this die has no code for its neuron's delay, and is half a spacing off
    off = np.abs(middle - BEST_DELAYS)
    assert np.sort(off)[-2] < 0.5e-3
    assert off.max() < 0.75 * SPACING
    assert (codes.failed, codes.unmended, off_of(codes)) == ("", (), ())


def test_tables_are_trimmed_to_what_was_measured(codes: Codes) -> None:
    measured = [m.after for m in codes.measured if m.name.startswith("best_delay")]
    assert list(delays_of(codes)) == measured
    assert measured != list(delays_of(None)) == list(BEST_DELAYS)
    assert set(values_of(codes)) == {"i_inh_tau", *setting.BEGIN}
    assert values_of(None) == {}


def test_the_bench_makes_the_same_codes_again_and_says_how_long_it_took(codes: Codes) -> None:
    assert repr(CALIBRATION.calibrate(SILICON, "generator", None)) == repr(codes)  # NaNs alike
    # tens of series over all delays, of 160 trials of 80 ms
    assert 100.0 < codes.bench_s < 600.0


def test_a_window_is_of_what_was_answered() -> None:
    tried = delays()[:8]
    answers = np.zeros((8, 2), np.int64)
    answers[2:5, 0] = 1, 3, 1
    found = windows(answers, tried)
    assert found.width.tolist() == pytest.approx([3 * calibration.STEP, 0.0])
    assert found.middle[0] == tried[3]
    assert np.isnan(found.middle[1])


def _loud(count: int) -> type[Bench]:
    """A bench on which some neurons answer a call alone, whatever is done."""

    class Loud(Bench):
        def call_alone(self, values: Mapping[str, object], repeats: int = 2) -> Bools:
            return np.arange(NEURONS) < count

    return Loud


@pytest.mark.parametrize(("loud", "failed"), [(2, ""), (5, "5 of 13 neurons cannot be used")])
def test_neurons_that_cannot_be_mended_are_off_and_too_many_are_a_failure(
    monkeypatch: pytest.MonkeyPatch, loud: int, failed: str
) -> None:
    monkeypatch.setattr(calibration, "Bench", _loud(loud))
    monkeypatch.setattr(calibration, "_shared", lambda _: {**setting.BEGIN, "v_ex_max": 4.2})
    monkeypatch.setattr(calibration, "INHIBITION_ROUNDS", 3)
    found = calibrate(Silicon(AMI_1500), "generator")
    assert off_of(found) == tuple(range(loud))
    assert found.unmended[1] == "neuron[1]: it answers a call alone, switched off"
    assert found.failed == failed


def test_silicon_outside_the_model_s_box_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"ranging_chip.temperature: 90 degC, must be"):
        calibrate(Silicon(AMI_1500, 90.0), "generator")


@pytest.mark.parametrize("falls", [False, True])
def test_the_search_for_a_code_ends_at_the_nearest_one_even_of_a_line_that_jumps(falls: bool) -> None:
    codes = np.geomspace(10e-12, 1e-9, 400)
    delay = 1e-12 / codes
    if falls:
        delay[150:200] *= 1.05  # its currents fall where a higher bit of the code sets in
    wanted, tried, own = float(delay[180]), dict[int, float](), 120
    for _ in range(calibration.INHIBITION_ROUNDS):
        tried[own] = float(delay[own])
        own = calibration._next(codes, tried, own, wanted)
    best = calibration._best(tried, own, wanted)
    assert abs(delay[best] - wanted) <= max(setting.CENTRE_WITHIN, 0.02 * wanted)
