"""`--law` and `--process`: blocks take them, documents and titles tell them, models of chips refuse them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from chips.rolls import portrait
from chips.rolls.program.bias_file import write_biases
from system.cli import mend, show_rolls
from system.files import kept
from tests.refusals import command_refusals
from tests.system.cli.test_show_rolls import without_plastic_biases
from tests.system.conftest import Run, RunJson

EXAMPLE = Path(__file__).parents[3] / "examples" / "mine-180.toml"


def test_a_block_runs_under_both_laws_and_says_so(run_json: RunJson, run: Run) -> None:
    ideal, full = (run_json("simulate", "rebound-neuron", "--law", law) for law in ("ideal", "full"))
    assert (ideal["process"], ideal["law"]) == ("ami-1500", "ideal")
    assert (full["process"], full["law"]) == ("ami-1500", "full")
    assert full["measures"]["t_inh_s"] > 1.1 * ideal["measures"]["t_inh_s"]  # body effect at fixed gates
    _, title, _ = run("show", "dpi-synapse", "--law", "ideal")
    assert "27 degC, die nominal, rolls-180 under the ideal law" in title
    assert "law" not in run("show", "dpi-synapse")[1].splitlines()[1]


def test_a_process_of_one_s_own_is_the_file_s(run_json: RunJson) -> None:
    own = run_json("op", "nef-neuron", "--process", str(EXAMPLE), "--law", "full")
    assert own["process"] == "mine-180"
    shipped = run_json("op", "nef-neuron", "--process", "rolls-180", "--law", "full")
    assert own["voltages_V"] == shipped["voltages_V"]


def test_rolls_is_shown_under_the_full_law(
    run_json: RunJson, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for module in (portrait, show_rolls):
        monkeypatch.setattr(module, "MULTIPLES", np.array([3.0]))
    monkeypatch.setattr(kept, "answers_folder", lambda: tmp_path / "answers")  # it is of fewer points
    write_biases(tmp_path / "few.csv", without_plastic_biases())
    shown = run_json("show", "rolls", "--law", "full", "--bias-file", str(tmp_path / "few.csv"))
    assert shown["law"] == "full"
    # 122.6 pA under the ideal law (docs/evidence/rolls.md)
    assert shown["rheobase_A"] != pytest.approx([0.12256e-9] * 256, rel=0.01)
    assert np.min(shown["fi_rate_Hz"]) > 0.0


@pytest.mark.usefixtures("unmeasured_power")
def test_rolls_is_run_under_both_laws(run_json: RunJson) -> None:
    given = ("run", "rolls", "--codes", "default", "--duration", "0.12s", "--law")
    rates = [np.mean(run_json(*given, law)["rates_Hz"]) for law in ("ideal", "full")]
    assert rates[1] != pytest.approx(rates[0], rel=0.01)


def test_a_bug_on_the_nef_chip_runs_under_both_laws(run_json: RunJson) -> None:
    given = (
        "run",
        "bug",
        "--brain",
        "chip",
        "--neurons",
        "500",
        "--duration",
        "0.3s",
        "--die",
        "4001",
        "--codes",
        "default",
        "--law",
    )
    spikes = [run_json(*given, law)["chip"]["spikes"] for law in ("ideal", "full")]
    assert spikes[1] == pytest.approx(spikes[0], rel=0.2)
    assert spikes[1] != spikes[0]


def test_a_study_is_of_its_law(run_json: RunJson) -> None:
    means = []
    for law in ("ideal", "full"):
        found = run_json("montecarlo", "delay-tap", "-n", "2", "--metric", "delay_s", "--law", law)
        assert (found["law"], found["process"]) == (law, None)
        means.append(found["metrics"]["delay_s"]["mean"])
    assert means[1] == pytest.approx(means[0], rel=0.1)
    assert means[1] != means[0]


test_what_has_no_such_law_refuses_it = command_refusals(
    rows=[
        ("simulate rebound-neuron --process none.toml", "none.toml: No such file"),
        ("simulate rebound-neuron --process rolls", "did you mean rolls-180?"),
        ("simulate rebound-neuron --law real", "'real' is not one of 'ideal', 'full'"),
        ("show rolls --process ami-1500", "rolls_chip.supply: 5 V"),
        ("characterise rebound-neuron --process rolls-180 --update-package", "records of ami-1500 alone"),
        (
            "export ranging-chip --level behavioural --dialect verilog-a -o - --law full",
            "must be ekv without second-order effects",
        ),
    ]
)


def test_a_missing_record_is_told_with_the_options_that_measure_it(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = "a_b_full: no record; run noctule characterise a-b law=full"
    told = "a_b_full: no record; run noctule characterise a-b --law full"
    monkeypatch.setattr(mend, "checkout", lambda: Path("/sources"))
    assert mend.measured_again(asked) == f"{told} --update-package"
    assert mend.measured_again(f"{asked}, or delete it") == f"{told}, or delete it"
    assert mend.measured_again(f"{asked} process=FILE") == f"{told} --process FILE"
    assert mend.measured_again("no such thing") == "no such thing"
    calibrated = "codes of a-b: of another law; run noctule calibrate a-b"
    assert mend.measured_again(f"{calibrated} die=3") == f"{calibrated} --die 3 --update-package"
    monkeypatch.setattr(mend, "checkout", lambda: None)
    assert mend.measured_again(asked) == told
    assert mend.measured_again(calibrated) == f"{calibrated} --anew"
