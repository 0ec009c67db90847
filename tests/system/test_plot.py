"""Pictures are written whole, in the format that was asked for, and show what they should."""

from itertools import combinations
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from matplotlib.figure import Figure

from chips.ranging.circuit import CHIP
from circuits.arrays import F64
from circuits.blocks.sonar.rebound_neuron import BLOCK
from circuits.errors import DataError, ParameterError
from circuits.registry import block_names, load_block
from circuits.silicon.die import NOMINAL, Die
from system.plot import (
    PALE,
    check_picture,
    die_label,
    draw_circuit,
    draw_waveform,
    draw_waveforms,
    entitle,
    looks,
    mark_spikes,
    save_picture,
    settle,
    silicon_text,
)
from tests.pictures import figure_of_files, leaving, legend_of

BEGINNINGS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


def draw_line(figure: Figure) -> None:
    draw_waveform(np.array([0.0, 1e-3]), np.array([0.0, 5.0]), "v_mem", figure.subplots())


@pytest.mark.parametrize("suffix", BEGINNINGS)
def test_formats(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"picture.{suffix}"
    save_picture(str(path), draw_line)
    first = path.read_bytes()
    assert first.startswith(BEGINNINGS[suffix])
    save_picture(str(path), draw_line)
    assert path.read_bytes() == first, "equal pictures are equal files"


@pytest.mark.parametrize("name", ["picture.gif", "picture", "png"])
def test_an_unknown_suffix_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"must end with \.png"):
        check_picture(str(tmp_path / name))


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="there is no folder"):
        check_picture(str(tmp_path / "nowhere" / "picture.png"))


def test_time_is_in_ms_and_spikes_are_marked() -> None:
    ax = Figure().subplots()
    draw_waveform(np.array([0.0, 2e-3]), np.array([0.0, 5.0]), "spike", ax)
    mark_spikes(np.array([1e-3, 1.5e-3]), 5.0, ax)
    trace, marks = ax.get_lines()
    assert np.asarray(trace.get_xdata()).tolist() == [0.0, 2.0]
    assert np.asarray(marks.get_xdata()).tolist() == [1.0, 1.5]
    assert ax.get_ylabel() == "spike (V)"
    assert [text.get_text() for text in ax.texts] == ["2 spikes"]


def test_a_long_title_is_broken_and_stays_in_the_figure() -> None:
    figure = figure_of_files()
    ax = figure.subplots()
    entitle("failed: " + "a word and another, " * 12 + "\nand a second line", ax)
    assert ax.get_title().count("\n") >= 3
    assert leaving(figure) == []
    ax.set_title("failed: " + "a word and another, " * 12)
    assert leaving(figure) == [ax.get_title()]


def test_lines_are_told_apart_in_grey_too() -> None:
    few = looks(4)
    assert len({look["color"] for look in few}) == len({look["linestyle"] for look in few}) == 4
    assert {look["color"] for look in looks(20)} == {PALE}


def test_silicon_in_words() -> None:
    assert silicon_text(Die(number=1003), 60.0, "gate") == "die A/1003, 60 °C, biases of kind gate"
    assert silicon_text(NOMINAL, -2.5) == "die nominal, -2.5 °C"


def labels(figure: Figure) -> set[str]:
    return {text.get_text() for text in figure.axes[0].texts}


def test_a_block_shows_devices_and_a_chip_instances() -> None:
    block, chip = Figure(layout="constrained"), Figure(layout="constrained")
    draw_circuit(BLOCK.build(), block)
    draw_circuit(CHIP.build(), chip)
    assert {"mi5", "c_m", "v_mem", "spike"} <= labels(block)
    assert {"axon", "membrane", "port", "inner node: its name alone", "gate or bulk only"} <= legend_of(block)
    assert "vdd" not in labels(block), "rails are left out"
    assert {"neuron ×13", "spike ×13", "call"} <= labels(chip)


@pytest.mark.parametrize("name", block_names())
def test_no_labels_of_a_graph_touch(name: str) -> None:
    block, figure = load_block(name), figure_of_files()
    draw_circuit(block.build(block.params()), figure)
    assert leaving(figure) == []
    texts = figure.axes[0].texts
    boxes = [(t.get_text(), t.get_bbox_patch() or t) for t in texts]
    boxes = [(text, drawn.get_window_extent()) for text, drawn in boxes]
    assert [(a, b) for (a, one), (b, other) in combinations(boxes, 2) if one.overlaps(other)] == []


class Waves(dict[str, F64]):
    """Waveforms of nodes as those of a run."""

    time = np.linspace(0.0, 1e-3, 5)
    spikes: ClassVar[dict[str, F64]] = {}


def test_long_names_of_nodes_have_room() -> None:
    nodes = ("cell2.v_mem", "recurrent.timer", "v_inh_tau[12]", "x")
    waves, figure = Waves((node, np.linspace(1.0, 1.5, 5)) for node in nodes), figure_of_files()
    draw_waveforms(waves, nodes, figure, "race-layer, die nominal, 27 °C: stops")  # type: ignore[arg-type]
    settle(figure)
    boxes = [ax.yaxis.label.get_window_extent() for ax in figure.axes]
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert [ax.get_ylabel() for ax in figure.axes][1::2] == ["recurrent.timer\n(V)", "x (V)"]
    assert figure.axes[0].get_title() == "race-layer, die nominal, 27 °C: stops"
    assert leaving(figure) == []


def test_labels_stay_in_the_figure_whatever_their_ticks() -> None:
    ends = {"proximity": (1.5, 1.5), "ramp": (0.0, 2.6), "call": (0.0, 5.0), "amplitude": (2.7, 2.7)}
    waves = Waves((node, np.linspace(*each, 5)) for node, each in ends.items())
    figure = figure_of_files()
    draw_waveforms(waves, tuple(waves), figure, "calling")  # type: ignore[arg-type]
    for _ in range(4):
        assert leaving(figure) == []


def test_labels_of_a_short_logarithmic_axis_stand_apart(tmp_path: Path) -> None:
    drawn = []

    def draw(figure: Figure) -> None:
        left, right = figure.subplots(1, 2)
        left.loglog([1.8, 3.0], [0.06, 0.11])
        right.loglog([0.7, 7.0], [1e-9, 1e-3])
        drawn.extend([left, right])

    save_picture(str(tmp_path / "log.png"), draw)
    for axis in (each for ax in drawn for each in (ax.xaxis, ax.yaxis)):
        shown = [t.get_window_extent() for t in axis.get_ticklabels(which="both") if t.get_text()]
        inside = [box for box in shown if box.width]
        assert len(inside) >= 2
        assert not any(one.overlaps(other) for one, other in combinations(inside, 2))


def test_a_die_s_label_counts_edits_that_a_legend_has_no_room_for() -> None:
    die = Die(number=1001)
    assert die_label(die.healed("chip.neuron[2]")) == "die A/1001, healed chip.neuron[2]"
    many = die.healed(*(f"ranging_chip.neuron[{k}].membrane" for k in range(4)))
    assert die_label(many) == "die A/1001, edited in 4 places"
