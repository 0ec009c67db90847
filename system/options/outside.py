"""What a run does where a chip's model leaves its validity box (`chips.validity`), as the command line asks.

A scenario has the field `outside`, and its trace one of that name with what was left, a sentence each; the
account of the run has these among its cautions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import Any, TypeVar, cast

from chips.validity import outside_boxes
from system.option import option

Run = TypeVar("Run", bound=Callable[..., Any])


def outside_option() -> Any:
    """The field of a scenario for what it does where a chip's model was not measured."""
    about = "Where a chip's model was not measured: refuse, or warn and go on"
    return option("refuse", about, study=True, silicon=True, key="")


def inside_boxes(run: Run) -> Run:
    """Decorator of a run: it stays within boxes, or its trace says what it left, as its scenario asks."""

    @wraps(run)
    def held(scenario: Any, *rest: Any, **named: Any) -> Any:
        with outside_boxes(scenario.outside) as left:
            trace = run(scenario, *rest, **named)
        return replace(trace, outside=left.texts()) if left.found else trace

    return cast("Run", held)
