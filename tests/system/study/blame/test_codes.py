"""Blame of a toy whose codes take out what all devices of the die share."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.option import option
from system.options.codes import Coded
from system.study.blame.blame import Blame, blame
from system.study.blame.story import mended_options, verdict_lines
from system.study.blame.trial import ALL, Case, Trials
from tests.system.study.blame.robot import LIMIT, SYSTEM, Trace, run

FAILS = 1003  # whose cells make the toy fail
CELL = "toy_chip.cell[5].near.m1"


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario(Coded):
    """A drive at codes."""

    blur: float = option(0.0, "Noise of the sum", unit="V", least=0.0)


def shift(die: Die) -> float:
    """What nFETs of a die share, V."""
    return float(Silicon(AMI_1500, die=die).law("n").v_t0 - Silicon(AMI_1500, die=Die()).law("n").v_t0)


def run_coded(scenario: Scenario, progress: object = None) -> Trace:
    """The toy, steered too by what its codes leave of the die's shift."""
    coded = scenario.coded_on or scenario.die
    return Trace(scenario, run(scenario).total + shift(scenario.die) - shift(coded))  # type: ignore[arg-type]


TOY = replace(SYSTEM, kind=Scenario, run=run_coded)


def case(die: Die, **given: object) -> Case:
    return Case(TOY, Scenario(die=die, bias_kind="generator", **given))  # type: ignore[arg-type]


def planted() -> Die:
    """A die whose cells do not deviate, but for one."""
    return Die(number=FAILS).healed("toy_chip").with_(CELL, "v_t0", 0.05)


@pytest.fixture(scope="module")
def found() -> Blame:
    return blame(case(planted()))


def test_codes_of_the_die_make_the_healed_one_fail() -> None:
    own, die = case(planted()), planted()
    assert abs(shift(die)) > LIMIT
    trials = Trials(own)
    assert not trials.succeeds(die, 0)
    assert not trials.succeeds(own.healed(ALL), 0)
    assert trials.succeeds(own.healed(ALL), 0, own_codes=True)


def test_die_is_accused_with_the_healed_one_calibrated_anew(found: Blame) -> None:
    assert found.accused.guilty
    assert found.case.recalibrated
    assert found.held is not None
    assert not found.held.guilty
    assert [each.path for each in found.culprits] == [f"{CELL}.v_t0"]
    assert found.verified is not None
    assert found.verified.mends
    told = " ".join(verdict_lines(found))
    assert "healed of all deviations and calibrated anew in 12 of 12" in told
    assert "the healed die succeeds in 0 of 12" in told
    assert "Beside: the mended die at the codes of the die succeeds in 6 of 6" in told


def test_die_that_is_not_to_blame_with_either_codes_says_how_it_was_asked() -> None:
    own = blame(case(Die(number=FAILS).healed("toy_chip"), blur=1.0))
    assert not own.accused.guilty
    assert own.held is not None
    first, second = verdict_lines(own)
    assert "healed of all deviations and calibrated anew in" in first
    assert second.endswith("So it was calibrated anew.")


def test_command_of_the_mended_robot_calibrates_it(found: Blame) -> None:
    assert "codes_of" not in dict(mended_options(found))
    held = replace(found, case=replace(found.case, recalibrated=False))
    assert dict(mended_options(held))["codes_of"] == str(FAILS)


def test_trials_of_the_die_itself_are_made_once() -> None:
    own = case(planted())
    trials = Trials(own)
    trials.succeeds(own.die, 0)
    trials.case = replace(own, recalibrated=True)
    trials.succeeds(own.die, 0)
    assert trials.made == 1


@pytest.mark.parametrize("given", [{"codes": "default"}, {"coded_on": Die(number=1004)}])
def test_codes_that_are_asked_for_stay(given: dict[str, object]) -> None:
    own = blame(case(planted(), **given))
    assert not own.case.recalibrated
    assert own.held is None


def test_healed_die_that_cannot_be_run_with_the_codes_is_calibrated_anew() -> None:
    def refused(scenario: Scenario, progress: object = None) -> Trace:
        if scenario.coded_on is not None and scenario.die != scenario.coded_on:
            raise ParameterError("codes: of another die")
        return run_coded(scenario)

    own = blame(Case(replace(TOY, run=refused), case(planted()).scenario))
    assert own.accused.guilty
    assert own.held is None
    assert "the healed die cannot run" in " ".join(verdict_lines(own))
