"""Summary of a run that `noctule run` prints, for every system alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from system.cli.output import print_line, print_table
from system.system import ENTRIES, METRICS, System, headline, told


def print_run(title: str, system: System[Any, Any], summary: Mapping[str, Any]) -> None:
    """Print how and why a run ended, the silicon that it was on, and its numbers."""
    if "reason" in summary:
        print_line(headline(succeeded=summary["succeeded"], reason=summary["reason"]))
        print_line(f"success: {system.success}")
        print_line("ran on: " + ", ".join(_said(*item) for item in summary["ran_on"].items()))
        for name, told in summary["parts"].items():
            print_line(f"{name}: {told}")
    words = set(ENTRIES) - (set(METRICS) - {"succeeded"})
    rows = [(name, _number(value)) for name, value in summary.items() if name not in words]
    print_table(title, ("quantity", "value:"), rows)


def print_cautions(summary: Mapping[str, Any]) -> None:
    """Print what to be careful of, where its chips are outside of what they were made or measured for."""
    for caution in summary.get("cautions", ()):
        print_line(f"caution: {caution}")


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}"


def _said(name: str, value: object) -> str:
    """As `bias kind gate`, `corner random`, `mismatch yes`."""
    shown = name.replace("_", " ")
    if name == "die" and value is None:
        return "die nominal"
    return f"{shown} {told(value)}"
