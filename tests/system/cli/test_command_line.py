"""The command: one JSON document or tables on stdout, one line on stderr for whatever goes wrong."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from circuits.errors import ParameterError
from netlists.registry import dialect_names
from system import registry
from system.cli import doctor, listing, mend, reproduce
from system.cli.examples import EXAMPLES
from system.cli.output import plain
from system.experiment import Experiment, Progress, Report
from system.rule import equal, unjudged, within_share
from system.statement import Statement
from tests.refusals import command_refusals
from tests.system.conftest import Run, RunJson

ROOT = Path(__file__).resolve().parents[3]
HEAVY = ("numpy", "numba", "scipy", "matplotlib", "PySpice", "networkx", "rich")


def process(*arguments: str, code: str | None = None, **options: Any) -> "subprocess.Popen[str]":
    command = [sys.executable, *(("-c", code) if code else ("-m", "system.cli.command_line")), *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    return subprocess.Popen(command, cwd=ROOT, text=True, **pipes)


@pytest.mark.parametrize("arguments", ["", "--help", "--version", "run --help", "montecarlo --help", "list"])
def test_help_imports_nothing_heavy(arguments: str) -> None:
    out, imported = heavy_of(arguments)
    assert imported == []
    assert "noctule" in out


@pytest.mark.parametrize(
    ("arguments", "own"),
    [
        ("show dpi-synapse", []),
        ("show rebound-neuron", []),
        ("simulate nef-neuron --stimulus duration=1us", ["numba", "scipy"]),
    ],
)
def test_a_command_imports_what_it_reaches_alone(arguments: str, own: list[str]) -> None:
    imported = heavy_of(arguments)[1]
    assert [name for name in imported if name not in ("numpy", "rich")] == own


def heavy_of(arguments: str) -> tuple[str, list[str]]:
    """What a command prints, and which of the heavy libraries it imports."""
    code = (
        "import sys; from system.cli.command_line import main; status = main(sys.argv[1:]);"
        f"print(*[m for m in {HEAVY} if m in sys.modules]); sys.exit(status)"
    )
    child = process(*arguments.split(), code=code)
    out, err = child.communicate()
    assert (child.returncode, err) == (0, "")
    return out, out.splitlines()[-1].split()


def test_no_arguments_is_a_guide(run: Run) -> None:
    status, out, err = run()
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 100
    commands = [line.strip() for line in out.splitlines() if line.startswith("    noctule ")]
    assert len(commands) == 3
    examples = {line for lines in EXAMPLES.values() for line in lines}  # which the documents' test runs
    assert examples >= set(commands)
    assert all(word in out for word in ("noctule list", "noctule doctor", "--help"))


def test_the_line_of_each_command_is_whole(run: Run) -> None:
    for group in ((), ("run",)):
        lines = run(*group, "--help")[1].partition("Commands:\n")[2].splitlines()
        assert len(lines) > 8
        assert [line for line in lines if line.endswith("...")] == []


def test_list(run: Run, run_json: RunJson) -> None:
    found = run_json("list")
    assert list(found) == ["blocks", "chips", "calibrations", "systems", "experiments", "metrics", "dialects"]
    assert {e["name"] for e in found["experiments"]} >= set(registry.EXPERIMENTS)
    assert {e["name"] for e in found["dialects"]} >= {*dialect_names(), "xschem"}
    by_name = {e["name"]: e["summary"] for group in found.values() for e in group}
    assert "rebound" in by_name["rebound-neuron"]
    text = run("list")[1]
    assert all(entry["summary"] in text for group in found.values() for entry in group)
    assert max(map(len, text.splitlines())) <= 100
    lines = [line for line in text.splitlines() if line]
    assert lines.index("Circuits of the ROLLS chip") < lines.index(
        f"  rolls-neuron        {by_name['rolls-neuron']}"
    )
    after = lines[lines.index("Hwu et al. 2018: path planning by waves of spikes") + 1 :]
    assert [line.split()[0] for line in after[:5]] == [n for n in registry.EXPERIMENTS if n.startswith("hwu")]


def test_an_entry_that_cannot_be_loaded_hides_no_other(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def line(name: str) -> str:
        raise ParameterError("mine: cannot be loaded; mend it")

    mine = replace(listing.KINDS[0], names=lambda: ["mine"], line=line)
    monkeypatch.setattr(listing, "KINDS", (mine, *listing.KINDS[1:]))
    status, out, err = run("list")
    assert (status, err.count("\n")) == (1, 1)
    assert "Of other packages\n  mine  cannot be loaded: mine: cannot be loaded; mend it\n" in out
    assert "ranging-chip" in out
    assert err.startswith("noctule: list: mine cannot be loaded")


def test_show(run: Run, run_json: RunJson) -> None:
    found = run_json("show", "rebound-neuron", "--param", "membrane_capacitance=700fF")
    devices = {d["path"]: d for d in found["devices"]}
    assert len(devices) == found["device_count"]
    assert devices["membrane.c_m"]["sizes"] == {"capacitance": 700e-15}
    assert devices["inhibition.mi5"]["terminals"]["gate"] == "v_inh_tau"
    assert devices["inhibition.mi5"]["polarity"] == "n"
    ports = {p["name"]: p for p in found["ports"]}
    assert ports["spike"] == {"name": "spike", "kind": "event", "direction": "out", "shape": []}
    text = run("show", "rebound-neuron")[1]
    assert "inhibition.mi5" in text
    assert "199.9pA" in text


def test_show_gives_gate_voltages_at_the_temperature(run_json: RunJson) -> None:
    def voltage(*options: str) -> float:
        biases = {b["name"]: b for b in run_json("show", "rebound-neuron", *options)["biases"]}
        return float(biases["i_inh_tau"]["voltage_V"])

    assert voltage("--temperature", "85") == voltage()
    assert voltage("--temperature", "85", "--bias-kind", "ideal") != voltage("--bias-kind", "ideal")


def test_show_a_chip(run: Run, run_json: RunJson) -> None:
    found = run_json("show", "ranging-chip")
    assert "neuron[12].axon.ma1" in {d["path"] for d in found["devices"]}
    assert "neuron[0:13].axon.ma1" in run("show", "ranging-chip")[1]


def test_show_draws(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "graph.svg"
    assert run("show", "rebound-neuron", "--plot", str(path))[0] == 0
    assert path.read_bytes().startswith(b"<?xml")


def test_a_graph_is_drawn_alike_by_every_process(tmp_path: Path, run: Run) -> None:
    """Sets have one order in this process and another in the other."""
    here, there = tmp_path / "here.svg", tmp_path / "there.svg"
    words = ("show", "vocalization-controller", "--plot")
    child = process(*words, str(there), env={**os.environ, "PYTHONHASHSEED": "1"})
    assert run(*words, str(here))[0] == 0
    assert child.communicate()[1] == ""
    assert here.read_bytes() == there.read_bytes()


def test_op(run: Run, run_json: RunJson) -> None:
    found = run_json("op", "rebound-neuron", "--start", "v_mem=1.8V")
    assert found["stable"] is True
    assert found["other_states"] == []
    # M1 ties v_mem to V_rest = 1.8 V, which I_rslope lifts by a few mV.
    assert found["voltages_V"]["v_mem"] == pytest.approx(1.8, abs=0.01)
    assert "the state is stable" in run("op", "rebound-neuron")[1]


def test_op_tells_of_another_state(run: Run, run_json: RunJson) -> None:
    start = ("--start", "q=5V", "--start", "q_bar=0V")
    found = run_json("op", "first-target-isolation", *start)
    # A latch rests in two states, and in an unstable one between them.
    assert found["stable"] is True
    assert found["voltages_V"]["q"] == pytest.approx(5.0, abs=0.01)
    assert found["start_V"] == {"q": 5.0, "q_bar": 0.0}
    assert all(other["voltages_V"]["q"] < 4.0 for other in found["other_states"])
    assert len(found["other_states"]) == 1
    assert "without the start another state is found" in run("op", "first-target-isolation", *start)[1]


def test_simulate(run: Run, run_json: RunJson, tmp_path: Path) -> None:
    csv, plot = tmp_path / "run.csv", tmp_path / "run.png"
    files = ("--csv", str(csv), "--plot", str(plot))
    found = run_json("simulate", "rebound-neuron", "--stimulus", "delay=6.4ms", *files)
    assert found["block"] == "rebound-neuron"
    assert found["engine"] == "native"
    assert found["temperature_C"] == 27.0
    assert found["outcome"] == "one-spike"
    assert isinstance(found["spikes_s"], list)
    assert len(found["spikes_s"]) == 1
    assert set(found["measures"]) == {"t_inh_s", "t_reb_s", "v_mem_peak_V", "supply_power_W"}
    assert found["steps"] > 0
    header, *rows = csv.read_text().splitlines()
    assert header.startswith("time_s,")
    assert len(rows) == found["steps"] + 1
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert "one-spike" in run("simulate", "rebound-neuron")[1]


def test_simulate_with_options(run_json: RunJson) -> None:
    off = run_json("simulate", "rebound-neuron", "--stimulus", "call=off", "--stimulus", "echo=off")
    assert (off["outcome"], off["spikes_s"]) == ("none", [])
    assert off["stimuli"]["call"] is None
    assert off["measures"]["t_inh_s"] is None
    usual = run_json("simulate", "rebound-neuron")["measures"]["t_inh_s"]
    halved = run_json("simulate", "rebound-neuron", "--bias", "i_inh_tau=99.95pA")["measures"]["t_inh_s"]
    # t_inh = C dV / I: half the current takes about twice as long; the fall's beginning does not scale.
    assert halved / usual == pytest.approx(2.0, rel=0.05)
    hot = run_json("simulate", "rebound-neuron", "--temperature", "60")["measures"]["t_inh_s"]
    assert hot < usual
    larger = run_json("simulate", "rebound-neuron", "--param", "inhibition_capacitance=880fF")
    assert larger["measures"]["t_inh_s"] > usual


def test_simulate_an_array_gives_spikes_by_port(run_json: RunJson) -> None:
    found = run_json("simulate", "ranging-chip")["spikes_s"]
    assert list(found) == [f"spike[{k}]" for k in range(13)]
    assert len(found["spike[2]"]) == 1


BLOCK = "rebound-neuron"
BAD_INPUT = [
    ("simulat", "No such command 'simulat'; did you mean simulate?"),
    ("simulate", "Missing argument"),
    ("simulate rebound-neuron --bogus", "No such option"),
    ("simulate rebound-neuron --plt v.png", "No such option: --plt; did you mean --plot?"),
    ("doctor --jsn", "No such option: --jsn; did you mean --json?"),
    ("simulate rebound-neuron --engine spectre", "is not one of"),
    ("simulate rebound-neuron --engine ngspic", "is not one of 'native', 'ngspice'; did you mean ngspice?"),
    ("simulate rebound-neuron --corner typcal", "did you mean typical?"),
    ("simulate rebound-neuron --bias-set robus", "did you mean robust?"),
    ("simulate rebound-neuron --at 'ranging-chp/neuron[2]'", "did you mean ranging-chip?"),
    ("export rebound-neuron --process gf180mc -o -", "did you mean gf180mcu?"),
    ("export rolls --at 'row[5]' --program pushbt -o -", "did you mean pushbot?"),
    ("show rolls --bias-file rolls_defalt", "did you mean rolls_default?"),
    ("montecarlo forst", "did you mean forest?"),
    ("montecarlo rebound-neuron --metric best_dely", "did you mean best_delay?"),
    ("montecarlo forest --param obstacls=3", "did you mean obstacles?"),
    ("run forst", "did you mean forest?"),
    ("run forest --rangs chip", "No such option: --rangs; did you mean --ranges?"),
    ("run forest --ranges chp", "must be exact, sonar or chip; did you mean chip?"),
    ("run bug --map bug-feld", "did you mean bug-field?"),
    ("run pushbot --scene singl-block", "did you mean single-block?"),
    ("characterise lso-neurn", "did you mean lso-neuron?"),
    ("simulate rebound-neuron --rtol x", "--rtol"),
    ("simulate rebound-neuron --rtol 1", "rtol"),
    ("simulate rebound-neuron --rtol 1e-4 --engine ngspice", "only the native engine"),
    ("simulate rebound-neurn", "did you mean rebound-neuron"),
    ("simulate rebound-neuron --stimulus delay=6.4V", "must be a time in s"),
    ("simulate rebound-neuron --stimulus dely=6.4ms", "did you mean delay"),
    ("simulate rebound-neuron --stimulus delay", "must be NAME=VALUE"),
    ("simulate rebound-neuron --stimulus duration=-1ms", "must be > 0"),
    ("simulate rebound-neuron --param membrane_capacitanc=1p", "did you mean membrane_capacitance"),
    ("simulate rebound-neuron --param membrane_capacitance=-600fF", "must be > 0"),
    ("simulate rebound-neuron --param membrane_capacitance=1F", "also femto"),
    ("simulate rebound-neuron --bias i_lm=1n", "did you mean i_lim"),
    ("simulate rebound-neuron --bias i_lim=-1n", "must be > 0"),
    ("simulate rebound-neuron --temperature 126", "must be within -40 to 125"),
    ("simulate rebound-neuron --temperature -41", "must be within -40 to 125"),
    ("simulate rebound-neuron --temperature hot", "must be a temperature"),
    ("simulate rebound-neuron --plot /nonexistent/run.png", "there is no folder"),
    ("simulate rebound-neuron --plot run.gif", "must end with .png"),
    ("simulate rebound-neuron --csv /dev/full", "no space is left"),
    ("show rebound-neuron --plot /nonexistent/graph.png", "there is no folder"),
    ("op rebound-neuron --start v_me=1V", "did you mean v_mem"),
    ("op rebound-neuron --start v_mem=1A", "must be a voltage"),
    ("op rebound-neuron --start v_mem=1e9V", "must be within -100 to 100"),
    ("reproduce fig9", "did you mean cheely2003-fig9"),
    ("reproduce wen2022-fig13 --param forets=3", "did you mean forests?"),
]  # fmt: skip


test_bad_input_is_one_line = command_refusals(rows=BAD_INPUT)


def test_a_missing_ngspice_is_one_line(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NGSPICE_LIBRARY_PATH", "/nonexistent")
    status, out, err = run("simulate", BLOCK, "--engine", "ngspice")
    assert (status, out) == (2, "")
    assert err.startswith("noctule: NGSPICE_LIBRARY_PATH: /nonexistent")
    assert err.count("\n") == 1


def test_export(run: Run, run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "neuron.cir"
    assert run("export", BLOCK, "-o", str(path)) == (0, "", "")
    status, out, _ = run("export", BLOCK, "-o", "-")
    assert (status, out) == (0, path.read_text())
    assert out.rstrip().endswith(".end")
    assert run_json("export", BLOCK, "-o", "-")["netlist"] == out
    found = run_json("export", "ranging-chip", "-o", str(path))
    assert (found["file"], found["lines"]) == (str(path), path.read_text().count("\n"))


def test_export_for_another_simulator(run: Run, run_json: RunJson, tmp_path: Path) -> None:
    for name in dialect_names():
        assert run_json("export", BLOCK, "--dialect", name, "-o", "-")["dialect"] == name
    assert "known are" in run("export", BLOCK, "--dialect", "foo", "-o", "-")[2]
    assert "xschem" in run("export", BLOCK, "--dialect", "foo", "-o", "-")[2]
    status, _, err = run("export", BLOCK, "--dialect", "xyse", "-o", "-")
    assert (status, err.count("\n")) == (2, 1)
    assert "dialect xyse: unknown; did you mean xyce?" in err
    found = run_json("export", "ranging-chip", "--dialect", "spectre", "-o", str(tmp_path / "chip.scs"))
    assert (found["dialect"], found["models"]) == ("spectre", "ekv")
    assert (found["definitions"], found["devices"]) == (7, 13 * 40)
    found = run_json("export", BLOCK, "--models", "bsim3", "--die", "3", "-o", "-")
    assert found["models"] == "bsim3"
    assert "delvto=" in found["netlist"]
    status, _, err = run("export", BLOCK, "--models", "bsim3", "--dialect", "cdl", "-o", "-")
    assert (status, err.count("\n")) == (2, 1)
    assert "models: bsim3, cdl has ekv" in err
    layout = tmp_path / "layout.csv"
    layout.write_text("v_mem,12fF\nmembrane.v_r,1f\n")
    found = run_json("export", BLOCK, "--parasitics", str(layout), "-o", "-")
    assert found["parasitics"] == 2
    assert "parasitic0 v_r 0 1e-15" in found["netlist"]
    layout.write_text("v_men,12fF\n")
    status, _, err = run("export", BLOCK, "--parasitics", str(layout), "-o", "-")
    assert (status, err.count("\n")) == (2, 1)
    assert "layout.csv:1: no node v_men" in err


@pytest.mark.parametrize(
    ("place", "words"), [("/dev/full", "no space is left"), ("/nowhere/a.cir", "no folder")]
)
def test_an_export_that_cannot_be_written(place: str, words: str, run: Run) -> None:
    status, out, err = run("export", BLOCK, "-o", place)
    assert (status, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1


def experiment(*rows: Statement) -> Experiment:
    def draw(figure: Figure) -> None:
        figure.subplots().plot([0.0, 1.0])

    def carry_out(progress: Progress) -> Report:
        progress(1.0)
        return Report(rows, draw, ("a note",))

    return Experiment("mine", "an experiment of ours", carry_out)


AGREES = Statement("delay_s", 6.3e-3, 6.4e-3, within_share(0.05))
FITTED = Statement("gain", 2.0, float("nan"), within_share(0.05), fitted=True)
DISAGREES = Statement("word", "one", "two", equal())
BESIDE = Statement("charge_C", None, 1e-12, unjudged())


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ((AGREES, replace(FITTED, ours=2.05), BESIDE), ""),
        ((AGREES, FITTED, BESIDE), "noctule: mine: 1 of 3 rows disagree: gain\n"),
        ((AGREES, FITTED, DISAGREES), "noctule: mine: 2 of 3 rows disagree: gain, word\n"),
    ],
)
def test_reproduce(
    rows: tuple[Statement, ...], told: str, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(reproduce, "load_experiment", lambda _: experiment(*rows))
    plot = tmp_path / "mine.pdf"
    found = run("reproduce", "mine", "--json", "--plot", str(plot))
    status = 1 if told else 0
    assert (found[0], found[2]) == (status, told)
    document = json.loads(found[1], parse_constant=pytest.fail)
    assert document["experiment"] == "mine"
    assert document["notes"] == ["a note"]
    judged = [row.agrees for row in rows if row.agrees is not None]
    ours = {"name": "ours", "held": sum(judged), "judged": len(judged), "p": None}
    assert document["scores"][0] == ours
    assert list(document["rows"][0]) == ["name", "paper", "ours", "rule", "tolerance", "fitted", "agrees"]
    assert document["rows"][0]["rule"] == "within 5 %"
    assert document["rows"][0]["tolerance"] == 0.05
    assert [row["agrees"] for row in document["rows"]] == [row.agrees for row in rows]
    assert plot.read_bytes().startswith(b"%PDF")
    table = run("reproduce", "mine")
    assert table[0] == status
    assert "a note" in table[1]
    assert f"Rows that hold: ours {sum(judged)} of {len(judged)}" in table[1]


def test_doctor_names_what_the_distribution_requires() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]

    def names(lines: list[str]) -> set[str]:
        found: set[str] = set()
        for line in lines:
            inner = re.match(r"noctule\[([\w-]+)\]", line)
            found |= names(extras[inner[1]]) if inner else {re.split(r"[^A-Za-z0-9-]", line, maxsplit=1)[0]}
        return found

    assert set(doctor.REQUIRED) == names(project["dependencies"])
    told = {name: set(extra.distributions) for name, extra in doctor.EXTRAS.items()}
    assert told == {name: names(lines) for name, lines in extras.items() if name != "test"}


def test_doctor_names_systems_that_there_are() -> None:
    told = re.findall(r"no run of ([\w, -]+):", " ".join(doctor.REQUIRED.values()))
    assert told
    assert set(re.split(r", | or ", ", ".join(told))) <= set(registry.SYSTEMS)


def test_what_doctor_says_of_pyspice(tmp_path: Path) -> None:
    assert "netlists are read without it" in doctor.REQUIRED["PySpice"]
    path = tmp_path / "deck.cir"
    path.write_text("t\nr1 a 0 1k\nv1 a 0 1\n")
    commands = ["import", str(path)], ["simulate", BLOCK, "--engine", "ngspice"]
    code = (
        "import sys; sys.modules['PySpice'] = None; from system.cli.command_line import main;"
        f"sys.exit(str([main(command) for command in {commands}]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stderr.splitlines()[-1] == "[0, 2]", done.stderr


def test_doctor(run: Run, run_json: RunJson, monkeypatch: pytest.MonkeyPatch) -> None:
    found = run_json("doctor")
    assert found["python"] == ".".join(map(str, sys.version_info[:3]))
    assert found["cores"] >= 1
    assert {f["name"] for f in found["required"]} >= {"numpy", "numba", "PySpice"}
    assert all(f["found"] for f in found["required"])
    monkeypatch.setenv("NGSPICE_LIBRARY_PATH", "/nonexistent")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/proc/nowhere")
    monkeypatch.setenv("NOCTULE_CACHE_DIR", "/proc/nowhere")
    without = run_json("doctor")
    assert without["ngspice"]["library"] is None
    assert without["kernel_cache"]["writable"] is False
    assert without["record_cache"]["writable"] is False
    mends = dict(zip(without["missing"], without["mends"], strict=True))
    told = {line: typed for line, typed in mends.items() if line not in found["missing"]}
    assert len(told) == 3
    for words, typed in (
        ("--engine ngspice", "unset NGSPICE_LIBRARY_PATH"),
        ("kernel cache", "export NUMBA_CACHE_DIR="),
        ("record cache", "export NOCTULE_CACHE_DIR="),
    ):
        assert [line for line, each in told.items() if words in line and each.startswith(typed)]
    text = run("doctor")[1]
    assert all(f"  {line}\n    {typed}\n" in text for line, typed in mends.items())


def missing_but(*found: str) -> Callable[[str], str]:
    def version(name: str) -> str:
        if name not in found:
            raise PackageNotFoundError
        return "1.0"

    return version


def test_doctor_says_how_an_extra_is_installed(run_json: RunJson, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "version", missing_but(*doctor.REQUIRED, "nir", "jupytext"))
    python = shlex.quote(sys.executable)
    for root, there in ((None, "'noctule[{}]'"), (Path("/my sources"), "-e '/my sources[{}]'")):
        monkeypatch.setattr(mend, "checkout", lambda root=root: root)
        monkeypatch.setattr(doctor, "checkout", lambda root=root: root)
        found = {f["name"]: f for f in run_json("doctor")["optional"]}
        assert ("docs" in found) is (root is not None)
        assert (found["nir"]["found"], found["nir"]["mend"]) == ("nir 1.0", None)
        for name in ("nengo", "tutorials"):
            assert found[name]["found"] is None
            assert found[name]["mend"] == f"{python} -m pip install {there.format(name)}"


def test_doctor_tells_of_a_library_that_is_there_but_broken(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def loaded(place: str) -> str:
        if place.startswith("numba:"):
            raise ImportError("Numba needs NumPy 2.0 or less")
        return "1.0"

    monkeypatch.setattr(doctor, "loaded", loaded)
    status, out, err = run("doctor")
    assert (status, err) == (1, "noctule: doctor: required, but missing: numba; install noctule again\n")
    assert "numba: 0." in out
    assert (
        "cannot be imported, ImportError: Numba needs NumPy 2.0 or less; no circuit can be simulated" in out
    )
    assert "-m pip install --upgrade numba\n" in out


@pytest.mark.parametrize("tool", ["apt-get", "dnf", "brew", ""])
def test_who_installs_the_library_of_ngspice(tool: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mend.shutil, "which", lambda name: name if name == tool else None)
    line = mend.install_ngspice()
    assert f"{tool} install libngspice" in line if tool else line.startswith("export NGSPICE_LIBRARY_PATH=")


def test_interrupted(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(listing, "list_command", interrupt)
    assert run("list") == (130, "", "noctule: interrupted\n")


def test_ctrl_c_reaches_a_running_command() -> None:
    # a shell starts what it puts into the background with Ctrl-C ignored
    code = (
        "import signal, sys, time; signal.signal(signal.SIGINT, signal.default_int_handler);"
        "from system.cli import listing; from system.cli.command_line import main;"
        "listing.list_command = lambda *_: (print('ready', flush=True), time.sleep(60));"
        "sys.exit(main(['list']))"
    )
    with process(code=code) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "ready\n"
        child.send_signal(signal.SIGINT)
        _, err = child.communicate()
    assert (child.returncode, err) == (130, "noctule: interrupted\n")


@pytest.mark.parametrize("arguments", [["show", BLOCK, "--json"], ["--help"]])
def test_a_full_stdout_is_one_line(arguments: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        child = process(*arguments, stdout=full)
        _, err = child.communicate()
    assert child.returncode == 2
    assert err == "noctule: output: No space left on device\n"


def test_a_reader_that_goes_away_is_no_news() -> None:
    child = process("--help", stdout=subprocess.PIPE)
    assert child.stdout is not None
    child.stdout.close()
    assert child.stderr is not None
    with child.stderr as stderr:
        assert stderr.read() == ""
    assert child.wait() == 1


def test_a_module_that_is_missing_is_one_line(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "system.cli.show", None)
    status, _, err = run("show", BLOCK)
    assert status == 2
    assert err.startswith("noctule: ")
    assert err.count("\n") == 1
    assert run("doctor")[0] == 0


def test_json_has_no_nan() -> None:
    assert plain({"a": float("nan"), "b": (1.0, float("inf"))}) == {"a": None, "b": [1.0, None]}


def test_the_approach_runs_behaviourally_with_a_box_of_transistors(run: Run, run_json: RunJson) -> None:
    options = ("run", "approach", "--duration", "300ms", "--level", "behavioural", "--die", "1000")
    options += ("--temperature", "20")
    fast = run_json(*options)
    assert (fast["level"], fast["transistors"], fast["die"]) == ("behavioural", [], 1000)
    assert fast["counts"]["solver_steps"] == 0
    assert fast["summary"]["calls"] > 0
    mixed = run_json(*options, "--transistors", "centroid")
    assert mixed["transistors"] == ["centroid"]
    assert mixed["counts"]["solver_steps"] > 0
    status, out, err = run(*options, "--transistors", "wing")
    assert (status, out) == (2, "")
    assert err.startswith(
        "noctule: --transistors: wing, must be chip, centroid, vocalization, hearing or isolation"
    )
    assert err.count("\n") == 1
