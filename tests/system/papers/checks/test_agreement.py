"""The agreement experiment: its rows say what the comparison found; the picture shows both engines."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from chips.ranging.coupling import Coupling
from circuits.registry import load_block
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from netlists.ngspice import run as ngspice
from netlists.ngspice.agreement import Agreement, compare
from netlists.ngspice.form import scaled_testbench, started
from system.papers.checks import agreement
from system.papers.checks.agreement import COUPLING, Case, compare_block, kept
from tests.agreement.kept import KeptRuns
from tests.system.papers.campaigns import goes_on
from tests.system.papers.conftest import Draw

CASE = Case("high-threshold-neuron", -20.0)


@pytest.fixture(scope="module")
def found(ngspice_runs: KeptRuns | None) -> Agreement:
    with pytest.MonkeyPatch.context() as patch:
        if ngspice_runs is not None:
            patch.setattr(ngspice, "run", ngspice_runs)
        return compare_block(*CASE)


def test_rows_state_what_agrees(found: Agreement) -> None:
    rows = agreement._rows(CASE, kept(found))
    begin = "high_threshold_neuron_at_minus_20_degC"
    assert [row.name for row in rows] == [
        f"{begin}_spike_time_s", f"{begin}_node_rms_V", f"{begin}_operating_point_V",
    ]  # fmt: skip
    assert all(row.agrees and not row.fitted and row.paper is None for row in rows)
    assert rows[0].shown == found.difference.spike_time


def test_nothing_agrees_with_an_unconverged_peer_and_a_missing_spike_is_no_number(found: Agreement) -> None:
    far = replace(found.difference, same_count=False)
    lost = agreement._rows(CASE, kept(replace(found, difference=far)))
    assert lost[0].shown is None
    assert not lost[0].agrees
    assert lost[1].agrees
    assert not any(row.agrees for row in agreement._rows(CASE, kept(replace(found, convergence=far))))


def test_the_note_tells_how_ngspice_converged(found: Agreement) -> None:
    note = agreement._note(CASE, kept(found))
    assert "1 spikes" in note
    assert "ngspice converged at reltol 5e-06" in note
    far = replace(found.convergence, same_count=False)
    assert "not converged" in agreement._note(CASE, kept(replace(found, convergence=far)))


def test_comparisons_and_the_coupling_are_kept(
    found: Agreement, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Runs of which one lacks a spike, and a neuron of the chip that does not fire."""
    lost = replace(found, difference=replace(found.difference, same_count=False, spike_time=math.inf))
    cases = [CASE, CASE._replace(temperature_c=27.0), CASE._replace(temperature_c=85.0), Case(COUPLING, 27.0)]
    monkeypatch.setattr(agreement, "compare_block", lambda _, celsius: lost if celsius > 27.0 else found)
    late = np.array([20e-3, np.nan])
    monkeypatch.setattr(agreement, "measure_coupling", lambda _: Coupling(*[late] * 4))
    report = goes_on(
        lambda execution: agreement.run(lambda _: None, execution, cases[:2]),
        lambda execution: agreement.run(lambda _: None, execution, cases),
        tmp_path,
    )
    assert "high_threshold_neuron_at_85_degC_spike_time_s" in report.disagreeing
    assert len(report.notes) == len(cases)


def test_the_picture_shows_a_node_in_both(found: Agreement, drawn: Callable[[Draw], int]) -> None:
    assert drawn(lambda figure: agreement.draw_beside(found, "spike", figure)) > 10_000


def test_the_chip_s_run_is_its_own_at_27_degrees_and_follows_the_delay_elsewhere() -> None:
    usual = agreement.chip_testbench(Silicon(AMI_1500_IDEAL))
    assert usual.circuit.name == "ranging_chip"
    assert {"chain"} < {i.name for i in usual.circuit.instances}
    assert usual.stop == 45e-3
    # fixed gate voltages: five times as fast at 60 degC
    assert 0.1 < agreement.chip_testbench(Silicon(AMI_1500_IDEAL, temperature_c=60.0)).stop / usual.stop < 0.3


@pytest.mark.usefixtures("found")
def test_a_start_and_trapezoidal_integration_change_nothing() -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=-20.0)
    bench = scaled_testbench(load_block("high-threshold-neuron"), silicon)
    begun = started(bench, silicon)
    assert set(begun.start) > {"spike"}
    assert compare(begun, silicon, reltol=1e-4, points=900, method="trap").agrees
