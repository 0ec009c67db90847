"""A script of `benchmarks` for tests: its folder is on Python's path while it is imported, and no longer."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).resolve().parents[1] / "benchmarks"


@contextmanager
def benchmark(name: str) -> Iterator[Any]:
    """The script of a name, as a module; it and its neighbours are forgotten afterwards."""
    before = {*sys.modules}
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        yield import_module(name)
    for each in {path.stem for path in FOLDER.glob("*.py")} - before:
        sys.modules.pop(each, None)
