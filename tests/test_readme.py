"""The README's circuit runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"


def test_the_circuit_of_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert len([line for line in code.splitlines() if line.strip()]) <= 15
    exec(compile(code, str(README), "exec"), {})  # noqa: S102 - our own README
    found = re.search(r"low at (\S+) V, rises again at (\S+) us", capsys.readouterr().out)
    assert found is not None
    # the falling input couples into the output through the overlap capacitances
    assert -0.05 < float(found[1]) < 1e-3
    # the input falls at 2.001 us; 100 fF through 0.1 mA switches within some ns
    assert 2.001 < float(found[2]) < 2.02
