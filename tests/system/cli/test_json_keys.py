"""Every key of every `--json` document is told on the page of JSON: its type, its unit, and words.

A small form of each command is run, and its document is held against what the code tells of its keys. The
cheap ones are run always, all of them by `pytest tests/system/cli/test_json_keys.py --documents=all`.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from system.bench import answers
from system.cli.command_line import app, main
from system.cli.keys.documents import DOCUMENTS, run_keys
from system.meaning import Meaning
from system.registry import load_system, system_names
from system.view.kept import keep
from tests.circuits.extraction.test_fit import points, table
from tests.documents import ROOT
from tests.json_document import wrong
from tests.system.cli.test_blame import TOY
from tests.system.view.films import film

FORMS = {
    "list": ["list"],
    "show BLOCK": ["show rebound-neuron"],
    "show CHIP": ["show nef-chip"],
    "show rolls": [],
    "op": ["op rebound-neuron"],
    "simulate": ["simulate rebound-neuron"],
    "simulate --analysis dc": ["simulate sweep.cir --analysis dc"],
    "simulate --analysis ac": ["simulate rebound-neuron --analysis ac --source v_rest --points 1"],
    "simulate --analysis noise": ["simulate rebound-neuron --analysis noise --node v_mem --source v_rest"],
    "simulate --analysis tran-noise": [],
    "sweep": [
        "sweep rebound-neuron --over v_rest=1V,2V --over corner=ss,ff --measure max(v_mem) --node v_mem",
        "sweep rebound-neuron --over die=1000,1001 --measure t=cross(spike,9V) --analysis tran",
    ],
    "view": ["view run.nc -o run.html"],
    "map": [],
    "map --chip nef": [],
    "show PROGRAM.toml (nef)": [],
    "run PROGRAM.toml (nef)": [],
    "show PROGRAM.toml": [],
    "run PROGRAM.toml": [],
    "export": [
        "export rebound-neuron -o a.cir",
        "export rebound-neuron --param membrane_capacitance=700fF -o b.cir",
        "export rebound-neuron -o -",
    ],
    "export rolls": ["export rolls --at row[5] --program synapses.csv -o row.cir"],
    "import": ["import a.cir"],
    "compare": ["compare a.cir b.cir"],
    "montecarlo": ["montecarlo rebound-neuron --samples 2 -o study"],
    "montecarlo --rare": [],
    "gradient": ["gradient rebound-neuron --metric spike_time(spike,0)"],
    "match": ["match rebound-neuron --metric t_inh_s --no-process-variation --spread 5%"],
    "worst": [],
    "corners": [],
    "mission": [
        "mission car --param pings=3 --dies 1 --worlds 1 --chunk 1 --change codes=default -o mission"
    ],
    "certify": [],
    "train": [],
    "merge": ["merge mission -o merged"],
    "replay": ["replay study --die 1000"],
    "centre": [],
    "size": [],
    "blame SYSTEM": [f"blame {TOY} --die 1003"],
    "characterise": [],
    "extract": ["extract --points currents.csv -o process.toml"],
    "extract --fit": ["extract --fit coach --only fet_n_sub_vg --only fet_n_backgate -o process.toml"],
    "identify": ["identify --fit coach --only ndp_run1 --process rolls-180 -o die.toml"],
    "predict": ["predict coach --only ndp_run2 --process rolls-180 --die die.toml --draws 2 -o predicted"],
    "calibrate": [],
    "reproduce": ["reproduce cheely2003-fig4"],
    "labs": ["labs --students 1 -o class", "labs --check class/answers/1000.toml"],
    "serve": ["serve loopback --port 0 --duration 10ms"],
    "new": ["new block my-sink"],
    "doctor": ["doctor"],
    "run bench": ["run bench pair.toml"],
    "run approach": [],
    "run rover": ["run rover"],
    "run forest": ["run forest --pings 5"],
    "run spiking-bat": [],
    "run car": ["run car --pings 5", "run car --pings 5 --ranges chip"],
    "run head": ["run head --duration 0.5s"],
    "run bug": ["run bug --duration 0.1s --neurons 500"],
    "run pushbot": [],
    "run rolls": ["run rolls --duration 0.2s"],
}
MORE = {
    "map": ["map net.toml --chip rolls -o p.toml"],
    "show PROGRAM.toml": ["show p.toml"],
    "run PROGRAM.toml": ["run p.toml --input in.csv --codes default --duration 0.2s"],
    "map --chip nef": ["map values.toml --chip nef -o v.toml"],
    "show PROGRAM.toml (nef)": ["show v.toml"],
    "run PROGRAM.toml (nef)": ["run v.toml --input values.csv --codes default --duration 0.2s"],
    "show rolls": ["show rolls"],
    "simulate --analysis tran-noise": ["simulate rebound-neuron --analysis tran-noise --trials 2"],
    "montecarlo": [
        "montecarlo rebound-neuron --samples 40 --metric best_delay --contributions best_delay",
        "montecarlo rebound-neuron --samples 2 --spec 'class is works' --temperature 27 --temperature 40",
        "montecarlo rolls --samples 2",
    ],
    "certify": ["certify p.toml --task task.npz --dies 2 --change area=4 --bits 2,4"],
    "train": ["train sides.toml --task sides.npz --dies 1 --steps 2 -o trained.toml"],
    "montecarlo --rare": [
        "montecarlo rebound-neuron --samples 400 --rare scaled-sigma --spec 'class is works'"
    ],
    "match": ["match rebound-neuron --metric t_inh_s --spread 9ms --check 10"],
    "worst": ['worst rebound-neuron --spec "t_inh_s in :8ms" --no-process-variation --check 200 -o worst'],
    "corners": ["corners rebound-neuron --metric t_inh_s --no-process-variation -o corners"],
    "centre": [
        "centre rebound-neuron --spec 'class is works' --tuning-dies 2 --fresh-dies 2 --generations 0"
    ],
    "size": ["size differential-pair --spec 'offset_V in -5mV:5mV' --move-param pair_width --fresh-dies 4"],
    "characterise": ["characterise winner-take-all -o record.nc"],
    "extract": ["extract --process gf180mcu -o process.toml"],
    "calibrate": ["calibrate latency-chip --die 1003"],
    "run approach": ["run approach --level behavioural --duration 0.3s", "run approach --duration 0.1s"],
    "run rover": ["run rover --cells chip --trips 2 --learn 0.5"],
    "run forest": ["run forest --pings 5 --ranges chip --selection chip"],
    "run spiking-bat": ["run spiking-bat --pings 3", "run spiking-bat --pings 3 --brain chip"],
    "run car": ["run car --pings 5 --ranges exact"],
    "run bug": ["run bug --brain ideal --duration 0.05s", "run bug --brain chip --duration 0.05s"],
    "run pushbot": ["run pushbot"],
}  # which take seconds to minutes
SIDES = """population = [{name = "a", size = 2}]
input = [{name = "in", size = 2}]
probe = [{name = "is a", population = "a"}]
connection = [{from = "in", to = "a", rule = "matrix", matrix = [[0.6, 0.3], [0.4, -0.2]]}]
"""
UNITS = {"C": "degC", "V2_per_Hz": "V^2/Hz", "m_per_s": "m/s", "per_V": "1/V", "per_m": "1/m"}
OTHERS = {
    "weights.charge_C": "C",
    "runs.referred_per_Hz": "",
}  # charge, and a unit that a key beside it tells
ENDS = re.compile(r"_(s|m|cm|Hz|V|A|S|W|mW|J|rad|deg|C|m_per_s|per_V|per_m|V2_per_Hz)$")


def meanings_of(form: str) -> Mapping[str, Meaning]:
    """What the keys of a form's document mean."""
    if form in DOCUMENTS:
        return DOCUMENTS[form]
    return run_keys(load_system(form.removeprefix("run ")))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """All forms, or the cheap ones."""
    if "line" in metafunc.fixturenames:
        found = dict(FORMS)
        if metafunc.config.getoption("documents") == "all":
            found = {form: [*lines, *MORE.get(form, [])] for form, lines in FORMS.items()}
        metafunc.parametrize(("form", "line"), [(f, line) for f, lines in found.items() for line in lines])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which one command reads what another wrote."""
    found = tmp_path_factory.mktemp("forms")
    (found / "sweep.cir").write_text("t\nv1 a 0 1\nr1 a b 1k\nr2 b 0 1k\n.dc v1 0 1 1\n", encoding="utf-8")
    (found / "synapses.csv").write_text("post,pre,level\n5,3,1\n", encoding="utf-8")
    (found / "pair.toml").write_bytes((ROOT / "examples" / "pair.toml").read_bytes())
    (found / "net.toml").write_bytes((ROOT / "examples" / "winner-take-all.toml").read_bytes())
    for name, example in (("values.toml", "square-of-a-value.toml"), ("values.csv", "values.csv")):
        (found / name).write_bytes((ROOT / "examples" / example).read_bytes())
    (found / "in.csv").write_text("time_s,address\n0.01,0\n", encoding="utf-8")
    np.savez(found / "task.npz", inputs=np.full((2, 64), 200.0), labels=[0, 1])
    (found / "sides.toml").write_text(SIDES, encoding="utf-8")
    np.savez(found / "sides.npz", inputs=[[400.0, 300.0]], labels=[0])
    keep(str(found / "run.nc"), film())
    table(points(sizes=((2.0, 1.0),), celsius=(27.0,)), found / "currents.csv")
    return found


def test_every_key_of_a_document_is_told(
    form: str, line: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.setattr(answers, "READINGS", 2)  # of each number of a die of the labs, the fewest there are
    assert main([*shlex.split(line), "--json"]) in {0, 1}
    document = json.loads(capsys.readouterr().out)
    assert document
    assert wrong(document, meanings_of(form)) == []


def test_every_command_and_system_has_words_and_a_table_on_the_page() -> None:
    assert set(FORMS) == {*DOCUMENTS, *(f"run {name}" for name in system_names())}
    assert {form for form in FORMS if not FORMS[form] and form not in MORE} == set()
    verbs = {command.name for command in app().registered_commands}
    assert verbs <= {form.split()[0] for form in FORMS}
    page = (ROOT / "docs" / "reference" / "json.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^```\{document-keys\} (.*)$", page, re.MULTILINE)) == sorted(DOCUMENTS)
    for directive in ("run-keys", "scenario-keys"):
        assert set(re.findall(rf"^```\{{{directive}\}} (.*)$", page, re.MULTILINE)) == set(system_names())


@pytest.mark.parametrize("form", sorted(FORMS))
def test_words_are_there_and_a_unit_is_that_of_the_name(form: str) -> None:
    found = meanings_of(form)
    assert [key for key, each in found.items() if not each.words] == []
    ends = {key: ENDS.search(key.removesuffix(".*")) for key in found}
    units = {key: UNITS.get(end[1], end[1]) for key, end in ends.items() if end is not None} | OTHERS
    numbers = {key: each.unit for key, each in found.items() if key in units and "object" not in each.kind}
    assert numbers == {key: units[key] for key in numbers}
