"""What the analyses about a rest state share: dies by text, runs that fail, cells of a CSV."""

import pytest

from circuits.errors import ParameterError, SolverError
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.small_signal import Response, ac
from system.cli.simulate_verb import Simulate
from system.cli.small_signal_runs import (
    cell_of,
    frequencies_of,
    head_of,
    label_of,
    place_of,
    read_dies,
    runs_of,
)
from system.options.block import Choice


def asked(dies: str | None = None) -> Simulate:
    return Simulate(block="onset-neuron", analysis="ac", dies=dies)


@pytest.mark.parametrize("text", ["", "5", "5-", "-5", "7-5", "a-b", "1-2-3", "0-100000"])
def test_wrong_dies_are_refused(text: str) -> None:
    with pytest.raises(ParameterError, match="must be FIRST-LAST"):
        read_dies(text)


def test_dies_have_both_ends() -> None:
    assert read_dies("3-5") == [3, 4, 5]
    assert read_dies("7-7") == [7]


def test_a_die_that_fails_is_a_run_with_its_reason() -> None:
    verb = asked("1000-1001")

    def solve(point: OperatingPoint, choice: Choice) -> Response:
        if choice.silicon.die.number == 1000:
            raise SolverError("no answer; try another")
        return ac(point, "envelope", frequencies_of(verb)[:2], ("v_amp",))

    failed, fine = runs_of(verb, solve)
    assert (failed.answer, failed.die, fine.die) == (None, 1000, 1001)
    assert place_of(failed)["reason"] == "no answer; try another"
    assert place_of(fine)["reason"] is None
    assert head_of(verb, [failed, fine])["failed"] == 1
    assert label_of(fine) == "27 °C, die A/1001"


def test_where_all_fail_the_reason_is_raised() -> None:
    def solve(point: OperatingPoint, choice: Choice) -> Response:
        raise SolverError("no answer; try another")

    with pytest.raises(SolverError, match="no answer"):
        runs_of(asked(), solve)


def test_names_with_commas_are_quoted() -> None:
    assert [cell_of(t) for t in ("v_mem", "v[1,2]")] == ["v_mem", '"v[1,2]"']
