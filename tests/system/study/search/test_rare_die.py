"""Rare failures of a block whose probability is known, and what is refused."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import pytest
from scipy.special import ndtr

from circuits.lowering.kernel import Machine
from system.cli.command_line import main
from system.options.silicon import SiliconChoice
from system.study.target import BlockTarget, Subject, open_target

BLOCK = "rebound-neuron"
HERE = "tests.system.study.search.test_rare_die"
SIGMA_LIMIT = 3.5


def thresholds(machine: Machine) -> float:
    """A normal, of four draws that the process has: one threshold without mismatch."""
    return float(machine.kernel.transistors.v_t0[4])


def raising(machine: Machine) -> float:
    """Fails where the other is above 2 sigma: a die that cannot be measured is one that fails."""
    if thresholds(machine) > limit(2.0):
        raise ZeroDivisionError("no slope")
    return 1.0


@cache
def moments() -> tuple[float, float]:
    """Nominal value and standard deviation of `thresholds`, from the process's own figure."""
    subject = Subject(BLOCK, (f"{HERE}:thresholds",), silicon=SiliconChoice(mismatch=False))
    target = open_target(subject)
    assert isinstance(target, BlockTarget)
    machine = target.machines(27.0)[0]
    return thresholds(machine), machine.silicon.process.variation.sigma_v_t0


def limit(sigmas: float) -> float:
    mean, sigma = moments()
    return mean + sigmas * sigma


def spec(sigmas: float = SIGMA_LIMIT) -> str:
    return f"thresholds in :{limit(sigmas)!r}"


def run_json(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert main(("montecarlo", BLOCK, "--no-mismatch", *arguments, "--json")) == 0
    return json.loads(capsys.readouterr().out)["rare"]


def test_mean_shift_finds_a_known_probability(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("--metric", f"{HERE}:thresholds", "--spec", spec(), "-n", "1500")
    found = run_json(capsys, *asked, "--rare", "mean-shift")
    true = float(ndtr(-SIGMA_LIMIT))
    # with some hundred effective samples the estimate is known to about 10 %, three times that is allowed
    assert found["probability"] == pytest.approx(true, rel=0.3)
    assert found["effective_samples"] > 50.0
    assert found["interval"]["low"] < found["probability"] < found["interval"]["high"]
    assert found["samples"] == 1500
    assert run_json(capsys, *asked, "--rare", "mean-shift", "--threads", "1") == found


def test_scaled_sigma_is_printed_as_an_extrapolation(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("--metric", f"{HERE}:thresholds", "--spec", spec(), "-n", "1500", "--no-mismatch")
    assert main(("montecarlo", BLOCK, *asked, "--rare", "scaled-sigma")) == 0
    out = capsys.readouterr().out
    assert "probability " in out
    assert "95 % interval" in out
    assert "scaled-sigma, 1500 samples, an extrapolation; failures " in out


def test_a_die_that_cannot_be_measured_fails(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("--metric", f"{HERE}:raising", "--spec", "raising in 0:2", "-n", "1000")
    found = run_json(capsys, *asked, "--rare", "mean-shift")
    assert found["probability"] == pytest.approx(float(ndtr(-2.0)), rel=0.3)


def test_what_it_refuses_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    def refused(*arguments: str, target: str = BLOCK, method: str = "mean-shift") -> str:
        assert main(("montecarlo", target, *arguments, "--rare", method)) != 0
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        return error

    own = ("--metric", f"{HERE}:thresholds", "--no-mismatch", "-n", "500")
    assert "must come with --spec" in refused(*own)
    assert "so not with --csv" in refused(*own, "--spec", spec(), "--csv", "a.csv")
    assert "so not with --plan" in refused(*own, "--spec", spec(), "--plan", "lhs")
    assert "must be one" in refused(*own, "--spec", spec(), "--corner", "random", "--corner", "ss")
    assert "is a system" in refused("--metric", "calls", "--spec", "calls in 1:", target="approach")
    assert "samples: 20, must be >= 500" in refused(*own[:3], "-n", "20", "--spec", spec())
    assert "mean-shift: " in refused(*own, "--spec", spec(40.0))
    # 68 draws of 3.3 mV at this device are too many for a thousand dies
    local = (
        "--metric",
        f"{HERE}:thresholds",
        "--no-process-variation",
        "--spec",
        f"thresholds in :{moments()[0] + 0.012!r}",
    )
    assert "effective sample size" in refused(*local, "-n", "1000")


def always_raising(machine: Machine) -> float:
    raise ZeroDivisionError("no slope")


@pytest.mark.parametrize("method", ["mean-shift", "scaled-sigma"])
def test_where_no_die_can_be_measured_nothing_is_told(
    method: str, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ("--metric", f"{HERE}:always_raising", "--spec", "always_raising in 0:", "-n", "1500")
    assert main(("montecarlo", BLOCK, *asked, "--no-mismatch", "--rare", method)) == 2
    found = capsys.readouterr()
    assert found.out == ""
    assert found.err.count("\n") == 1
