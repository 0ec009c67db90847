"""The approach on a drawn die: at the codes of its calibration, at those of the design, with neurons off."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from chips.codes import Codes
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.approach.loop import models_of
from system.approach.run import run, run_in_loop
from system.approach.scenario import Scenario
from system.approach.trace import account, summarise
from system.codes.file import write_codes
from system.worlds.sound.targets import Approach, Target

DIE = Die(number=5)
NEAR = (
    Target("target", Approach(1.6, 1.1, 0.5)),
    Target("clutter", Approach(2.6, 2.1, 0.5), 1.5),
)
ON = Scenario(NEAR, 1.1, die=DIE, level="behavioural")


@pytest.fixture(scope="module")
def codes() -> Codes:
    found = ON.ranging_codes
    assert found is not None
    return found


def _at(path: Path, codes: Codes) -> Scenario:
    write_codes(path, codes)
    return replace(ON, codes=str(path))


def test_a_die_that_is_deaf_at_the_design_s_codes_holds_its_target_once_calibrated() -> None:
    deaf, calibrated = run(replace(ON, codes="default")), run(ON)
    assert deaf.spikes == ()
    assert summarise(deaf)["held_fraction"] == 0.0
    assert summarise(calibrated)["held_fraction"] == 1.0
    assert account(deaf).ran_on["codes"] == "default"
    assert account(calibrated).ran_on["codes"] == "calibrated"


def test_the_boards_are_trimmed_to_the_chip(codes: Codes) -> None:
    models = models_of(ON, 27.0)
    assert models.isolation is not None
    assert models.isolation.open_level == pytest.approx(codes.trims["v_ex_max"][0], abs=1e-3)
    design = models_of(replace(ON, codes="default"), 27.0)
    assert models.proximity.numbers.entry.tolist() != design.proximity.numbers.entry.tolist()
    # a neuron that stands for a later delay stands for a farther target
    delays = np.argsort(codes.trims["delays"])
    assert (np.diff(models.proximity.numbers.entry[delays]) <= 0.0).all()


def test_neurons_that_are_off_reach_nothing_in_either_loop(codes: Codes, tmp_path: Path) -> None:
    first = min(k for _, k in run(ON).spikes)
    off = _at(tmp_path / "off.toml", replace(codes, off={"neuron": (first,)}))
    compiled, looped = ({k for _, k in trace.spikes} for trace in (run(off), run_in_loop(off)))
    assert compiled == looped
    assert first not in compiled
    assert compiled


def test_codes_of_a_chip_that_is_of_no_use_are_refused(codes: Codes, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"die A/5 could not be calibrated, nothing works"):
        run(_at(tmp_path / "failed.toml", replace(codes, failed="nothing works")))
