"""Blame of what a die's devices share: its lot, its wafer, its own part, and gradients across it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from circuits.silicon.components import DIES_A_WAFER
from circuits.silicon.die import DIE_PLACE, LEVELS, Die, shared
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.options.die.edited import check_drawn
from system.study.blame.blame import blame, enlarged
from system.study.blame.part import Parts
from system.study.blame.story import device_lines, mended_options
from system.study.blame.trial import ALL, Case, healed
from tests.system.study.blame.robot import SYSTEM, Scenario, Trace

COLUMN = ((("neuron", (13,)), ("membrane", ()), ("mr1", ())),)
WIDE = 1e-8  # m^2, of devices whose own mismatch is small
SHIFT = 40e-3  # V, of what nFETs share, up to which the toy steers straight
TILT = 6e-3  # V, from the first cell to the last, up to which it does


def on_shift(scenario: Scenario, progress: object = None) -> Trace:
    """A toy that steers by what nFETs share, as a share of what it bears."""
    silicon = Silicon(AMI_1500, die=scenario.die)
    own = silicon.law("n").v_t0 - replace(silicon, die=Die()).law("n").v_t0
    silicon.deviations("ranging_chip", COLUMN, WIDE, ("n",))
    return Trace(scenario, 4e-3 * own / SHIFT)


def on_tilt(scenario: Scenario, progress: object = None, area: float = WIDE) -> Trace:
    """A toy that steers by how much the ends of a column of cells differ, as a share of what it bears."""
    silicon = Silicon(AMI_1500, die=scenario.die)
    own = silicon.deviations("ranging_chip", COLUMN, area, ("n",)).v_t0 * np.ones(13)
    silicon.law("n")
    return Trace(scenario, 4e-3 * (own[0] - own[-1]) / TILT)


def case(run: object, die: Die) -> Case:
    return Case(replace(SYSTEM, run=run), SYSTEM.scenario(die=die))


def fails(run: object, die: Die) -> bool:
    own = case(run, die)
    return not own.success(own.system.summarise(own.system.run(own.scenario)))


def drawn(number: int, lot: str = "A") -> Die:
    return Die(lot, number, variation="transistors")


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("corner", ["plain", "transistors"])
def test_planted_part_of_a_lot_a_wafer_or_a_die_is_named(level: object, corner: str) -> None:
    ((name, _),) = level  # type: ignore[misc]
    die = Die(number=1003, variation=corner).with_(f"{name}.n", "v_t0", 0.1)  # type: ignore[arg-type]
    found = blame(case(on_shift, die))
    assert [each.path for each in found.culprits] == [f"{name}.n.v_t0"]
    assert found.verified is not None
    assert found.verified.mends
    assert (found.random, found.area) == (None, None)
    assert [*found.culprits[0].deviations] == ["v_t0"]
    assert "their currents are" in device_lines(found)[0]


@pytest.mark.parametrize("level", LEVELS)
def test_drawn_part_that_alone_is_at_fault_is_named_alone(level: object) -> None:
    ((name, _),) = level  # type: ignore[misc]
    others = [f"{one[0][0]}.n" for one in LEVELS if one != level]
    dies = (drawn(DIES_A_WAFER * k, f"lot {n}") for n in range(200) for k in range(5))
    die = next(
        die for die in dies
        if fails(on_shift, die) and not fails(on_shift, die.healed(f"{name}.n"))
        and all(fails(on_shift, die.healed(other)) for other in others)
    )  # fmt: skip
    found = blame(case(on_shift, die))
    assert [each.path for each in found.culprits] == [f"{name}.n.v_t0"]
    assert [step.kept for step in found.steps[:1]] == [(name,)]


def test_gradient_that_alone_is_at_fault_is_named() -> None:
    die = next(die for die in map(drawn, range(3000, 3200)) if fails(on_tilt, die))
    assert not fails(on_tilt, die.healed("gradient"))
    assert fails(on_tilt, die.only("gradient"))
    found = blame(case(on_tilt, die))
    assert [each.path for each in found.culprits] == ["gradient.n.y.v_t0"]
    value, sigma = found.culprits[0].deviations["y.v_t0"]
    assert sigma == pytest.approx(4.0)  # V/m, of the process
    tilt = on_tilt(found.case.scenario).total * TILT / 4e-3
    assert tilt == pytest.approx(value * 12 * 110e-6, rel=0.2)  # the rest is the cells' own
    told = device_lines(found)[0]
    assert told.startswith("gradient.n.y.v_t0: V_T0 ")
    assert f" a mm in y ({abs(value / sigma):.1f} sigma)" in told
    assert ("heal", "gradient.n.y.v_t0") in mended_options(found)
    check_drawn(found.mended)


def test_device_tells_what_a_gradient_adds_and_keeps_it_where_it_is_larger() -> None:
    run = partial(on_tilt, area=2e-11)
    dies = map(drawn, range(3000, 3400))
    die = next(die for die in dies if fails(run, die) and fails(run, die.healed("gradient")))
    own = case(run, die)
    parts = Parts(own.die, own.drawn())
    (chip,) = [part for part in parts.circuits() if part.path == "ranging_chip"]
    first = parts.below(parts.below(chip)[0])[0] if len(parts.below(chip)) == 1 else parts.below(chip)[0]
    (whole,) = Silicon(AMI_1500, die=die).deviation("ranging_chip", COLUMN[0], 2e-11, "n").v_t0[:1]
    assert parts.deviations(first)["v_t0"][0] + parts.slopes(first)["v_t0"] == pytest.approx(whole, rel=1e-9)
    found = blame(own)
    assert found.culprits[0].slopes["v_t0"] != 0.0
    assert " by gradients" in device_lines(found)[0]
    large = enlarged(die, found.culprits, 1e12)
    path = found.culprits[0].path
    index = int(path.partition("[")[2].partition("]")[0])
    left = Silicon(AMI_1500, die=large).deviation("ranging_chip", COLUMN[0], 2e-11, "n").v_t0[index]
    assert left == pytest.approx(found.culprits[0].slopes["v_t0"], rel=1e-3)


def test_parts_of_what_is_shared_are_all_of_it() -> None:
    die = drawn(1003)
    whole = shared(die, AMI_1500, "p")
    for healed_of in ("process", "lot wafer die", "lot wafer process.p"):
        assert tuple(map(abs, shared(die.healed(*healed_of.split()), AMI_1500, "p"))) == (0.0, 0.0)
    each = [shared(die.only(f"{place[0][0]}.p"), AMI_1500, "p") for place in LEVELS]
    assert np.sum(each, axis=0) == pytest.approx(whole, rel=1e-9)
    assert np.all(np.array(each))
    told = die.healed("process").with_("wafer.p", "v_t0", 0.02)
    for edited in (told, told.without_mismatch()):
        assert shared(edited, AMI_1500, "p") == (0.02, 0.0)
    assert DIE_PLACE in LEVELS


def test_gradient_alone_is_that_of_the_die() -> None:
    die = drawn(1003)
    area = 1e-11
    of = {
        name: Silicon(AMI_1500, die=each).deviations("ranging_chip", COLUMN, area, ("n",)).v_t0
        for name, each in {
            "all": die, "without": die.healed("gradient"), "alone": die.only("gradient"),
            "one": die.only("gradient", "ranging_chip.neuron[2]"),
        }.items()
    }  # fmt: skip
    assert of["alone"] + of["without"] == pytest.approx(of["all"], rel=1e-9)
    assert np.any(of["alone"])
    np.testing.assert_array_equal(of["one"] != of["alone"], np.arange(13) == 2)
    assert of["one"][2] == of["all"][2]


def test_what_is_set_elsewhere_is_not_set_where_it_means_nothing() -> None:
    die = drawn(1003).with_("chip[2].m1", "beta", 0.1).with_("wafer.n", "v_t0", 0.1)
    made = {
        path: [(edit.paths[0], edit.parameter) for edit in healed(die, [path]).edits if edit.value == 0.0]
        for path in ("gradient.n.x.v_t0", "chip[*].m1.beta", "wafer", "chip.m1.v_t0", *ALL)
    }
    assert {path: [each for each in sets if each[1]] for path, sets in made.items()} == {
        "gradient.n.x.v_t0": [],
        "chip[*].m1.beta": [("chip[*].m1", "beta")],
        "wafer": [("wafer", "v_t0")],
        "chip.m1.v_t0": [],
        "*": [("*", "beta"), ("*", "v_t0")],
    }
