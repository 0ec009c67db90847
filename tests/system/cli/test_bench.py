"""`noctule run bench`: a table, a CSV and a picture of a script, and one line where it cannot be run."""

import json
from pathlib import Path

from tests.documents import ROOT
from tests.system.conftest import Run

SCRIPT = str(ROOT / "examples" / "pair.toml")


def test_a_script_is_printed_written_and_drawn(run: Run, tmp_path: Path) -> None:
    table, picture = tmp_path / "pair.csv", tmp_path / "pair.png"
    options = ("run", "bench", SCRIPT, "--die", "1000", "--csv", str(table), "--plot", str(picture))
    status, out, err = run(*options)
    assert (status, err) == (0, "")
    assert out.startswith("coach NDP at 27 degC, die A/1000")
    assert "and 37 rows more" in out
    lines = table.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "AIN5_V,AIN6_V,C2F0_counts,C2F1_counts"
    assert len(lines) == 62
    assert picture.stat().st_size > 5_000
    found = json.loads(run("run", "bench", SCRIPT, "--die", "1000", "--json")[1])
    assert [f"{v:.9g}" for v in found["columns"]["C2F1_counts"]][:3] == [
        line.split(",")[3] for line in lines[1:4]
    ]
    assert found["set"] == ["AIN5_V", "AIN6_V"]


def test_help_and_a_slip(run: Run, tmp_path: Path) -> None:
    assert "bench" in run("run", "--help")[1]
    assert "SCRIPT.toml" in run("run", "bench", "--help")[1]
    bad = tmp_path / "bad.toml"
    bad.write_text(Path(SCRIPT).read_text(encoding="utf-8").replace("1.05V", "2V", 1), encoding="utf-8")
    table = tmp_path / "none.csv"
    status, out, err = run("run", "bench", str(bad), "--csv", str(table))
    assert status != 0
    assert out == ""
    assert err.count("\n") == 1
    assert "sweep.over.AIN5: 2 V, must be within 0 V and the supply of 1.8 V; sweep less far" in err
    assert not table.exists()
