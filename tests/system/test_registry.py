"""Lines of the tables: what a list says without loading anything is what the things say of themselves."""

from __future__ import annotations

import pytest

from chips.registry import CHIP_LINES, CHIPS, load_chip
from circuits.blocks.summary import SUMMARIES
from circuits.errors import UnknownNameError
from circuits.registry import BLOCKS, METRIC_CIRCUITS, METRIC_LINES, METRICS, load_block, load_metric
from netlists.registry import DIALECT_LINES, DIALECTS, load_dialect
from system.registry import (
    EXPERIMENT_LINES,
    EXPERIMENTS,
    SYSTEM_LINES,
    SYSTEMS,
    load_block_or_chip,
    load_experiment,
    load_system,
)

TABLES = {
    "blocks": (BLOCKS, SUMMARIES, load_block),
    "metrics": (METRICS, METRIC_LINES, load_metric),
    "chips": (CHIPS, CHIP_LINES, load_chip),
    "dialects": (DIALECTS, DIALECT_LINES, load_dialect),
    "systems": (SYSTEMS, SYSTEM_LINES, load_system),
    "experiments": (EXPERIMENTS, EXPERIMENT_LINES, load_experiment),
}


@pytest.mark.parametrize("title", TABLES)
def test_the_line_of_each_is_its_own_summary(title: str) -> None:
    table, lines, load = TABLES[title]
    assert list(lines) == list(table)
    assert {name: load(name).summary for name in table} == lines  # type: ignore[attr-defined]


def test_the_circuits_of_each_metric_are_those_that_it_says() -> None:
    assert {name: load_metric(name).circuits for name in METRICS} == METRIC_CIRCUITS


def test_a_name_of_the_other_kind_is_told_with_what_takes_it() -> None:
    with pytest.raises(UnknownNameError, match="approach: is a system, must be a block or chip; noctule run"):
        load_block_or_chip("approach")
    with pytest.raises(UnknownNameError, match="dpi-synapse: is a block or chip, must be a system; noctule"):
        load_system("dpi-synapse")
    both = load_block_or_chip("rolls"), load_system("rolls")  # which both a chip and a system have
    assert [each.name for each in both] == ["rolls", "rolls"]
