"""`--deadline`: a run in ngspice ends."""

from __future__ import annotations

import pytest

from circuits.errors import ParameterError
from netlists.ngspice.deadline import DEADLINE
from system.cli.command_line import main
from system.cli.deadline import deadline_of
from system.cli.simulate_verb import Simulate
from system.cli.verb import parameters_of
from tests.refusals import refusals

SLOW = ("simulate", "rebound-neuron", "--engine", "ngspice", "--deadline", "1ms")


def test_a_text_becomes_seconds() -> None:
    assert deadline_of("90s", "ngspice") == 90.0
    assert deadline_of(None, "ngspice") == deadline_of(None, "native") == DEADLINE
    (shown,) = (p.annotation for p in parameters_of(Simulate) if p.name == "deadline")
    assert f"{DEADLINE:g}s unless given" in shown.__metadata__[0].help


test_what_is_no_deadline = refusals(
    ParameterError,
    lambda given: deadline_of(*given),
    [
        (("60s", "native"), "--deadline: 60s, only --engine ngspice takes it; leave it out"),
        (("0s", "ngspice"), "--deadline: 0 s, must be > 0"),
        (("60V", "ngspice"), "--deadline: "),
        (("60", "ngspice"), "--deadline: "),
    ],
    start="^",
)


@pytest.mark.usefixtures("ngspice_library")
@pytest.mark.parametrize("analysis", [(), ("--analysis", "ac", "--source", "vdd", "--points", "5000")])
def test_a_run_in_ngspice_ends_at_its_deadline(
    analysis: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*SLOW[:-1], "1us", *analysis]) == 2
    error = capsys.readouterr().err
    assert "ngspice: not done after 1e-06 s of wall clock, the deadline; give more by --deadline" in error
    assert error.count("\n") == 1
