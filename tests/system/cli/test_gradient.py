"""What `noctule gradient` says of a metric that has no gradient."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from system.cli import gradient
from system.cli.command_line import main


def test_what_the_spread_leaves_out_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["gradient", "latency-neuron", "--metric", "latency_s"]
    for more, told in ((["--variation", "full"], True), ([], False)):
        assert main([*asked, *more]) == 0
        assert ("n with p the spread over dies has nothing" in capsys.readouterr().out) is told


def test_a_metric_without_a_gradient_has_no_table_of_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["gradient", "differential-pair", "--metric", "offset_V"]) == 0
    said = capsys.readouterr().out
    assert "no gradient: reads devices beside the run's voltages" in said
    assert "nan" not in said


@pytest.mark.parametrize("words", [["class"], ["t_inh_s", "class"]])
def test_corner_of_a_metric_that_is_a_word_is_refused(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    metrics = [text for word in words for text in ("--metric", word)]
    assert main(["corners", "rebound-neuron", *metrics, "-o", str(tmp_path / "corners")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("noctule: --metric: class, is a word, must be a number; name one of t")
    assert error.count("\n") == 1


def test_picture_of_a_metric_without_a_gradient_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    figures: list[Figure] = []

    def drawn(path: str | None, draw: Callable[[Figure], None]) -> None:
        figures.append(Figure())
        draw(figures[-1])

    monkeypatch.setattr(gradient, "save_picture", drawn)
    metrics = ("offset_V", "voltage(v_s)", "voltage(v1)", "rise(v_s,5V,0)")
    asked = [text for name in metrics for text in ("--metric", name)]
    assert main(["gradient", "differential-pair", *asked, "--plot", "g.png"]) == 0
    none, moved, fixed, missing = figures[0].axes
    assert "offset_V\nreads devices beside the run's voltages" in none.texts[0].get_text()
    assert not none.axison
    assert len(moved.patches) > 3
    assert moved.get_title() == ""
    assert fixed.get_title() == "no deviation of a die moves it"
    assert missing.texts[0].get_text().startswith("rise(v_s,5V,0)\n0 crossings")


def test_spikes_that_are_not_watched_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for block, node, known in (("differential-pair", "v_s", "none is"), ("rebound-neuron", "v_mem", "spike")):
        assert main(["gradient", block, "--metric", f"spike_time({node},0)"]) == 2
        told = f"noctule: spike_time({node},0): {node}, must be a port whose spikes are watched: {known};"
        assert capsys.readouterr().err == f"{told} rise({node},V,0) is of any node\n"


RC = (
    "* rc\nv1 in 0 ac {} pulse(0 1 1m 1u 1u 5m 20m)\nr1 in out 10k\nc1 out 0 100n\n.tran 10u 10m\n"
    ".ac dec 10 1 1Meg\n.dc v1 0 1 0.1\n.measure tran t_rise when v(out)=0.5 rise=1\n"
    ".measure ac f_c when vdb(out)=-3\n.measure ac late find vp(out) at=1k\n.measure ac peak max_at vm(out)\n"
    ".measure ac i_r find 'mag(i(r1))' at=1k\n.measure ac i_v find 'db(i(v1))' at=1k\n"
    ".measure dc half when v(out)=0.5\n.end\n"
)


def test_a_card_of_another_analysis_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deck = tmp_path / "rc.cir"
    deck.write_text(RC.format("1"))
    assert main(["gradient", str(deck), "--metric", "t_rise"]) == 0
    assert "top.r1.resistance" in capsys.readouterr().out
    assert main(["gradient", str(deck), "--metric", "half", "--json"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == (
        "noctule: --metric: half, is of .measure dc, must be of the transient, the operating point or small"
        " signals, which have gradients; simulate --analysis dc measures it on a die\n"
    )


def gradients_in(text: str) -> list[tuple[dict[str, Any], dict[str, float]]]:
    """Each metric of a JSON document, and its gradients by parameter."""
    metrics = json.loads(text)["metrics"]
    return [(m, {g["parameter"]: g["gradient"] for g in m["gradients"]}) for m in metrics]


def test_cards_of_small_signals_have_gradients(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deck = tmp_path / "rc.cir"
    deck.write_text(RC.format("1"))
    asked = ["f_c", "t_rise", "late", "peak", "bandwidth(out,v1)", "i_r", "i_v"]
    words = [text for name in asked for text in ("--metric", name)]
    assert main(["gradient", str(deck), *words, "--json"]) == 0
    found = gradients_in(capsys.readouterr().out)
    assert [metric["metric"] for metric, _ in found] == asked
    assert [metric["unit"] for metric, _ in found] == ["Hz", "s", "deg", "Hz", "Hz", "S", "dB"]
    ratio = 2.0 * math.pi * 1e3 * 1e4 * 100e-9
    wanted = {2: -math.degrees(ratio / (1.0 + ratio**2)), 4: -found[4][0]["value"]}
    for k, by_log in wanted.items():
        assert found[k][1]["top.r1.resistance"] * 1e4 == pytest.approx(by_log, rel=1e-3)
        assert found[k][1]["top.c1.capacitance"] * 1e-7 == pytest.approx(by_log, rel=1e-3)
    current = ratio * 1e-4 / math.hypot(1.0, ratio)
    assert found[5][0]["value"] == pytest.approx(current, rel=1e-6)
    share = 1.0 / (1.0 + ratio**2)
    for k, one in ((5, current), (6, 20.0 / math.log(10.0))):
        assert found[k][1]["top.c1.capacitance"] * 1e-7 == pytest.approx(one * share, rel=1e-3)
        assert found[k][1]["top.r1.resistance"] * 1e4 == pytest.approx(one * (share - 1.0), rel=1e-3)
    # between points of a grid, which stays as it is
    assert found[0][1]["top.r1.resistance"] * 1e4 == pytest.approx(-found[0][0]["value"], rel=0.02)
    assert found[3][0]["note"] == "reads no transfer, as where it is an end of the grid"
    assert found[3][1] == {}


def test_cards_are_of_the_ac_values_of_a_deck(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deck, slopes = tmp_path / "rc.cir", []
    for value, unit in (("1", "deg"), ("2 90", "deg")):
        deck.write_text(RC.format(value))
        assert main(["gradient", str(deck), "--metric", "late", "--json"]) == 0
        ((metric, by),) = gradients_in(capsys.readouterr().out)
        assert metric["unit"] == unit
        slopes.append((metric["value"], by["top.r1.resistance"]))
    assert slopes[1][0] == pytest.approx(slopes[0][0] + 90.0)
    assert slopes[1][1] == pytest.approx(slopes[0][1], rel=1e-6)


def test_cards_without_an_answer_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deck = tmp_path / "rc.cir"
    deck.write_text(RC.format("1").replace(" ac 1 ", " "))
    assert main(["gradient", str(deck), "--metric", "f_c"]) == 2
    error = capsys.readouterr().err
    assert error == (
        f"noctule: f_c = cross(db(v(out)), -3.0): no source of {deck} has an AC value; write as"
        " v1 in 0 ac 1\n"
    )
    deck.write_text(RC.format("1").replace("find vp(out)", "find v(nowhere)"))
    assert main(["gradient", str(deck), "--metric", "late"]) == 2
    *told, error = capsys.readouterr().err.splitlines()
    assert len(told) == 1
    assert "nowhere" in told[0]
    assert error == "noctule: --metric: late, is a .measure card that is left out; name another"


def test_small_signals_that_cannot_be_are_told_in_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    wrong = {
        "mag(v_out,v_plus,0Hz)": "--metric: 0Hz, must be a frequency above 0; as 1kHz",
        "mag(v_out,v_plus,1kV)": '--metric: "1kV", must be a frequency in Hz',
        "bandwidth(v_out,v_plus,1kHz,1Hz)": "--metric: 1kHz to 1Hz, must be rising frequencies",
        "db(v_out,v_pluss,1kHz)": "transamp source v_pluss: unknown; did you mean v_plus? known are",
        "phase(v_ot,v_plus,1kHz)": "wide_range_transamp node v_ot: unknown; did you mean v_out? known are",
    }
    for name, text in wrong.items():
        assert main(["gradient", "wide-range-transamp", "--metric", name]) == 2
        error = capsys.readouterr().err
        assert text in error
        assert error.count("\n") == 1


def test_slopes_of_nothing_have_no_sign(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["gradient", "differential-pair", "--metric", "voltage(v1)"]) == 0
    assert "-0 V/V" not in capsys.readouterr().out
