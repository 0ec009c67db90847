"""Measures of a run as members of a JSON document."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from circuits.measure.measure import Reading
from system.cli.output import plain


def measured_document(reading: Reading) -> dict[str, Any]:
    """Give a measure of a run as members of a JSON document."""
    return {**asdict(reading), "value": plain(reading.value), "reason": reading.reason or None}
