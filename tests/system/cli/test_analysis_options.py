"""Which analysis takes which option."""

from dataclasses import fields

import pytest

from circuits.errors import ParameterError
from system.cli.analysis_options import Analysis, AnalysisChoice, check_options


@pytest.mark.parametrize("analysis", [a.value for a in Analysis])
def test_an_analysis_is_refused_for_an_option_and_not_without_one(analysis: str) -> None:
    refused = []
    for raw in (None, "file.raw"):
        try:
            check_options(AnalysisChoice(analysis), {"raw": raw})
        except ParameterError as error:
            refused.append(str(error))
    assert refused == [f"--raw: not of --analysis {analysis}; leave it out"]


def test_every_option_belongs_to_an_analysis_and_none_to_the_transient() -> None:
    for each in fields(AnalysisChoice):
        if each.name == "analysis":
            continue
        value = ("x",) if each.name == "nodes" else False if each.name == "flicker" else 0
        taken = []
        for analysis in Analysis:
            try:
                check_options(AnalysisChoice(analysis.value, **{each.name: value}), {})  # type: ignore[arg-type]
                taken.append(analysis)
            except ParameterError as error:
                assert f"not of --analysis {analysis.value}" in str(error)  # noqa: PT017 - one of four may raise
        assert taken
        assert Analysis.tran not in taken


def test_options_of_other_groups_are_refused_by_name() -> None:
    with pytest.raises(ParameterError, match="--raw: not of --analysis ac"):
        check_options(AnalysisChoice("ac"), {"raw": "file.raw"})
