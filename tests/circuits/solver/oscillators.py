"""Circuits that do not rest: those of `benchmarks/oscillators.py`."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from typing import Any

_BENCHMARKS = Path(__file__).resolve().parents[3] / "benchmarks"


def _module() -> dict[str, Any]:
    sys.path.insert(0, str(_BENCHMARKS))  # its scripts import their neighbours
    try:
        return runpy.run_path(str(_BENCHMARKS / "oscillators.py"))
    finally:
        sys.path.remove(str(_BENCHMARKS))


OSCILLATORS = _module()
