"""`noctule import` and `noctule compare`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from system.cli.command_line import main
from tests.written import written

DECK = """A divider
.include parts.inc
v1 in 0 5
x1 in out half
r3 out 0 1meg
.tran 1u 1m
.save all
"""
PARTS = ".subckt half a b\nr1 a b 1k\nr2 b 0 2k\n.ends\n"


@pytest.fixture
def deck(tmp_path: Path) -> Path:
    (tmp_path / "parts.inc").write_text(PARTS)
    return written(tmp_path / "deck.cir", DECK)


def test_import_says_what_was_read(deck: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(deck), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["title"] == "A divider"
    assert document["circuits"] == ["top", "half"]
    assert (document["devices"], document["node_count"]) == ({"resistor": 3}, 2)
    assert document["ports"] == [{"name": "in", "kind": "supply", "direction": "in", "shape": []}]
    assert document["sources"] == [
        {"name": "v1", "node": "in", "quantity": "voltage", "waveform": "constant", "value": 5.0}
    ]
    assert document["analyses"] == [
        {"analysis": "tran", "step": 1e-6, "stop": 1e-3, "start": 0.0, "max_step": None, "uic": False}
    ]
    assert document["notes"] == [{"what": ".save card", "place": "deck.cir:7", "count": 1}]
    assert document["dialect"] == "spice"


def test_import_prints_tables(deck: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(deck)]) == 0
    out = capsys.readouterr().out
    for text in (
        "A divider",
        "resistor",
        "supply",
        "constant",
        "5V",
        "stop=0.001",
        ".save card",
        "deck.cir:7",
    ):
        assert text in out


def test_what_a_deck_asks_for_and_is_not_written_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cards = ".tran 1u 1m\n.ac dec 5 1k 1meg\n.meas tran v_end find v(b) at=1m\n"
    path = written(tmp_path / "rc.cir", f"RC\nv1 a 0 1 ac 2\nr1 a b 1k\nc1 b 0 1n\n{cards}.end\n")
    out = tmp_path / "out.cir"
    left = [".ac", "AC values of v1", "1 of .measure"]
    assert main(["export", str(path), "-o", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["unwritten"] == left
    for verb in ("export", "import"):
        assert main([verb, str(path), "-o", str(out)]) == 0
        assert f"{out}: not written: {', '.join(left)}; {path} has them" in capsys.readouterr().out
    assert main(["export", str(out), "-o", str(tmp_path / "again.cir")]) == 0
    assert "not written" not in capsys.readouterr().out


def test_an_export_is_imported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "neuron.cir"
    assert main(["export", "rebound-neuron", "--die", "1003", "-o", str(path)]) == 0
    assert main(["import", str(path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["dialect"], document["models"], document["die"]) == ("ngspice", "ekv", "die A/1003")
    assert (document["circuit"], document["deviation_count"]) == ("rebound_neuron", 34)
    assert {bias["kind"] for bias in document["biases"]} == {"gate", "voltage"}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("t\nq1 a b c npn\n", "deck.cir:2: q1: model npn: unknown"),
        ("t\nx1 a none\n", "deck.cir:2: x1: sub-circuit none is not there"),
        ("t\n.include deck.cir\n", "deck.cir:2: deck.cir: a cycle of includes"),
        ("t\n.include ../x.inc\n", "deck.cir:2: ../x.inc lies outside the root folder"),
        ("t\nm1 d g s b n l=1u\n", "deck.cir:2: model n: unknown"),
        ("t\n1 d g s\n", "deck.cir:2: 1: unknown element"),
        ("", "deck.cir:1: empty"),
    ],
)
def test_a_bad_netlist_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, says: str
) -> None:
    path = tmp_path / "deck.cir"
    path.write_text(text)
    assert main(["import", str(path)]) == 2
    err = capsys.readouterr().err
    assert says in err
    assert err.count("\n") == 1


def test_the_root_may_be_wider(deck: Path, capsys: pytest.CaptureFixture[str]) -> None:
    inner = deck.parent / "inner"
    inner.mkdir()
    (inner / "deck.cir").write_text(DECK.replace("parts.inc", "../parts.inc"))
    assert main(["import", str(inner / "deck.cir")]) == 2
    assert main(["import", str(inner / "deck.cir"), "--root", str(deck.parent), "--json"]) == 0


def test_compare_says_equal_or_what_differs(deck: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = deck.parent / "other.cir"
    other.write_text("flat\nvin in 0 1\nrb mid 0 2k\nra mid in 1k\nrc 0 mid 1meg\n")
    assert main(["compare", str(deck), str(other)]) == 0
    assert capsys.readouterr().out == "equal: 3 devices, 2 nodes; stimuli and parasitics are not compared\n"
    other.write_text("flat\nvin in 0 1\nrb mid 0 3k\nra mid in 1k\nrc 0 mid 1meg\n")
    assert main(["compare", str(deck), str(other), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert document["equal"] is False
    assert document["differences"] == [
        {"kind": "size", "path": "x1.r2", "text": "resistance 2000.0 in the first, 3000.0 in the second (rb)"}
    ]
    assert main(["compare", str(deck), str(other)]) == 1
    assert "different: 3 and 3 devices, 2 and 2 nodes" in capsys.readouterr().out


def test_compare_of_dies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = {}
    for name, die, dialect in (("a", "1003", "ngspice"), ("b", "1003", "hspice"), ("c", "1004", "ngspice")):
        paths[name] = str(tmp_path / f"{name}.cir")
        made = ["--die", die, "--dialect", dialect, "-o", paths[name]]
        assert main(["export", "vocalization-controller", *made]) == 0
    assert main(["compare", paths["a"], paths["b"]]) == 0
    capsys.readouterr()
    assert main(["compare", paths["a"], paths["c"]]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 11
    assert all("deviation of V_T0" in line or "deviation of beta" in line for line in lines[1:])


def test_a_die_of_a_study_is_exported_and_imported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = ("--study", str(tmp_path / "study"))
    made = ("--plan", "lhs", "-n", "2", "--first-die", "3", "--metric", "first_call_s", "--threads", "1")
    assert main(["montecarlo", "vocalization-controller", *made, "-o", study[1]]) == 0
    paths = {}
    for name, options in (
        ("ngspice", (*study, "--die", "4")),
        ("spectre", (*study, "--die", "4", "--dialect", "spectre")),
        ("own", ("--die", "4")),
    ):
        paths[name] = str(tmp_path / f"{name}.cir")
        assert main(["export", "vocalization-controller", *options, "-o", paths[name]]) == 0
    capsys.readouterr()
    assert main(["import", paths["ngspice"], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["die"] == "die A/4 plan lhs/0"
    assert main(["compare", paths["ngspice"], paths["spectre"]]) == 0
    assert main(["compare", paths["ngspice"], paths["own"]]) == 1
    assert "deviation of V_T0" in capsys.readouterr().out


AMPLIFIER = """an amplifier of somebody else's models
m1 out in 0 0 n w=10u l=5u
m2 vdd out out vdd p w=20u l=5u
.model n nmos (level=1 vto=1 kp=20u)
.model p pmos (level=1 vto=-1 kp=10u)
vdd vdd 0 10
vin in 0 2
.op
.end
"""


def test_models_that_are_not_honoured_are_kept_for_ngspice_or_refused_unless_dropped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "amplifier.cir"
    path.write_text(AMPLIFIER)
    importing, comparing = ["import", str(path)], ["compare", str(path), str(path)]
    assert main(comparing) == 2
    refused = capsys.readouterr().err
    assert refused.startswith("noctule: amplifier.cir:4: .model n: parameters level, vto, kp: not honoured; ")
    assert main([*comparing, "--drop", "n"]) == 2
    assert "amplifier.cir:5: .model p: " in capsys.readouterr().err
    assert main([*importing, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [card["text"] for card in found["foreign"]] == AMPLIFIER.splitlines()[1:3]
    assert (found["devices"], found["dropped"]) == ({}, [])
    assert main(importing) == 0
    assert "2 cards for ngspice only" in capsys.readouterr().out
    for command in (importing, comparing):
        for drop in (["--drop", "n,P"], ["--drop", "n", "--drop", "p"], ["--drop", ".model"]):
            assert main([*command, *drop, "--json"]) == 0
            dropped = json.loads(capsys.readouterr().out)["dropped"]
            assert dropped[:2] == [
                {"what": ".model n: parameters level, vto, kp", "place": "amplifier.cir:4", "count": 1},
                {"what": ".model p: parameters level, vto, kp", "place": "amplifier.cir:5", "count": 1},
            ]
        assert main([*command, "--drop", ".model"]) == 0
        out = capsys.readouterr().out
        assert "dropped by --drop" in out
        assert ".model p: parameters level, vto, kp" in out


def test_what_was_read_is_written_in_python_and_in_other_dialects(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, made = tmp_path / "deck.cir", tmp_path / "made.py"
    path.write_text(AMPLIFIER.replace(" (level=1 vto=1 kp=20u)", "").replace(" (level=1 vto=-1 kp=10u)", ""))
    assert main(["import", str(path), "-o", str(made)]) == 0
    assert main(["op", f"{made}:testbench", "--json"]) == 0
    assert main(["compare", str(path), f"{made}:testbench"]) == 0
    for dialect in ("ngspice", "spectre", "hspice"):
        other = tmp_path / f"{dialect}.txt"
        assert main(["import", str(path), "-o", str(other), "--to", dialect]) == 0
        assert main(["compare", str(path), str(other)]) == 0
    capsys.readouterr()
    assert main(["import", str(path), "-o", str(made), "--to", "verilog"]) == 2
    assert "verilog" in capsys.readouterr().err
    path.write_text(AMPLIFIER)
    never = tmp_path / "never.py"
    assert main(["import", str(path), "-o", str(never)]) == 2
    assert "only what is all ours is written" in capsys.readouterr().err
    assert not never.exists()
    assert main(["import", str(path), "--to", "python"]) == 2
    assert "name a file too" in capsys.readouterr().err


def test_import_refuses_a_size_that_nobody_means(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "deck.cir"
    path.write_text("slip\nv1 in 0 5\nr1 in out 1k\nc1 out 0 600\n.tran 1u 1m\n")
    assert main(["import", str(path)]) == 2
    err = capsys.readouterr().err
    assert "deck.cir:4: c1.capacitance: 600 F, must be 1aF to 1mF" in err
    assert err.count("\n") == 1
    assert main(["import", str(path), "--allow-implausible", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["devices"] == {"resistor": 1, "capacitor": 1}
    assert main(["compare", str(path), str(path)]) == 0
