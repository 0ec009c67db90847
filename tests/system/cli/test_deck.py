"""Decks in `noctule op` and `noctule simulate`: natively, or in ngspice as they stand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from system.cli.command_line import main
from tests.written import written

OURS = """an inverter
.subckt inv in out vdd
mn out in 0 0 nch w=6u l=3u
mp out in vdd vdd pch w=12u l=3u
.ends
.model nch nmos
.model pch pmos
vdd vdd 0 5
vin 0 in -1
x1 in out s inv
va vdd s 0
.dc vin 0 -5 -1 vdd 4 5 1
.tran 1u 10u
.temp 60
.end
"""
THEIRS = """a follower
.model q npn (bf=100)
vcc c 0 5
vb b 0 dc 2 sin(2 0.1 1k)
q1 c b e q
re e 0 1k
.op
.dc vb 1 3 0.5
.tran 10u 2m
.measure tran top max v(e)
.end
"""


@pytest.fixture
def ours(tmp_path: Path) -> str:
    return str(written(tmp_path / "ours.cir", OURS))


@pytest.fixture
def theirs(tmp_path: Path) -> str:
    return str(written(tmp_path / "theirs.cir", THEIRS))


def test_a_sweep_of_two_sources_by_the_signs_of_the_deck(
    ours: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "dc.csv"
    assert main(["simulate", ours, "--analysis", "dc", "--csv", str(table), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["axis"], document["points"], document["engine"]) == ("vin", 12, "native")
    found = np.genfromtxt(table, delimiter=",", names=True)
    np.testing.assert_allclose(found["vin"], [0.0, -1.0, -2.0, -3.0, -4.0, -5.0] * 2)
    np.testing.assert_allclose(found["in_V"], -found["vin"])  # the source stands upside down
    np.testing.assert_allclose(found["vdd_V"], [4.0] * 6 + [5.0] * 6)
    assert found["out_V"][0] == pytest.approx(4.0, abs=1e-3)
    assert found["out_V"][-1] == pytest.approx(0.0, abs=1e-3)


def test_the_deck_says_its_temperature_and_the_user_another(
    ours: str, capsys: pytest.CaptureFixture[str]
) -> None:
    given = (["--temperature", "40"], 40.0), (["--temperature", "27"], 27.0)  # 27 is the usual one elsewhere
    for options, degrees in (([], 60.0), *given):
        assert main(["op", ours, *options, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["temperature_C"] == degrees


def test_a_deck_s_own_measures_are_told_and_one_of_no_node_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "measured.cir"
    cards = ".measure tran most max v(out)\n.measure tran lost max v(nowhere)\n.measure dc other max v(out)\n"
    path.write_text("a divider\nv1 in 0 pwl(0 0 1m 3)\nr1 in out 1k\nr2 out 0 2k\n.tran 1u 1m\n" + cards)
    assert main(["simulate", str(path), "--measure", "half = most / 2", "--json"]) == 0
    said = capsys.readouterr()
    found = {each["name"]: each["value"] for each in json.loads(said.out)["measured"]}
    assert found == pytest.approx({"most": 2.0, "half": 1.0})
    assert "node nowhere: unknown" in said.err
    assert said.err.count("\n") == 1


@pytest.mark.parametrize("analysis", ["dc", "ac"])
def test_a_deck_s_measures_of_its_sweep_and_of_small_signals_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], analysis: str
) -> None:
    cards = (
        ".dc v1 0 3 0.1\n.ac dec 10 1 1meg\n.measure dc at when v(out)=0.5\n.measure ac low max vdb(out)\n"
    )
    parts = "v1 in 0 dc 1 ac 1\nr1 in out 1k\nr2 out 0 1k\nc1 out 0 1p\n"
    path = written(tmp_path / "divider.cir", f"a divider\n{parts}{cards}.measure dc lost max v(nowhere)\n")
    peak = "peak = max(mag(v(out)))" if analysis == "ac" else "peak = max(v(out))"
    assert main(["simulate", str(path), "--analysis", analysis, "--measure", peak, "--json"]) == 0
    said = capsys.readouterr()
    document = json.loads(said.out)
    measured = document["measured"] if analysis == "dc" else document["runs"][0]["measured"]
    found = {each["name"]: (each["value"], each["unit"]) for each in measured}
    half = {"dc": {"at": (1.0, "V"), "peak": (1.5, "V")}, "ac": {"low": (-6.0206, "dB"), "peak": (0.5, "")}}
    assert {name: unit for name, (_, unit) in found.items()} == {n: u for n, (_, u) in half[analysis].items()}
    for name, (value, _) in half[analysis].items():
        assert found[name][0] == pytest.approx(value, rel=1e-4)
    assert said.err.count("this .measure card is left out") == (analysis == "dc")


def test_a_sweep_has_the_currents_of_the_supplies_with_the_signs_of_the_deck(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cards = ".dc v1 0 2 0.5\n.measure dc x find i(v1) at=1.5\n.measure dc y find i(v2) at=1.5\n"
    parts = "v1 a 0 1\nr1 a b 1k\nr2 b 0 1k\nv2 0 n 2\nr3 n b 1k\ni1 0 a 0.25m\n"
    path, table = written(tmp_path / "supplies.cir", f"supplies\n{parts}{cards}"), tmp_path / "dc.csv"
    assert main(["simulate", str(path), "--analysis", "dc", "--csv", str(table), "--json"]) == 0
    found = {each["name"]: each["value"] for each in json.loads(capsys.readouterr().out)["measured"]}
    assert found == pytest.approx({"x": -1.416667e-3, "y": -1.833333e-3}, rel=1e-6)  # ngspice's own
    first, *rows = table.read_text().splitlines()
    assert first == "v1,a_V,n_V,b_V,i(v1)_A,i(v2)_A"
    assert [float(row.split(",")[5]) for row in rows if row.startswith("1.5")] == pytest.approx(
        [-1.833333e-3]
    )


def test_a_node_that_a_current_feeds_is_an_answer_of_the_deck(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parts = "vin in 0 dc 1 ac 1\nr1 in out 1k\nr2 out 0 1k\nib 0 out 1m\n.ac dec 1 1 10\n.tran 1u 1m\n"
    path = written(tmp_path / "fed.cir", f"a fed divider\n{parts}")
    assert main(["simulate", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["measures"]["out_last_V"] == pytest.approx(1.0)
    assert main(["simulate", str(path), "--analysis", "ac"]) == 0
    assert "out" in capsys.readouterr().out.split("largest")[1]


def test_a_deck_of_other_devices_is_refused_natively_and_runs_in_ngspice(
    theirs: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for command in (["op", theirs], ["simulate", theirs], ["simulate", theirs, "--analysis", "dc"]):
        assert main(command) == 2
        refused = capsys.readouterr().err
        assert refused.count("\n") == 1
        assert "theirs.cir:5: q1: a bipolar transistor, which the native solver has not" in refused
        assert refused.endswith("run it with --engine ngspice\n")
        assert main([*command, "--engine", "ngspice", "--json"]) == 0
        document = json.loads(capsys.readouterr().out)
        emitter = {v["name"]: v for v in document["vectors"]}["e"]
        assert 0.2 < emitter["max"] < 2.6
        transient = document["analysis"] == "tran"
        assert [m["value"] for m in document["measured"]] == [emitter["max"]] * transient
    assert document["axis"] == "v-sweep"
    picture = tmp_path / "a.png"
    assert main(["simulate", theirs, "--engine", "ngspice", "--plot", str(picture)]) == 0
    assert picture.stat().st_size > 5_000
    assert "tran in ngspice" in capsys.readouterr().out


def test_what_a_deck_as_it_stands_has_not_is_refused(theirs: str, capsys: pytest.CaptureFixture[str]) -> None:
    for options, says in (
        (["--analysis", "ac", "--source", "vb"], "must be tran or dc"),
        (["--raw", "a.raw"], "--raw: not of a deck"),
    ):
        assert main(["simulate", theirs, "--engine", "ngspice", *options]) == 2
        assert says in capsys.readouterr().err
    assert main(["simulate", "rebound-neuron", "--analysis", "dc"]) == 2
    assert "name a deck" in capsys.readouterr().err
    assert main(["op", "rebound-neuron", "--engine", "ngspice"]) == 2


def test_transistors_that_deviate_by_their_own_cards_are_refused(
    ours: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path(ours).write_text(OURS.replace("l=3u", "l=3u delvto=10m"))
    assert main(["op", ours]) == 2
    assert "mn has delvto or mulu0" in capsys.readouterr().err


def test_a_subcircuit_under_a_testbench_of_its_own(
    ours: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = tmp_path / "bench.toml"
    bench.write_text('stop = "10us"\n[voltages]\nvdd = 5\nin = "pulse(0 5 1u 10n 10n 4u 20u)"\n')
    given = [f"{ours}:inv", "--testbench", str(bench)]
    assert main(["simulate", *given, "--json"]) == 0
    measures = json.loads(capsys.readouterr().out)["measures"]
    assert measures["out_min_V"] < 0.01
    assert measures["out_last_V"] == pytest.approx(5.0, abs=0.01)
    assert main(["op", *given]) == 0
    assert main(["export", *given, "-o", str(tmp_path / "inv.cir")]) == 0
    capsys.readouterr()
    assert main(["op", ours, "--testbench", str(bench)]) == 2
    assert "is for deck.cir:SUBCIRCUIT" in capsys.readouterr().err


def test_a_deck_of_ours_runs_on_the_silicon_that_its_notes_are_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(tmp_path / "synapse.cir")
    made = ["--die", "1003", "--temperature", "40"]
    assert main(["export", "dpi-synapse", *made, "-o", path]) == 0
    capsys.readouterr()
    volts = []
    for command in (["op", "dpi-synapse", *made], ["op", path]):
        assert main([*command, "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert (found["process"], found["die"], found["temperature_C"]) == ("rolls-180", 1003, 40.0)
        volts.append(found["voltages_V"])
    assert volts[0] == pytest.approx(volts[1], abs=1e-9)
    assert main(["op", path, "--die", "1004", "--temperature", "50", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["die"], found["temperature_C"]) == (1004, 50.0)


def test_small_signals_and_noise_are_those_of_the_deck(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "low.cir"
    text = "a low-pass\nv0 q 0 1\nvin in 0 dc 1 ac 1\nr1 in out 1meg\nr2 out q 1g\nc1 out 0 1p\n"
    path.write_text(text + ".ac dec 5 100 100meg\n.noise v(out) vin dec 5 1 1meg\n")
    assert main(["simulate", str(path), "--analysis", "ac", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["source"], found["frequency_Hz"][0], found["frequency_Hz"][-1]) == ("vin", 100.0, 100e6)
    assert len(found["frequency_Hz"]) == 31
    assert main(["simulate", str(path), "--analysis", "ac", "--from", "1kHz", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["frequency_Hz"][0] == 1e3
    assert main(["simulate", str(path), "--analysis", "noise", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["source"] == "vin"


DIRECT = """a divider that is at rest elsewhere than where its run begins
v1 in 0 dc 1 ac 1 pulse(0 2 1u 1u 1u 3u 10u)
i1 c 0 dc 1m sin(0 2m 100k)
r1 in out 1k
r2 out 0 1k
d1 out 0 dd
r4 c 0 1k
v2 b 0 0.4
r3 b out 1k
c1 out 0 1n
.model dd d is=1e-14
.dc v2 0 1 0.5
.ac dec 2 1k 1meg
.tran 10n 5u
.end
"""


@pytest.mark.parametrize("dialect", ["", "ngspice", "spectre", "xyce", "python"])
def test_a_dc_value_holds_where_there_is_no_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], dialect: str
) -> None:
    path = str(written(tmp_path / "deck.cir", DIRECT))
    if dialect == "python":
        assert main(["import", path, "-o", str(tmp_path / "again.py")]) == 0
        path = f"{tmp_path / 'again.py'}:testbench"
    elif dialect:
        assert main(["export", path, "--dialect", dialect, "-o", str(tmp_path / "again.cir")]) == 0
        path = str(tmp_path / "again.cir")
    capsys.readouterr()
    assert main(["op", path, "--json"]) == 0
    volts = json.loads(capsys.readouterr().out)["voltages_V"]
    rest = {"in": 1.0, "b": 0.4, "c": -1.0, "out": 0.4664403}  # ngspice 39 by itself
    assert {n: volts[n] for n in rest} == pytest.approx(rest, abs=1e-6)
    assert main(["simulate", path, "--measure", "first = value(in, at=0)", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["measured"][0]["value"] == 0.0
    if not dialect:
        table = tmp_path / "dc.csv"
        assert main(["simulate", path, "--analysis", "dc", "--csv", str(table)]) == 0
        rows = np.genfromtxt(table, delimiter=",", names=True)
        assert rows["in_V"] == pytest.approx(1.0)
        assert rows["c_V"] == pytest.approx(-1.0)


MOVED = """small signals of several sources, and noise between two nodes
.param size=2
v1 in 0 dc 1 ac {size}
x1 b half
.subckt half o
v2 o 0 dc 0.3 ac 1 90
.ends
i3 out 0 dc 0 ac 1m
i4 in2 out dc 0 ac 0.5m -90
r1 in out 1k
r2 b out 1k
r3 in2 0 2k
r4 in2 b 3k
c1 out 0 1n
.ac oct 2 10k 1meg
.noise v(out,in2) v1 oct 2 10k 1meg
.meas ac size find vm(out) at=1e5
.meas ac turned find vp(out) at=1e5
.end
"""


def test_the_ac_values_of_a_deck_act_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(written(tmp_path / "deck.cir", MOVED))
    assert main(["simulate", path, "--analysis", "ac", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["source"], found["unit"]) == ("v1, x1_x2e_v2, i3, i4[0], i4[1]", "V")
    assert (found["frequency_Hz"][0], found["frequency_Hz"][-1]) == (1e4, pytest.approx(1e6))
    g = 2j * np.pi * 1e5 * 1e-9 + 2e-3  # S, at `out`, whose other ends are sources
    out = (2.0 * 1e-3 + 1j * 1e-3 - 1e-3 - 0.5e-3j) / g
    size, turned = (each["value"] for each in found["runs"][0]["measured"])
    assert size == pytest.approx(abs(out), rel=1e-3)  # between the points of an octave's half
    assert turned == pytest.approx(np.degrees(np.angle(out)), abs=0.2)
    assert main(["simulate", path, "--analysis", "ac", "--param", "size=4", "--node", "in", "--json"]) == 0
    other = json.loads(capsys.readouterr().out)
    assert other["runs"][0]["nodes"]["in"]["magnitude"][0] == pytest.approx(4.0)


def test_a_transfer_of_one_source_is_not_measured_by_cards_of_all(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(written(tmp_path / "deck.cir", MOVED))
    assert main(["simulate", path, "--analysis", "ac", "--source", "v1", "--json"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["runs"][0]["measured"] == []
    assert "of the deck's own AC values, which hold without --source" in said.err


def test_a_deck_of_odd_values_is_taken_where_they_are_meant(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(written(tmp_path / "odd.cir", "a battery\ni1 0 a 4\nr1 a 0 1\n.tran 1n 1u\n.end\n"))
    assert main(["op", path]) == 2
    assert "4 A, must be" in capsys.readouterr().err
    assert main(["op", path, "--allow-implausible", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["voltages_V"]["a"] == pytest.approx(4.0)
    for analysis in ("tran", "noise"):
        more = ["--node", "a"] if analysis == "noise" else []
        assert main(["simulate", path, "--analysis", analysis, "--allow-implausible", *more]) == 0


def test_noise_of_a_deck_is_between_its_two_nodes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(written(tmp_path / "deck.cir", MOVED))
    assert main(["simulate", path, "--analysis", "noise", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["node"], found["source"]) == ("v(out,in2)", "v1")
    kelvin, low = 300.15, found["runs"][0]["output_V2_per_Hz"][0]
    assert low == pytest.approx(4 * 1.380649e-23 * kelvin * (500.0 + 1200.0), rel=1e-2)  # 1e4 Hz of 3e5 Hz
    assert main(["simulate", path, "--analysis", "noise", "--node", "out", "--json"]) == 0
    alone = json.loads(capsys.readouterr().out)["runs"][0]["output_V2_per_Hz"][0]
    assert alone == pytest.approx(4 * 1.380649e-23 * kelvin * 500.0, rel=1e-2)


TURNED = """sources from ground, and between two nodes
i1 a 0 dc 1u
r1 a 0 1meg
v2 0 b 2
r2 b 0 1k
i3 c d 1m
r3 c 0 1k
r4 d 0 2k
xp q part
.subckt part q
v2 q 0 1
r1 q 0 1k
.ends
r9 q 0 1k
.tran 1n 10n
.meas tran x find i(i1) at=5n
.meas tran y find i(v2) at=5n
.meas tran z find i(v.xp.v2) at=5n
.meas tran w find i(i3) at=5n
"""


def test_sources_that_a_circuit_sees_from_their_other_end_have_the_deck_s_signs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(written(tmp_path / "deck.cir", TURNED))
    assert main(["simulate", path, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["measured"]
    assert [each["value"] for each in found] == pytest.approx([1e-6, -2e-3, -2e-3, 1e-3])  # as SPICE has them
    stepped = str(written(tmp_path / "stepped.cir", TURNED + ".step i1 1u 3u 1u\n.step v2 list 2 3\n"))
    assert main(["sweep", stepped, "--node", "a", "--node", "b", "--json"]) == 0
    volts = json.loads(capsys.readouterr().out)["voltages_V"]
    assert volts["a"] == pytest.approx([-1.0, -1.0, -2.0, -2.0, -3.0, -3.0])
    assert volts["b"] == pytest.approx([-2.0, -3.0] * 3)
    assert main(["sweep", stepped, "--analysis", "tran", "--json"]) == 0
    measured = json.loads(capsys.readouterr().out)["measured"]
    assert measured["x"]["values"] == pytest.approx([1e-6, 1e-6, 2e-6, 2e-6, 3e-6, 3e-6])


def test_a_current_between_two_nodes_is_swept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cards = ".dc i3 0 2m 1m i1 0 1u 1u\n"
    path = str(written(tmp_path / "deck.cir", TURNED + cards))
    table = tmp_path / "dc.csv"
    assert main(["simulate", path, "--analysis", "dc", "--csv", str(table), "--json"]) == 0
    rows = np.genfromtxt(table, delimiter=",", names=True)
    assert rows["i3"] == pytest.approx([0.0, 1e-3, 2e-3] * 2)
    assert rows["c_V"] == pytest.approx([0.0, -1.0, -2.0] * 2, abs=1e-9)
    assert rows["d_V"] == pytest.approx([0.0, 2.0, 4.0] * 2, abs=1e-9)
    assert rows["a_V"] == pytest.approx([0.0] * 3 + [-1.0] * 3, abs=1e-9)


STEPPED = """a filter
.param r=1k tau={r*1n} late={2*tau}
v1 in 0 pulse(0 1 1u 1n 1n 1 2)
r1 in o {r}
c1 o 0 {tau/r}
.step param r list 1k 4k
.tran 10n {10*tau}
.measure tran t_half when v(o)=0.5 rise=1
.measure tran v_late find v(o) at={late+1u}
.end
"""


def test_a_step_of_a_parameter_is_swept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "filter.cir"
    path.write_text(STEPPED)
    assert main(["op", str(path)]) != 0
    assert "filter.cir:6: .step param r: not of one run; noctule sweep" in capsys.readouterr().err
    assert main(["sweep", str(path), "--analysis", "tran", "--json"]) == 0
    said = capsys.readouterr()
    found = json.loads(said.out)
    assert found["over"][0]["name"] == "r"
    # 1 us, half of the edge of 1 ns, and R C ln 2
    wanted = [1.0005e-6 + r * 1e-9 * np.log(2.0) for r in (1e3, 4e3)]
    assert found["measured"]["t_half"]["values"] == pytest.approx(wanted, rel=1e-3)
    assert "v_late" not in found["measured"]
    assert "follows r, which is swept; this .measure card is left out" in said.err


def test_a_capacitance_is_swept_beside_a_measure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "v 1 0 sin(0 1 1k)\n.param c=1n\nr1 1 2 1k\nc1 2 0 {c}\n.tran 10u 2m\n.measure tran top max v(2)\n"
    path = written(tmp_path / "rc.cir", f"an rc\n{text}")
    assert main(["sweep", str(path), "--over", "c=1n,100n", "--analysis", "tran", "--json"]) == 0
    assert capsys.readouterr().err == ""


def test_a_parameter_of_a_deck_is_an_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "filter.cir"
    path.write_text(STEPPED.replace(".step param r list 1k 4k", "*"))
    assert main(["simulate", str(path), "--param", "r=4k", "--json"]) == 0
    found = {m["name"]: m["value"] for m in json.loads(capsys.readouterr().out)["measured"]}
    assert found["t_half"] == pytest.approx(1.0005e-6 + 4e-6 * np.log(2.0), rel=1e-3)
    assert found["v_late"] == pytest.approx(1.0 - np.exp(-2.0), rel=1e-3)
    assert main(["simulate", str(path), "--param", "tau=1u"]) != 0
    assert "tau: unknown" in capsys.readouterr().err
    path.write_text(STEPPED.replace(".step param r list 1k 4k", "q1 o o 0 q\n.model q npn"))
    assert main(["simulate", str(path), "--engine", "ngspice", "--param", "r=4k"]) != 0
    assert "--param: r=4k, not of a deck as it stands" in capsys.readouterr().err


@pytest.mark.parametrize("engine", ["native", "ngspice"])
def test_a_step_card_is_told_of_noctule_sweep_since_ngspice_has_none(
    engine: str, ours: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = Path(ours)
    path.write_text(OURS.replace(".temp 60", ".step temp 0 60 30"))
    assert main(["op", ours, "--engine", engine]) != 0
    said = capsys.readouterr().err
    assert "ours.cir:14: .step temp: not of one run" in said
    assert "noctule sweep" in said
    assert "--engine" not in said
    capsys.readouterr()
    assert main(["sweep", ours, "--json"]) == 0
    swept = json.loads(capsys.readouterr().out)["over"]
    assert [(each["name"], each["values"]) for each in swept] == [("temperature", [0.0, 30.0, 60.0])]
