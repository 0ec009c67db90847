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


def test_currents_stand_beside_voltages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run.csv"
    words = ["simulate", "rebound-neuron", "--stimulus", "duration=1ms", "--current", "membrane.mr1"]
    assert main([*words, "--csv", str(path)]) == 0
    head, first, *_ = path.read_text().splitlines()
    assert head.split(",")[-1] == "membrane.mr1_A"
    assert float(first.split(",")[-1]) == pytest.approx(-500e-12, rel=0.1)
    capsys.readouterr()
    assert main(words) == 2
    assert main([*words, "--current", "membrane.mr9", "--csv", str(tmp_path / "b.csv")]) == 2
    assert "did you mean membrane.mr" in capsys.readouterr().err
    assert not (tmp_path / "b.csv").exists()
