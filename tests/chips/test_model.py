"""Every model in the table, and a user's own, has a record of today's circuits and loads from it."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import pytest

from chips.model import MODELS, Model, characterise, load_model, model_names
from chips.record import Record, current_record, read_record
from circuits.errors import ParameterError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon

EVERY = [load_model(name) for name in MODELS]


@pytest.mark.parametrize("model", EVERY, ids=lambda m: m.name)
def test_a_model_has_the_name_by_which_it_is_loaded(model: Model) -> None:
    assert MODELS[model.name]
    assert all(circuit.name for circuit in model.circuits())


@pytest.mark.parametrize("model", EVERY, ids=lambda m: m.name)
def test_no_record_is_stale_and_every_one_has_errors_on_other_dies(model: Model) -> None:
    record = current_record(model.record_name)
    assert record.errors
    assert not any(math.isnan(value) for value in model.figures(record).values())
    for silicon in (Silicon(AMI_1500_IDEAL), Silicon(AMI_1500_IDEAL, temperature_c=40.0, die=Die(number=3))):
        with warnings.catch_warnings(action="ignore"):  # a die that is deaf says so
            assert model.load(silicon) is not None


@pytest.mark.parametrize("model", EVERY, ids=lambda m: m.name)
def test_a_model_refuses_what_is_outside_its_box(model: Model) -> None:
    with pytest.raises(ParameterError, match="temperature: 200 degC, must be"):
        model.load(Silicon(AMI_1500_IDEAL, temperature_c=200.0))


def test_an_unknown_model_is_told_with_those_that_are_known() -> None:
    with pytest.raises(UnknownNameError, match=r"known are .*rebound-neuron"):
        load_model("dpi-synapse")


def test_a_record_is_judged_while_it_is_in_force() -> None:
    seen: list[object] = []
    measured = Record("k", 1, {}, {})

    def held_out(record: Record, biases: object, process: Process) -> dict[str, float]:
        seen.extend([current_record("my_model", process), biases, process])
        return {"rms_s": 1.0}

    model = Model("my-model", tuple, lambda *_: measured, held_out, lambda _: None)
    shares: list[float] = []
    made = characterise(model, shares.append, {"i_a": 1.0}, AMI_1500)
    assert seen == [measured, {"i_a": 1.0}, AMI_1500]
    assert made.law is not None
    assert made.law.process == replace(AMI_1500, components=None)
    assert (made.key, made.errors, shares) == ("k", {"rms_s": 1.0}, [1.0])


MODULE = """
import numpy as np
from chips.model import Model
from chips.record import Record, Table, content, matching_record, record_key
from circuits.blocks.rolls import dpi_synapse

def circuits():
    return (dpi_synapse.build(),)

def key(record=None):
    return record_key([content(c) for c in circuits()])

def measure(progress, process):
    progress(1.0)
    gain = Table(("temperature",), np.array([1.0, 2.0]))
    return Record(key(), 1, {"temperature": (0.0, 60.0)}, {"gain": gain})

def held_out(record, biases, process):
    return {"gain_max": float(record["gain"].max())}

def load(silicon):
    return matching_record("their_synapse", key)

MODEL = Model("their-synapse", circuits, measure, held_out, load)
"""


def test_a_users_own_model_is_characterised_by_its_entry_point(tmp_path: Path) -> None:
    (tmp_path / "theirs.py").write_text(MODULE)
    (tmp_path / "theirs-1.0.dist-info").mkdir()
    about = tmp_path / "theirs-1.0.dist-info"
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: theirs\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[noctule.models]\ntheir-synapse = theirs:MODEL\n")
    target = tmp_path / "record.nc"
    command = "from system.cli.command_line import main; raise SystemExit(main())"
    done = subprocess.run(
        [sys.executable, "-c", command, "characterise", "their-synapse", "-o", str(target), "--json"],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        check=False,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert (told["block"], told["errors"]) == ("their-synapse", {"gain_max": 2.0})
    assert read_record(target).key == told["key"]


def test_names_are_those_of_the_table_first() -> None:
    assert model_names()[: len(MODELS)] == list(MODELS)
