"""Compiled functions: what is kept on disk goes stale with any file whose code it holds."""

from pathlib import Path
from typing import Any

import pytest

from circuits import compiled as module
from circuits.compiled import compiled, source_stamp
from circuits.devices.transistor import drain_currents
from circuits.solver.integrate import integrate
from circuits.solver.operating_point import rest_state


@pytest.mark.parametrize("function", [drain_currents, integrate, rest_state])
def test_the_cache_of_every_function_carries_the_common_stamp(function: Any) -> None:
    assert function._cache._cache_file._source_stamp == source_stamp()


def _stamp(*files: str) -> bytes:
    """The stamp, read again."""
    module._own_stamp.cache_clear()
    source_stamp.cache_clear()
    return source_stamp(files)


def test_the_stamp_of_a_caller_elsewhere_follows_its_own_file_and_its_callees(tmp_path: Path) -> None:
    caller, callee = tmp_path / "caller.py", tmp_path / "callee.py"
    caller.write_text("a", encoding="utf-8")
    callee.write_text("b", encoding="utf-8")
    files = (str(caller), str(callee))
    stamps = [_stamp(), _stamp(*files)]
    for path in (caller, callee):
        path.write_text("changed", encoding="utf-8")
        stamps.append(_stamp(*files))
    assert len(set(stamps)) == 4


def test_the_stamp_follows_the_contents_of_every_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "devices").mkdir()
    (tmp_path / "solver").mkdir()
    device, solver = tmp_path / "devices" / "transistor.py", tmp_path / "solver" / "integrate.py"
    device.write_text("a", encoding="utf-8")
    solver.write_text("b", encoding="utf-8")
    monkeypatch.setattr(module, "_HERE", tmp_path)
    stamps = [_stamp()]
    for path in (device, solver):
        path.write_text("changed", encoding="utf-8")
        stamps.append(_stamp())
    assert len(set(stamps)) == 3
    device.touch()
    assert _stamp() == stamps[-1]


def test_a_compiled_function_computes() -> None:
    @compiled()
    def twice(x: float) -> float:
        return 2.0 * x

    assert twice(1.5) == 3.0


def test_every_compiled_function_stands_in_a_file_of_the_stamp() -> None:
    stamped = {path for pattern in module._SOURCES for path in module._HERE.glob(pattern)}
    compiled_files = {p for p in module._HERE.rglob("*.py") if "@compiled(" in p.read_text(encoding="utf-8")}
    assert len(compiled_files) > 5
    assert compiled_files <= stamped
