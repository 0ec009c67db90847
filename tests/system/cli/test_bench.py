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


DIE = str(ROOT / "evidence" / "coach" / "die.toml")


def test_an_identified_die_brings_its_board(run: Run) -> None:
    line = ("run", "bench", SCRIPT, "--die", DIE, "--process", "coach-180")
    status, out, err = run(*line)
    assert (status, err) == (0, "")
    told = out.splitlines()[-3:]
    assert told[0] == f"board: as {DIE} was identified at 27.6 degC"
    assert "channel 0 Q, channel 0 t_d, channel 1 Q" in told[1]
    assert told[2].endswith("dac offset, s 3.8 nA, s 240 nA")
    found, nominal = (json.loads(run(*line, *more, "--json")[1]) for more in ((), ("--board", "nominal")))
    assert found["board"]["file"] == DIE
    assert {"channel 1 Q", "s 30 nA"} <= set(found["board"]["identified"])
    assert "dac offset" in found["board"]["nominal"]
    assert nominal["board"] is None
    # of the evidence's run: the second channel counts 5 % more than its nominal charge says
    assert 1.03 < found["columns"]["C2F1_counts"][0] / nominal["columns"]["C2F1_counts"][0] < 1.08
    assert run("run", "bench", SCRIPT)[1].splitlines()[-1] == "board: nominal"


def test_a_board_of_another_process_or_of_no_identified_die_is_refused(run: Run, tmp_path: Path) -> None:
    plain = tmp_path / "plain.toml"
    plain.write_text("die = 3\n", encoding="utf-8")
    refused = {
        (
            "--die",
            DIE,
        ): "identified on coach-180 with n.v_t0 0.504366 V, rolls-180 has 0.478 V; give",
        (
            "--die",
            DIE,
            "--process",
            "coach-180",
            "--law",
            "ideal",
        ): "coach-180 has 0 1/V; give the process",
        ("--board", "identified"): "--board: identified, a nominal die was not; give the --die of noctule",
        ("--board", "identified", "--die", str(plain)): "plain.toml was not; give the --die of noctule",
    }
    for options, text in refused.items():
        status, out, err = run("run", "bench", SCRIPT, *options)
        assert status == 2, options
        assert out == ""
        assert err.count("\n") == 1
        assert text in err
    assert run("run", "bench", SCRIPT, "--die", str(plain))[0] == 0
    assert run("run", "bench", SCRIPT, "--die", DIE, "--board", "nominal")[0] == 0
