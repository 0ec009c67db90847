"""What a fuzz case damages and reads: one `Input` a kind of document, with its seeds and its reader.

Commands are a word a line; what computes for long in them, a system's run and a study's dies, is left out.
"""

from __future__ import annotations

import contextlib
import io
import json
import shutil
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import xarray as xr

from _damage import COMMON, Damage
from _fuzz_netlist import DAMAGE, make_root, netlist_seeds, read_deck
from chips.ranging.record import rebound_record
from chips.record import read_record
from chips.rolls.program.bias_file import default_biases, format_biases, read_biases
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit
from circuits.errors import DataError, ParameterError
from circuits.seal import sealed
from circuits.silicon.process import AMI_1500_IDEAL, at_temperature
from circuits.units import parse_quantity
from netlists.foundry.process import read_mapping
from netlists.parasitics import read_parasitics
from system.bug import map as bug_map
from system.car import world as robot_forest
from system.cli import montecarlo, run
from system.cli.command_line import BAD_INPUT, main
from system.cli.rolls_program_file import read_program
from system.cli.study_verbs import Montecarlo
from system.openspace import map as forest_map
from system.options.temperature import read_course
from system.registry import load_system
from system.rover import cost_map
from system.study.campaign import Campaign, Execution, Numbered
from system.study.campaign_file import CutLine
from system.study.manifest import read_study
from system.study.replay import die_of, study_table
from system.study.specification import parse_spec
from system.study.target import Subject, open_target
from system.system import System
from system.worlds.arena.file import load_scene
from system.worlds.camera.file import read_events, write_events
from system.worlds.camera.sensor import Events
from system.worlds.sound.targets import read_targets

ROOT = Path(__file__).resolve().parents[1]
SECONDS, MEGABYTES = 10.0, 1000.0
LONGEST_WORD, MOST_WORDS = 100_000, 200  # of a command; Linux takes words of 128 KiB, 2 MiB in all


@dataclass(frozen=True, slots=True)
class Input:
    """A kind of document: the file it is in, its seeds, and what reads it.

    begin(folder) puts there what is needed beside the document and gives the seeds; read(path) raises a
    `CircuitError` for what it refuses. seconds, megabytes: what reading it may take at most.
    """

    name: str
    file: str
    begin: Callable[[Path], Sequence[bytes]]
    read: Callable[[Path], object]
    damage: Mapping[str, tuple[Damage, float]] = field(default_factory=lambda: COMMON)
    seconds: float = SECONDS
    megabytes: float = MEGABYTES


def _files(*patterns: str) -> Callable[[Path], list[bytes]]:
    """Seeds that are files of the repository."""
    return lambda _: [path.read_bytes() for pattern in patterns for path in sorted(ROOT.glob(pattern))]


def _texts(*texts: str) -> Callable[[Path], list[bytes]]:
    """Seeds that are written here."""
    return lambda _: [text.encode() for text in texts]


def _decks(folder: Path) -> list[bytes]:
    make_root(folder)
    return netlist_seeds()


COMMANDS = (
    "show rebound-neuron --bias i_inh_tau=40.1pA --param membrane_capacitance=600fF --temperature 60",
    "show rebound-neuron --bias-set burst --die 1003 --at ranging-chip/neuron[2] --corner ss",
    "show ranging-chip --lot B --die 7 --no-mismatch --bias-kind ideal",
    "montecarlo rebound-neuron --metric t_inh --samples 20 --temperature 0 --corner ff --chunk 4",
    "montecarlo rebound-neuron --until 2% --seed 3 --trials 1 --first-die 5 --stimulus delay=6.4ms",
    "montecarlo pushbot --metric collided --param scene=pair --param duration=2s --trials 2",
    "montecarlo forest --param obstacles=1000 --param vmax=1.5m/s --param pings=20",
    "run approach --amplitude-law d4 --noise 5mV --seed 3 --duration 2s --temperature 20",
    "run rover --map map2 --start 2,10 --goal 19,10 --learn 0.5 --prior 1 --trips 3 --cells chip",
    "run forest --obstacles 1000 --vmax 1.5m/s --pings 20 --start 3m,4m --azimuth-noise 1deg --area 2",
    "run bug --agent bug2 --brain chip --design improved --start 0 --goal 1,2 --neurons 800",
    "run head --motion sine --gain 1.5deg --ping-rate 10Hz --azimuth 40deg --period 10s --swing 0.4m",
    "run car --forest dense --vmax 1m/s --ping-rate 12Hz --pings 20",
    "run pushbot --scene pair --window 500ms --drop 0.8 --light 500lux --way 2m --duration 5s",
)


# Commands that are short as they stand, for a process each.
BY_HAND = (
    *COMMANDS[:3],
    "montecarlo rebound-neuron --metric t_inh -n 2 --temperature 0 --corner ff --chunk 4",
    "run approach --level behavioural --amplitude-law d4 --noise 5mV --seed 3 --duration 0.2s",
    "run forest --obstacles 1000 --vmax 1.5m/s --pings 5 --start 3m,4m",
    "run car --forest dense --vmax 1m/s --pings 3",
)


