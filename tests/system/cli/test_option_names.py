"""What is said of fields below the command line is said of options at it."""

from __future__ import annotations

import pytest

from system.cli.option_names import as_options

OPTIONS = {
    "ping_rate": "--ping-rate",
    "cells": "--cells",
    "modified": "--modified",
    "calibrated_c": "--calibrated",
}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("ping_rate: 3 Hz, must be > 5", "--ping-rate: 3 Hz, must be > 5"),
        ("calibrated_c: 300 degC", "--calibrated: 300 degC"),
        (
            "ping_rate: no; add `cells=chip`, or leave it out",
            "--ping-rate: no; add --cells chip, or leave it out",
        ),
        ("x: with `modified`, must be without", "x: with --modified, must be without"),
        ("head.ping_rate: 3", "head.ping_rate: 3"),
        ("a cells: 3 `pip install x` `other`", "a cells: 3 `pip install x` `other`"),
        ("cells", "cells"),
    ],
)
def test_names_of_fields_become_options(text: str, said: str) -> None:
    assert as_options(text, OPTIONS) == said
