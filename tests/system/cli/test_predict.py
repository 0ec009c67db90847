"""`noctule identify` and `noctule predict`: a die's file, filled tables with bands, and what is refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from circuits.extraction.coach.posterior import posterior_of
from circuits.extraction.coach.table import read_folder
from circuits.silicon.die import Die
from system.cli.command_line import main
from system.options.die.file import read_die_file, read_posterior
from tests.refusals import command_refusals


@pytest.fixture(scope="module")
def die(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A die that one run of the pair identified."""
    found = tmp_path_factory.mktemp("die") / "die.toml"
    line = ["identify", "--fit", "coach", "--only", "ndp_run1", "--process", "rolls-180", "-o", str(found)]
    assert main(line) == 0
    return found


def test_the_die_of_a_chip_is_one_that_commands_take(die: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = read_die_file(die)
    assert isinstance(found, Die)
    by_path = {e.paths[0]: e.value for e in found.edits}
    # 8 mV of offset, of which the area law gives both devices a half
    assert 0.5e-3 < by_path["differential_pair.m1"] - by_path["differential_pair.m2"] < 8e-3
    assert main(["op", "differential-pair", "--die", str(die), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["die"] is None


def test_a_die_of_several_blocks_is_one_for_each_of_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    both = tmp_path / "both.toml"
    rows = [("differential_pair.m1", "3mV"), ("follower_integrator.amplifier.m7", "-4mV")]
    both.write_text("".join(
        f'[[deviation]]\npath = "{path}"\nparameter = "v_t0"\nvalue = "{value}"\n' for path, value in rows
    ))  # fmt: skip
    for block in ("differential-pair", "follower-integrator"):
        assert main(["op", block, "--die", str(both), "--json"]) == 0
    both.write_text(both.read_text().replace("differential_pair.m1", "differential_pair.m9"))
    capsys.readouterr()
    assert main(["op", "differential-pair", "--die", str(both)]) == 2
    assert "differential_pair.m9, is the path of no device" in capsys.readouterr().err


def test_the_posterior_is_in_the_file_to_its_digits(die: Path) -> None:
    posterior, noise = posterior_of(read_posterior(die), str(die))
    assert ("ndp_run1", "n1_counts") in noise
    k = posterior.names.index("differential_pair.m1.v_t0")
    assert posterior.sd[k] < posterior.unknowns[k].sd
    j = posterior.names.index("differential_pair.m2.v_t0")
    assert posterior.correlation[k, j] > 0.5  # their difference is known, their mean is not


def test_a_prediction_fills_each_empty_column_and_adds_its_band(
    die: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "predicted"
    asked = ["predict", "coach", "--process", "rolls-180", "--die", str(die), "--draws", "12"]
    assert main([*asked, "--only", "ndp_run2", "--only", "wrt_vout_1", "-o", str(out), "--json"]) == 0
    assert [m["lost_draws"] for m in json.loads(capsys.readouterr().out)["measurements"]] == [0, 0]
    assert sorted(p.name for p in out.iterdir()) == ["metrics.json", "ndp_run2.csv", "wrt_vout_1.csv"]
    with (out / "ndp_run2.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    blank = read_folder(None, "predict")["ndp_run2"][1]
    assert len(rows) == len(blank["v1_V"])
    for name in ("n1_counts", "n2_counts", "i1_A", "i2_A"):
        inside = [float(r[f"{name}_low"]) <= float(r[f"{name}_high"]) for r in rows]
        assert all(inside)
        assert sum(float(r[f"{name}_low"]) <= float(r[name]) <= float(r[f"{name}_high"]) for r in rows) > 45
    metrics = json.loads((out / "metrics.json").read_text())
    kappa = metrics["ndp_run2"]["kappa"]
    assert kappa["low"] < kappa["value"] < kappa["high"]
    assert 0.70 < kappa["value"] < 0.80


def test_a_die_of_another_process_is_refused(
    die: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = ["predict", "coach", "--process", "coach-180", "--die", str(die), "-o", str(tmp_path / "x")]
    assert main([*line, "--only", "ndp_run2"]) == 2
    assert "identified on rolls-180 with n.v_t0 0.478 V, coach-180 has 0.504366 V" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()


def test_a_prediction_is_the_same_twice(die: Path, tmp_path: Path) -> None:
    asked = ["predict", "coach", "--process", "rolls-180", "--die", str(die), "--draws", "3"]
    texts = []
    for name in ("a", "b"):
        assert main([*asked, "--only", "wrt_vout_3", "-o", str(tmp_path / name)]) == 0
        texts.append((tmp_path / name / "wrt_vout_3.csv").read_text())
    assert texts[0] == texts[1]


test_what_is_wrong_is_told_in_a_line = command_refusals(
    "predict",
    rows=[
        ("coach --process rolls-180 --die none.toml -o x", "none.toml: no such file"),
        ("coach --process rolls-180 --die none.toml --draws 1 -o x", "--draws: 1, must be 2 or more"),
    ],
)


def test_a_die_that_nobody_identified_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plain = tmp_path / "die.toml"
    plain.write_text("die = 1003\n")
    line = ["predict", "coach", "--process", "rolls-180", "--die", str(plain), "-o", str(tmp_path / "x")]
    assert main(line) == 2
    assert "no posterior, must be a die of noctule identify" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()


def test_a_die_of_a_model_with_other_unknowns_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = Path("evidence/coach/first")  # before lines of codes had a splitter in common
    line = ["predict", "coach", "--process", str(kept / "process.toml"), "--die", str(kept / "die.toml")]
    assert main([*line, "--only", "ndp_run2", "-o", str(tmp_path / "out")]) == 2
    assert "unknowns are missing" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