def _by_hand(_: Path) -> list[bytes]:
    return ["\n".join(text.split()).encode() for text in BY_HAND]


def _commands(_: Path) -> list[bytes]:
    return ["\n".join(text.split()).encode() for text in COMMANDS]


@contextlib.contextmanager
def _without_work() -> Iterator[None]:
    """Leave out what commands compute once they have read what they are told: dies and runs."""
    with contextlib.ExitStack() as stack:
        stack.enter_context(patch.object(montecarlo, "measure", _prepare))
        stack.enter_context(patch.object(run, "load_system", _idle))
        yield


def _prepare(asked: Montecarlo, subject: Subject) -> int:
    montecarlo.prepare(asked, subject)
    return 0


def _idle(name: str) -> System[Any, Any]:
    """A robot whose runs are left out."""
    return replace(load_system(name), run=_no_run)


def _no_run(*_: object, **__: object) -> None:
    raise ParameterError("run: left out")


def command_words(document: bytes) -> list[str]:
    """Words of a damaged command; what is not one of those below is made a `show`, which computes nothing."""
    words = document.decode(errors="surrogateescape").replace("\0", "").split("\n")
    words = [word[:LONGEST_WORD] for word in words if word][:MOST_WORDS]
    return words if words and words[0] in {"show", "montecarlo", "run"} else ["show", *words]


def _read_command(path: Path) -> None:
    said, err = io.StringIO(), io.StringIO()
    with _without_work(), contextlib.redirect_stdout(said), contextlib.redirect_stderr(err):
        status = main(command_words(path.read_bytes()))
    lines = err.getvalue().splitlines()
    if status == BAD_INPUT and len(lines) == 1:
        raise DataError(lines[0])
    if status != 0:
        raise RuntimeError(f"status {status}: {err.getvalue()[:300]!r}")


QUANTITIES = ("600fF", "12ms", "199.9pA", "1MHz", "-40.5degC", "3.3kOhm", "1.5m/s", "0x10V", "1e-12F", "")
UNITS = ("F", "s", "A", "Hz", "degC", "Ohm", "m/s", "V", "", "m")


def _read_quantity(path: Path) -> None:
    text = path.read_bytes().decode(errors="surrogateescape")
    refused = 0
    for unit in UNITS:
        try:
            parse_quantity(text, unit, "x")
        except ParameterError:
            refused += 1
    if refused == len(UNITS):
        raise DataError("no quantity")


def _read_spec(path: Path) -> None:
    text = path.read_bytes().decode(errors="surrogateescape")
    parse_spec(text, {"best_delay": "s", "width": "s", "spikes": ""}, ("works", "never"))


def _study(folder: Path) -> list[bytes]:
    with contextlib.redirect_stdout(io.StringIO()):
        own = ["montecarlo", "rebound-neuron", "-n", "2", "--metric", "t_inh", "-o", str(folder / "made")]
        if main(own) != 0:
            raise RuntimeError("the study that cases damage cannot be made")
    shutil.copytree(folder / "made", folder / "study")
    return [(folder / "made" / "study.json").read_bytes()]


def _read_study(path: Path) -> None:
    study = read_study(path.parent)
    open_target(study.subject)
    die_of(path.parent, 1000)


def _samples(folder: Path) -> list[bytes]:
    _study(folder)
    return [(folder / "made" / "samples.nc").read_bytes()]


def _read_samples(path: Path) -> None:
    study_table(path.parent)


def _columns(folder: Path) -> list[bytes]:
    """Columns and attributes of a study's samples as JSON."""
    with xr.open_dataset(io.BytesIO(_samples(folder)[0]), engine="h5netcdf") as data:
        columns = {name: data[name].values.tolist() for name in data}
        told = {name: np.asarray(value).tolist() for name, value in data.attrs.items()}
    return [json.dumps({"columns": columns, "attributes": told}).encode()]


VALUES = {name: COMMON[name] for name in ("spliced words", "swapped words", "numbers")}


def _read_columns(path: Path) -> None:
    """Samples in a file that is whole and sealed, with other columns."""
    try:
        document = json.loads(path.read_bytes())
        data = xr.Dataset({k: (f"of {k}", np.array(v)) for k, v in document["columns"].items()})
        made = sealed(data.assign_attrs(document["attributes"]).to_netcdf(engine="h5netcdf"))
    except Exception as error:  # no such file can be made: there is nothing to read
        raise DataError("no file") from error
    path.with_name("samples.nc").write_bytes(made)
    _read_samples(path)


def _read_record(path: Path) -> None:
    """A record that was sealed as it is: unsealed ones are refused unread."""
    path.write_bytes(sealed(path.read_bytes()))
    rebound_record(read_record(path))


KEYS = [Numbered("forest", 1000), Numbered("die", 3)]


def _run_again(key: Numbered) -> dict[str, Any]:
    return {"crossings": key[1], "why": key[0]}


