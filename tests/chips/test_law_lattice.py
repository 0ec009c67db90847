"""The law at its lattice: it survives its text, what moved is named, and a record of another is refused."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from chips.law_lattice import TOLERANCE, Law, changed, law_from, law_of, law_text
from chips.model import MODELS
from chips.ranging.chip import shipped_model
from chips.record import kept_record, read_record, write_record
from chips.record_file import ENVIRONMENT, shipped_file
from circuits.errors import DataError
from circuits.silicon.process import AMI_1500_IDEAL, ROLLS_180_IDEAL, Process
from system.cli import mend
from system.cli.command_line import main


def moved(law: Law, family: str, share: float) -> Law:
    """The law with every number of a family a share larger."""
    return replace(law, values={**law.values, family: law.values[family] * (1.0 + share)})


@pytest.fixture
def fresh() -> Iterator[None]:
    """Records, laws and the ranging chip's model are forgotten before and after."""
    caches = (law_of, kept_record, shipped_model)
    for each in caches:
        each.cache_clear()
    yield
    for each in caches:
        each.cache_clear()


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, ROLLS_180_IDEAL], ids=lambda p: p.name)
def test_a_law_survives_its_text_and_is_today_s(process: Process) -> None:
    law = law_of(process)
    again = law_from(*law_text(law))
    plain = replace(process, components=None)  # records are measured on dies without them
    assert (again.process, again.solver, changed(again)) == (plain, law.solver, "")
    for name, values in law.values.items():
        assert values.size > 0
        assert np.isfinite(values).all()
        np.testing.assert_array_equal(values, again.values[name])


@pytest.mark.parametrize("family", law_of(AMI_1500_IDEAL).values)
def test_a_family_that_moved_is_named(family: str) -> None:
    law = law_of(AMI_1500_IDEAL)
    assert changed(moved(law, family, 2.0 * TOLERANCE)) == f"another law of {family}"
    assert changed(moved(law, family, 0.1 * TOLERANCE)) == ""


def test_another_solver_and_another_lattice_are_named() -> None:
    law = law_of(AMI_1500_IDEAL)
    assert changed(replace(law, solver=0)) == f"solvers of version 0, not {law.solver}"
    values = {name: v for name, v in law.values.items() if name != "bias"}
    assert changed(replace(law, values=values)) == "another law of bias"
    assert changed(replace(law, values={**law.values, "bias": np.zeros(3)})) == "another law of bias"


@pytest.mark.parametrize("name", MODELS)
def test_every_shipped_record_carries_the_law_of_its_process(name: str) -> None:
    law = read_record(shipped_file(name)).law
    assert law is not None
    assert law.process == replace(AMI_1500_IDEAL, components=None)
    assert changed(law) == ""


@pytest.mark.usefixtures("fresh")
def test_a_stale_law_is_refused_with_its_remedy_before_a_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    record = read_record(shipped_file("rebound_neuron"))
    assert record.law is not None
    stale = replace(record, law=moved(record.law, "capacitance", 1e-6))
    shipped = tmp_path / "shipped.nc"
    write_record(stale, shipped)
    monkeypatch.setattr("chips.record.record_file", lambda *_: shipped)
    said = (
        "rebound_neuron: its record is of another law of capacitance; run noctule characterise rebound-neuron"
    )
    assert main(["run", "approach", "--law", "ideal", "--level", "behavioural", "--duration", "0.1s"]) == 2
    assert capsys.readouterr().err.strip().endswith(f"{said} --update-package")
    monkeypatch.setattr(mend, "checkout", lambda: None)  # an installed package is never changed
    assert main(["run", "approach", "--law", "ideal", "--level", "behavioural", "--duration", "0.1s"]) == 2
    assert capsys.readouterr().err.strip().endswith(said)


@pytest.mark.usefixtures("fresh")
def test_a_record_without_a_law_is_stale(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(ENVIRONMENT, str(tmp_path))
    path = tmp_path / "records" / "latency_chip.nc"
    path.parent.mkdir()
    write_record(replace(read_record(shipped_file("latency_chip")), law=None), path)
    with pytest.raises(
        DataError, match=r"latency_chip\.nc, .* a law that it does not tell; .*, or delete it"
    ):
        kept_record("latency_chip")
