"""Blame of a toy whose devices and their weights are known."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import pytest

from circuits.errors import ParameterError
from circuits.silicon.components import Extent
from circuits.silicon.die import Die, drawn_for, noted, shared, unnoted
from circuits.silicon.process import AMI_1500_IDEAL, POLARITIES, Polarity
from circuits.silicon.silicon import Silicon
from system.study.blame.blame import OTHERS, Blame, blame, enlarged
from system.study.blame.part import Parts
from system.study.blame.search import fewest, needed
from system.study.blame.story import (
    Told,
    caution_lines,
    current_ratio,
    device_lines,
    mended_options,
    told_runs,
    verdict_lines,
)
from system.study.blame.trial import ALL, Case, healed
from system.study.blame.verdict import ENOUGH, FEWEST, MOST, pairs_for
from tests.system.study.blame.robot import AREA, LIMIT, SYSTEM, Scenario, Trace, run

FAILS = 1003  # a die on which the toy fails


def case(die: Die, **given: float) -> Case:
    return Case(SYSTEM, SYSTEM.scenario(die=die, **given))


def total(die: Die) -> float:
    return abs(run(SYSTEM.scenario(die=die)).total)


@pytest.fixture(scope="module")
def found() -> Blame:
    return blame(case(Die(number=FAILS)))


def test_the_toy_fails_on_the_die_and_not_on_the_healed_one() -> None:
    assert total(Die(number=FAILS)) > LIMIT > total(Die(number=FAILS).healed(*ALL)) == 0.0


def test_what_is_found_mends_and_no_part_of_it_does(found: Blame) -> None:
    paths = [each.path for each in found.culprits]
    assert found.finished
    assert total(found.mended) < LIMIT
    for fewer in combinations(paths, len(paths) - 1):
        assert total(healed(found.case.die, list(fewer))) > LIMIT
    assert found.verified is not None
    assert found.verified.mends


def test_levels_go_from_circuits_to_parameters(found: Blame) -> None:
    levels = [step.level for step in found.steps]
    assert levels[0] == "circuit"
    assert levels[-1] == "parameter"
    assert found.steps[0].kept == ("toy_chip",)
    assert all(
        each.path.startswith("toy_chip.cell[") and each.path.endswith("v_t0") for each in found.culprits
    )


def test_planted_fault_is_named_alone() -> None:
    die = Die().with_("toy_chip.cell[5].near.m1", "v_t0", 0.05)
    own = blame(case(die))
    assert [each.path for each in own.culprits] == ["toy_chip.cell[5].near.m1.v_t0"]
    assert own.culprits[0].deviations["v_t0"] == (0.05, 0.0)


def test_what_mends_in_part_is_not_enough() -> None:
    """With the larger fault healed alone three of four trials succeed, for noise hides the other one."""
    die = Die()
    for cell, fault in ((5, 6e-3), (2, 3.5e-3)):
        die = die.with_(f"toy_chip.cell[{cell}].near.m1", "v_t0", fault)
    own = blame(Case(SYSTEM, SYSTEM.scenario(die=die, blur=0.7e-3, seed=100)))
    assert {each.path for each in own.culprits} == {f"toy_chip.cell[{k}].near.m1.v_t0" for k in (2, 5)}
    assert own.verified is not None
    assert own.verified.mends


def test_what_mends_nine_times_in_ten_is_not_enough() -> None:
    """With the larger fault healed alone nine of ten trials succeed, which 22 of them tell mostly."""
    die = Die()
    for cell, fault in ((5, 6e-3), (2, 3.1e-3)):
        die = die.with_(f"toy_chip.cell[{cell}].near.m1", "v_t0", fault)
    found = [
        blame(Case(SYSTEM, SYSTEM.scenario(die=die, blur=0.7e-3, seed=seed)))
        for seed in range(1000, 2000, 100)
    ]
    both = {f"toy_chip.cell[{k}].near.m1.v_t0" for k in (2, 5)}
    assert sum({each.path for each in own.culprits} == both for own in found) >= 8


def test_die_that_is_not_to_blame_ends_it() -> None:
    """Noise alone makes it fail as often on the healed die."""
    own = blame(case(Die(number=FAILS).healed("toy_chip"), blur=1.0))
    assert not own.accused.guilty
    assert len(own.accused.pairs.seeds) == ENOUGH
    assert own.culprits == ()
    assert "It is not the die" in verdict_lines(own)[0]


def test_die_without_a_failing_trial_is_refused() -> None:
    with pytest.raises(
        ParameterError, match=r"toy: on die A/1003, healed \* all trials of seeds 0 to 5 succ"
    ):
        blame(case(Die(number=FAILS).healed("*")))


def test_healed_die_that_cannot_be_run_is_no_verdict() -> None:
    def refused(scenario: Scenario, progress: object = None) -> Trace:
        if scenario.die.edits:
            raise ParameterError("codes: of another die")
        return run(scenario)

    own = Case(replace(SYSTEM, run=refused), SYSTEM.scenario(die=Die(number=FAILS)))
    with pytest.raises(ParameterError, match="no trial of the healed die can be made: codes: of another"):
        blame(own)


def test_search_that_runs_out_of_trials_says_so() -> None:
    own = blame(case(Die(number=FAILS)), most=OTHERS + 20)
    assert not own.finished
    assert own.trials <= OTHERS + 20
    assert any("its trials were over" in line for line in verdict_lines(own))


def test_parts_hold_the_devices_that_the_run_draws() -> None:
    own = case(Die(number=FAILS))
    parts = Parts(own.die, own.drawn())
    assert [part.path for part in parts.circuits()] == ["process", "toy_board", "toy_chip"]
    shared, _, chip = parts.circuits()
    law, nominal = (Silicon(die=die).law("n").v_t0 for die in (own.die, Die()))
    assert parts.deviations(parts.below(shared)[0])["v_t0"][0] == pytest.approx(law - nominal, rel=1e-9)
    assert parts.devices(chip) == 16
    below = parts.below(chip)
    assert [part.path for part in below] == ["toy_chip.cell[*].far", "toy_chip.cell[*].near"]


@pytest.mark.parametrize("variation", ["plain", "transistors"])
@pytest.mark.parametrize("polarity", POLARITIES)
def test_sigma_of_what_a_die_shares_is_that_of_the_process(variation: Extent, polarity: Polarity) -> None:
    own = noted(Die(number=FAILS, variation=variation), f"a test of {polarity}")
    shared(own, AMI_1500_IDEAL, polarity)
    parts = Parts(unnoted(own), drawn_for(own))
    names = ["process"] if variation == "plain" else ["die", "lot", "wafer"]
    assert [part.path for part in parts.circuits()] == names
    each = [parts.deviations(parts.below(part)[0]) for part in parts.circuits()]
    stated = AMI_1500_IDEAL.variation
    for name, sigma in (("v_t0", stated.sigma_v_t0), ("beta", stated.sigma_beta)):
        assert math.hypot(*(one[name][1] for one in each)) == pytest.approx(sigma, rel=1e-9)


def test_area_lessens_deviations_by_its_root(found: Blame) -> None:
    wide = enlarged(found.case.die, found.culprits, 4.0)
    name = found.culprits[0].path.removesuffix(".v_t0")
    value = found.culprits[0].deviations["v_t0"][0]
    assert [edit.value for edit in wide.edits if edit.paths == (name,)] == [pytest.approx(0.5 * value)]


def test_sigma_is_that_of_the_area(found: Blame) -> None:
    process = found.processes["toy_chip"]
    _, sigma = found.culprits[0].deviations["v_t0"]
    assert sigma == pytest.approx(process.pair_a_vt / (2.0 * AREA) ** 0.5, rel=1e-9)


def test_story_tells_current_and_command(found: Blame) -> None:
    told = told_runs(found)
    assert [told.summaries[name]["succeeded"] for name in told.traces] == [False, True, True]
    assert "times the design's" in device_lines(found)[0]
    assert ("heal", found.culprits[0].path) in mended_options(found)
    ratio = current_ratio({"v_t0": (0.01, 0.0)}, found.processes["toy_chip"], 27.0)
    assert ratio == pytest.approx(0.763, abs=2e-3)  # exp(-0.7 0.01 / 0.02585)


def test_the_command_sets_each_deviation_once_and_as_the_mended_die_has_it(found: Blame) -> None:
    path = found.culprits[0].path.removesuffix(".v_t0")
    planted = found.case.die.with_(path, "v_t0", 0.0123456789).with_("toy_chip.nothing", "v_t0", 0.0123456789)
    scenario = replace(found.case.scenario, die=planted)
    blamed = replace(found, case=replace(found.case, scenario=scenario))
    told = [text for name, text in mended_options(blamed) if name == "deviate"]
    assert told == ["toy_chip.nothing.v_t0=0.0123456789V", f"{path}.v_t0=0.0V"]


def test_pairs_grow_with_what_differs() -> None:
    assert pairs_for(0.0) == FEWEST
    assert FEWEST < pairs_for(0.1) == 77 < MOST  # the normal distribution's 62 have a power of 0.71
    assert pairs_for(0.9) == MOST


@pytest.mark.parametrize("needed", [{3}, {0, 9}, {2, 5, 11}])
def test_fewest_finds_what_is_needed(needed: set[int]) -> None:
    asked = 0

    def mends(parts: object) -> bool:
        nonlocal asked
        asked += 1
        return needed <= {*parts}

    assert {*fewest(list(range(16)), mends)} == needed
    assert asked <= 30


def test_needed_leaves_out_what_is_of_no_use() -> None:
    assert needed([1, 2, 3], lambda parts: {1, 3} <= {*parts}) == [1, 3]
    assert needed([1, 2], bool) == [1]


def test_fewest_prefers_what_comes_first() -> None:
    assert fewest([3, 1, 2], lambda parts: bool({*parts} & {1, 2})) == [1]


def test_robot_that_only_meets_its_success_is_told() -> None:
    own = {"the die": {"x": 0.0}, "the mended die": {"x": 0.4}, "the healed die": {"x": 1.0}}
    assert "in 1 of the 1 numbers" in caution_lines(Told(0, {}, own))[0]
    own["the mended die"]["x"] = 0.6
    assert caution_lines(Told(0, {}, own)) == []


def test_devices_alike_are_the_others_of_the_same_circuit_and_spread() -> None:
    own = case(Die(number=FAILS))
    parts = Parts(own.die, own.drawn())
    (cells_near,) = parts.below(parts.below(parts.circuits()[2])[1])
    near = parts.below(cells_near)[2]
    alike = parts.alike(near)
    paths = [alike[k].path for k in range(len(alike))]
    cells = [f"toy_chip.cell[{k}].{name}" for name in ("far.m2", "near.m1") for k in range(8)]
    assert len(parts.alike(parts.below(parts.circuits()[1])[0])) == 0  # the board has one device
    assert paths == [path for path in cells if path != near.path == "toy_chip.cell[2].near.m1"]