RUNS = Campaign("fuzz", _run_again, Numbered, dict[str, Any], (1.5,))


def _campaign(folder: Path) -> list[bytes]:
    path = folder / "seed.jsonl"
    list(Execution(path).results(RUNS, KEYS))
    return [path.read_bytes()]


def _read_campaign(path: Path) -> None:
    with warnings.catch_warnings(action="ignore", category=CutLine):  # said, and made again
        list(Execution(path, resume=True).results(RUNS, KEYS))


EVENTS = Events(np.array([1e-3, 2e-3]), np.array([3, 4]), np.array([5, 6]), np.array([True, False]))


def _events(suffix: str) -> Callable[[Path], list[bytes]]:
    """Events as `write_events` writes them."""

    def begin(folder: Path) -> list[bytes]:
        path = folder / f"seed.{suffix}"
        write_events(str(path), EVENTS)
        return [path.read_bytes()]

    return begin


@lru_cache
def _neuron() -> Circuit:
    return rebound_neuron.build()


def _read_process(path: Path) -> None:
    """A process with other values, a name and a number a line."""
    n, whole = AMI_1500_IDEAL.n, AMI_1500_IDEAL
    for line in path.read_bytes().decode(errors="surrogateescape").splitlines():
        name, _, text = line.partition(" ")
        value = parse_quantity(text, "", name)
        if hasattr(n, name) and name != "law":
            n = replace(n, **{name: value})
        elif name in {"v_dd", "pair_a_vt", "pair_a_beta"}:
            whole = replace(whole, **{name: value})
        else:
            raise DataError(f"{name}: unknown")
    at_temperature(n, whole, 60.0)


BIASES = default_biases()
SPECS = ("best_delay in 5.9ms:6.8ms", "class is works|never", "width in 1ms:")
COURSES = ("0s:27,60s:44", "27", "-40:1")
PLACES = ("x_m,y_m\n1,2\n3.5,1e0\n\n5,6\n",)
TARGETS = ("target,time_s,range_m,strength\na,0,4,1\na,1,3.5,1\nb,0,2,2\n",)
PROGRAMS = ("post,pre,level\n5,17,4\n6,17,-3\n", "5,17,4\ndepression,7,27\n")
LAYOUTS = ("node,capacitance\nv_mem,12fF\nmembrane.v_r,0.5fF\n# x\n",)
PROCESSES = (
    "v_t0 0.6\nkappa 0.7\nmu_cox 72u\nv_dd 5\n",
    "early 0.02\nv_t0_drift -1m\nleakage_doubling 9\npair_a_vt 28n\n",
)

ALL = (
    Input("netlist", "root/deck.cir", _decks, read_deck, DAMAGE, 2.0),
    Input("command", "words", _commands, _read_command),
    Input("command line", "words", _by_hand, _read_command),
    Input("quantity", "text", _texts(*QUANTITIES), _read_quantity),
    Input("specification", "text", _texts(*SPECS), _read_spec),
    Input("course", "text", _texts(*COURSES), lambda p: read_course(p.read_text(errors="surrogateescape"))),
    Input("study", "study/study.json", _study, _read_study),
    Input("samples", "study/samples.nc", _samples, _read_samples),
    Input("columns", "study/columns.json", _columns, _read_columns, VALUES),
    Input("campaign", "runs.jsonl", _campaign, _read_campaign),
    Input("cost map", "map.txt", _files("system/rover/maps/map*.txt"), lambda p: cost_map.load_map(str(p))),
    Input("bug map", "map.txt", _files("system/bug/maps/*.txt"), lambda p: bug_map.load_map(str(p))),
    Input("forest", "map.csv", _texts(*PLACES), lambda p: forest_map.read_forest(str(p))),
    Input("pipes", "map.csv", _texts(*PLACES), lambda p: robot_forest.read_pipes(str(p))),
    Input("scene", "scene.toml", _files("system/worlds/arena/scenes/*.toml"), lambda p: load_scene(str(p))),
    Input("targets", "targets.csv", _texts(*TARGETS), read_targets),
    Input("events", "events.txt", _events("txt"), lambda p: read_events(str(p))),
    Input("packed events", "events.npz", _events("npz"), lambda p: read_events(str(p))),
    Input("ROLLS biases", "biases.csv", lambda _: [format_biases(BIASES).encode()], read_biases),
    Input("ROLLS program", "program.csv", _texts(*PROGRAMS), lambda p: read_program(str(p), BIASES)),
    Input("parasitics", "layout.csv", _texts(*LAYOUTS), lambda p: read_parasitics(p, _neuron())),
    Input(
        "mapping", "mapping.toml", _files("netlists/foundry/processes/*.toml"), lambda p: read_mapping(str(p))
    ),
    Input("process", "values", _texts(*PROCESSES), _read_process),
    Input("record", "record.nc", _files("chips/records/rebound_neuron.nc"), _read_record),
)
INPUTS = {each.name: each for each in ALL}
