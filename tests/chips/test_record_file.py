"""A record's file follows the process and the law that it was measured in."""

from __future__ import annotations

from dataclasses import replace

import pytest

from chips.model import MODELS
from chips.record import read_record
from chips.record_file import ENVIRONMENT, cached_file, measured_by, record_name, shipped_file, stale
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, ROLLS_180, ROLLS_180_IDEAL, Process

MINE = replace(AMI_1500, name="mine 0.8/um")
CASES: dict[str, tuple[Process, str]] = {
    "lso_neuron": (AMI_1500_IDEAL, "noctule characterise lso-neuron"),
    "lso_neuron_full": (AMI_1500, "noctule characterise lso-neuron law=full"),
    "lso_neuron_rolls-180_ideal": (ROLLS_180_IDEAL, "noctule characterise lso-neuron process=rolls-180"),
    "lso_neuron_mine-0.8-um_full": (MINE, "noctule characterise lso-neuron law=full process=FILE"),
}


@pytest.mark.parametrize("name", CASES)
def test_the_name_and_the_command_are_of_the_process_and_its_law(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ENVIRONMENT, "/none")
    process, command = CASES[name]
    assert record_name("lso-neuron", process) == name
    assert cached_file("lso-neuron", process).name == shipped_file("lso-neuron", process).name == f"{name}.nc"
    assert measured_by("lso_neuron", process) == command
    assert str(stale("lso_neuron", process=process)).endswith(f"of another circuit or process; run {command}")


def test_every_process_and_law_has_a_file_of_its_own() -> None:
    processes = (AMI_1500_IDEAL, AMI_1500, ROLLS_180_IDEAL, ROLLS_180, MINE, MINE.ideal())
    assert len({record_name("a", process) for process in processes}) == len(processes)


@pytest.mark.parametrize("name", MODELS)
def test_a_record_under_the_full_law_is_shipped_with_that_law(name: str) -> None:
    record = read_record(shipped_file(name, AMI_1500))
    assert record.law is not None
    assert record.law.process == replace(AMI_1500, components=None)
    assert record.errors
