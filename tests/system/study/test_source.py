"""A study of a user's file keeps its hash and a copy; code runs again only where the user names it."""

import json
import shutil
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Resistor, Source, Transistor
from circuits.devices.source import Constant
from circuits.errors import CircuitError
from circuits.testbench import Testbench
from system.cli.command_line import main
from system.options.silicon import SiliconChoice
from system.study.engine import on_threads, run_study
from system.study.manifest import FILE, Study, read_study
from system.study.plan import Plan
from system.study.replay import die_of
from system.study.table import Condition
from system.study.target import Subject, open_target
from tests.refusals import command_refusals
from tests.system.options.mine import FOLLOWER

MARK = "\nfrom pathlib import Path\nPath('ran').write_text('')\n"
DECK = "an rc\nr1 a b 1k\nc1 b 0 1p\nv1 a 0 1\n.tran 1n 1u\n.end\n"


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a user's file and its study."""
    there = tmp_path_factory.mktemp("measured")
    words = "montecarlo mine.py:follower --samples 2 --param w=5um --threads 1 --output study"
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(StringIO()) as out:
        patch.chdir(there)
        Path("mine.py").write_text(FOLLOWER)
        assert main(words.split()) == 0
    assert "v_out_last_V" in out.getvalue()
    return there


@pytest.fixture
def folder(measured: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A study in a copy of its folder, which is where commands run."""
    shutil.copytree(measured, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "study"


def test_the_copy_is_to_be_read(folder: Path) -> None:
    assert (folder / "source" / "mine.py.txt").read_text() == FOLLOWER


def test_the_named_code_measures_the_same(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("mine.py").rename("moved.py")
    assert main(["replay", "study", "--die", "1001", "--code", "moved.py:follower", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["identical"]
    assert not document["code_changed"]


def test_changed_code_is_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("mine.py").write_text(FOLLOWER.replace("Capacitor", "Capacitor") + "\n# another line\n")
    words = ["replay", "study", "--die", "1001", "--code", "mine.py:follower", "--json"]
    assert main(words) == 2
    assert "add --changed" in capsys.readouterr().err
    assert main([*words, "--changed"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["code_changed"]
    assert "mine.py:follower has changed since study was measured" in said.err
    words = "montecarlo mine.py:follower --samples 2 --param w=5um --threads 1 --output study --resume"
    assert main(words.split()) == 2
    assert "study has subject.code" in capsys.readouterr().err


def test_no_code_of_a_manifest_is_run(folder: Path) -> None:
    Path("mine.py").write_text(FOLLOWER + MARK)
    document = json.loads((folder / FILE).read_text())
    for change in ({}, {"target": "rebound-neuron", "silicon": {"at": "mine.py:pair/cell[1]"}}):
        subject = document["subject"] | {
            **change,
            "silicon": {**document["subject"]["silicon"]} | change.get("silicon", {}),
        }
        (folder / FILE).write_text(
            json.dumps(document | {"subject": subject, "plan": {**document["plan"], "method": "lhs"}})
        )
        for attempt in (lambda: read_study(folder), lambda: die_of(folder, 1000)):
            with pytest.raises(CircuitError, match="code that no file loads"):
                attempt()
    assert not Path("ran").exists()


def test_a_netlist_is_data_whose_copy_is_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rc.cir").write_text(DECK)
    words = "montecarlo rc.cir --variation full --samples 2 --threads 1 --output study"
    assert main(words.split()) == 0
    Path("rc.cir").unlink()
    capsys.readouterr()
    assert main(["replay", "study", "--die", "1001", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["identical"]


test_code_that_is_not_the_study_s_is_refused = command_refusals(
    "replay", "study", "--die", "1000",
    rows=[
        ("", "was measured with mine.py:follower, code that no file loads; add --code mine.py:follower"),
        ("--code mine.py:integrator", "add --code mine.py:follower"),
        ("--code gone.py:follower", "gone.py: No such file"),
    ],
)  # fmt: skip


@pytest.fixture(autouse=True)
def _in_a_folder_with_a_study(request: pytest.FixtureRequest) -> None:
    if "arguments" in request.fixturenames:
        request.getfixturevalue("folder")


def test_an_object_is_studied_without_a_folder(tmp_path: Path) -> None:
    diode = Transistor("m", "n", "v", "v", "0", "0", 6e-6, 3e-6)
    circuit = Circuit("diode", (Port("a", "supply"),), (Resistor("r", "a", "v", 1e6), diode))
    bench = Testbench("diode", circuit, (Source("a", "a", Constant(5.0)),), 1e-6)
    subject = Subject(bench, ("v_last_V",), silicon=SiliconChoice())
    study = Study(subject, Plan("random", 0, 1000, 3), (Condition("random", 27.0, 0),), 2)
    assert open_target(subject) is open_target(subject)
    with on_threads(1) as workers:
        values = run_study(study, workers=workers).table.values
        assert values == pytest.approx(0.9, abs=0.2)
        assert len(set(values.ravel())) == 3
        with pytest.raises(CircuitError, match="target: of type Testbench, which a manifest cannot have"):
            run_study(study, tmp_path / "study", workers=workers)
    assert not (tmp_path / "study").exists()


def test_a_metric_is_a_function_of_a_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "from circuits.solver.operating_point import operating_point\n\n\n"
    Path("mine_metric.py").write_text(
        text + "def rest(machine):\n    return operating_point(machine)['v_out']\n"
    )
    words = "montecarlo mine.py:follower --samples 2 --threads 1 --metric mine_metric.py:rest --json"
    assert main(words.split()) == 0
    assert "rest" in capsys.readouterr().out
