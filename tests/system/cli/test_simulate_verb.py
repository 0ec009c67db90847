"""Which analysis takes which option."""

from dataclasses import replace

import pytest

from circuits.errors import ParameterError
from system.cli.simulate_verb import ANALYSES, TAKEN_BY, Simulate, check_options
from system.options.begin import BeginChoice

GIVEN = {
    "at_rest": Simulate(block="x", begin=BeginChoice(begin="at_rest")),
    "uic": Simulate(block="x", begin=BeginChoice(begin="uic")),
    "ic": Simulate(block="x", begin=BeginChoice(("v=1V",))),
    "engine": Simulate(block="x", engine="ngspice"),
    "node": Simulate(block="x", node=("v",)),
    "flicker": Simulate(block="x", flicker=False),
    "low": Simulate(block="x", low="1Hz"),
}
SPOKEN = {"low": "from", "high": "to", "at_rest": "at-rest", "verilog_a": "verilog-a"}


@pytest.mark.parametrize("name", TAKEN_BY)
def test_an_option_is_refused_by_name_by_the_analyses_that_do_not_take_it(name: str) -> None:
    given = GIVEN[name] if name in GIVEN else Simulate(block="x", **{name: 0})  # type: ignore[arg-type]
    takers = []
    for analysis in ANALYSES:
        try:
            check_options(replace(given, analysis=analysis))
            takers.append(analysis)
        except ParameterError as error:
            told = f"--{SPOKEN.get(name, name)}: not of --analysis {analysis}; leave it out"
            assert str(error) == told  # noqa: PT017 - one of four may raise
    assert tuple(takers) == TAKEN_BY[name]
    assert 0 < len(takers) < len(ANALYSES)


@pytest.mark.parametrize("analysis", ANALYSES)
def test_what_is_not_given_is_not_refused(analysis: str) -> None:
    asked = Simulate(block="x", analysis=analysis)  # type: ignore[arg-type]
    check_options(asked)
    with pytest.raises(ParameterError, match=r"--(raw|netcdf): not of"):
        check_options(replace(asked, raw="x", netcdf="x"))
