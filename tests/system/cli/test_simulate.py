"""`noctule simulate`: the files that it writes."""

from pathlib import Path

import pytest
from spicelib import RawRead

from system.cli.command_line import main


def test_simulate_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run.raw"
    assert main(["simulate", "rebound-neuron", "--law", "ideal", "--raw", str(path), "--json"]) == 0
    found = RawRead(path, verbose=False)
    assert found.get_trace("time").get_wave()[-1] == pytest.approx(16e-3)
    v_r = found.get_trace("v(xrebound_neuron.xmembrane.v_r)").get_wave()
    assert v_r[0] == pytest.approx(3.1, abs=0.01)
    assert main(["simulate", "rebound-neuron", "--raw", str(tmp_path / "none" / "run.raw")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
