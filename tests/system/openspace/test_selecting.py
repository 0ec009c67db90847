"""The selection of a die, calibrated: its tail comes to the design's, and equals tie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.codes import Codes
from chips.selection.calibration import Design, biased, calibrate, ties
from chips.selection.model import selection
from circuits.blocks.selection.winner_take_all import Params
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.openspace.law import ARCS, Bat
from system.openspace.selecting import CALIBRATION, FIXED, Selecting, chosen_by, projection

SILICON = Silicon(AMI_1500, die=Die(number=102))
FEW = Design(Params(cells=5, sigma=1.13, reach=1))


@pytest.fixture(scope="module")
def codes() -> Codes:
    return calibrate(SILICON, "generator", FEW)


def test_the_tail_comes_to_the_design_and_equals_tie(codes: Codes) -> None:
    tail, time, *tied = codes.measured
    assert codes.failed == ""
    assert tail.after == pytest.approx(1e-6, rel=0.02)  # half a step of its code is 1 %
    assert abs(tail.before / 1e-6 - 1.0) > 0.1
    assert [m.name for m in tied] == [f"tie[{k}]" for k in range(5)]
    assert max(abs(m.before - 1.0) for m in tied) > 0.02
    # the search ends within 0.8e-3, and a share is of another excitation than that at which it was found
    assert max(abs(m.after - 1.0) for m in tied) < 5e-3
    assert 0.0 < time.after < 1e-3
    assert np.mean(codes.trims["excite"]) == pytest.approx(1.0)


def test_the_bats_selection_is_that_of_its_codes() -> None:
    """A line's codes and what the board multiplies by reach the chip; a gate's have neither."""
    key = calibrate(SILICON, "generator", FEW)
    board = tuple(np.linspace(0.9, 1.1, ARCS))
    codes = replace(key, trims={"excite": board})
    usual = chosen_by(Bat(), SILICON, 1.0, Selecting("generator"), None)
    own = chosen_by(Bat(), SILICON, 1.0, Selecting("generator", codes), None)
    assert own[2].tolist() == list(board)
    assert usual[2].tolist() == [1.0] * ARCS
    assert abs(own[0].tail / 1e-6 - 1.0) < abs(usual[0].tail / 1e-6 - 1.0)
    assert Selecting("gate", None) == FIXED


def test_a_cell_that_never_wins_is_told_and_given_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def dead(chip: object, excite: object = None) -> object:
        return np.array([np.nan, 1.0, 1.0, 1.1, 0.9])

    monkeypatch.setattr("chips.selection.calibration.ties", dead)
    found = calibrate(SILICON, "generator", FEW)
    assert found.off == {"cell": (0,)}
    assert found.trims["excite"][0] == 0.0
    assert "tie[0]: nothing could be measured" in found.unmended


def test_the_middle_ties_with_itself() -> None:
    nominal = Silicon(AMI_1500)
    chip = selection(nominal, FEW.params, biased(FEW.params, "generator"))
    assert ties(chip) == pytest.approx(np.ones(5), abs=5e-3)


def test_it_is_calibrated_for_the_usual_bat() -> None:
    assert CALIBRATION.setup == Design(projection(Bat()))
