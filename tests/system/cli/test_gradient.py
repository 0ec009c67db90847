"""What `noctule gradient` says of a metric that has no gradient."""

from collections.abc import Callable
from pathlib import Path

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


def test_a_card_of_another_analysis_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deck = tmp_path / "rc.cir"
    deck.write_text(
        "* rc\nv1 in 0 ac 1 pulse(0 1 1m 1u 1u 5m 20m)\nr1 in out 10k\nc1 out 0 100n\n.tran 10u 10m\n"
        ".ac dec 10 1 1Meg\n.measure tran t_rise when v(out)=0.5 rise=1\n"
        ".measure ac f_c when vdb(out)=-3\n.end\n"
    )
    assert main(["gradient", str(deck), "--metric", "t_rise"]) == 0
    assert "top.r1.resistance" in capsys.readouterr().out
    assert main(["gradient", str(deck), "--metric", "f_c", "--json"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == (
        "noctule: --metric: f_c, is of .measure ac, must be of the transient or the operating point, which"
        " have gradients; simulate --analysis ac measures it on a die\n"
    )


def test_slopes_of_nothing_have_no_sign(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["gradient", "differential-pair", "--metric", "voltage(v1)"]) == 0
    assert "-0 V/V" not in capsys.readouterr().out
