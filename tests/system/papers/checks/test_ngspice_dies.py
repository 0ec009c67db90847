"""Dies in ngspice: two of different classes, and what the rows make of a difference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.blocks.sonar.tuning import NeuronClass, Tuning, search, tune, tuning_machine
from netlists.ngspice.tuning import NgspiceTrials, edges_hold
from system.papers.checks import ngspice_dies
from system.papers.checks.ngspice_dies import EDGE, Beside, answer_of, silicon_of
from tests.system.papers.campaigns import goes_on
from tests.system.papers.conftest import Draw

WORKS = Tuning(NeuronClass.WORKS, 5.1e-3, 7.3e-3, 5e-3, 2e-3)
SILENT = Tuning(NeuronClass.NEVER, t_inh=5e-3, t_reb=2e-3)


@pytest.mark.usefixtures("kept_ngspice")
def test_a_die_that_fires_on_the_call_alone_does_so_in_ngspice() -> None:
    neuron, silicon = rebound_neuron.build(), silicon_of(1001)
    solver, peer = tune(tuning_machine(neuron, silicon)), search(NgspiceTrials(neuron, silicon))
    assert solver.outcome is peer.outcome is NeuronClass.CALL_ALONE
    assert peer.t_inh == pytest.approx(solver.t_inh, abs=1e-6)
    assert peer.t_reb == pytest.approx(solver.t_reb, abs=20e-6)


@pytest.mark.usefixtures("kept_ngspice")
def test_the_edges_of_a_die_that_works_are_where_the_solver_has_them() -> None:
    """Fires 20 us within each edge and not 20 us outside, so that no bisection can end elsewhere."""
    neuron, silicon = rebound_neuron.build(), silicon_of(1000)
    solver = tune(tuning_machine(neuron, silicon))
    trials = NgspiceTrials(neuron, silicon)
    assert solver.outcome is NeuronClass.WORKS
    assert edges_hold(trials, solver, EDGE)
    # edges elsewhere are told
    assert not edges_hold(trials, replace(solver, first=solver.first - 2.0 * EDGE), EDGE)
    assert trials.runs <= 8


def one(solver: Tuning, peer: Tuning, *, converged: bool = True) -> Beside:
    return Beside(1000, answer_of(solver), answer_of(peer), 33, converged)


def test_dies_that_work_and_dies_that_do_not_are_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(ngspice_dies, "tuning_machine", lambda _, silicon: silicon)
    monkeypatch.setattr(ngspice_dies, "tune", lambda silicon: SILENT if silicon.die.number % 2 else WORKS)
    monkeypatch.setattr(ngspice_dies, "search", lambda _: WORKS)
    monkeypatch.setattr(ngspice_dies, "NgspiceTrials", lambda *_: SimpleNamespace(runs=5))
    monkeypatch.setattr(ngspice_dies, "edges_hold", lambda *_: True)
    report = goes_on(
        lambda execution: ngspice_dies.run(lambda _: None, execution, dies=2),
        lambda execution: ngspice_dies.run(lambda _: None, execution, dies=4),
        tmp_path,
    )
    assert report.disagreeing == ("die_1001_class", "die_1003_class", "dies_of_the_same_class")
    assert "2 works, 2 never" in report.notes[0]


def test_rows_of_a_die_that_works_in_both() -> None:
    late = replace(WORKS, last=WORKS.last + 15e-6)
    rows = ngspice_dies._rows(one(WORKS, late))
    assert [row.name for row in rows] == ["die_1000_class", "die_1000_edge_s"]
    assert all(row.agrees for row in rows)
    assert rows[1].shown == pytest.approx(15e-6)


def test_rows_that_disagree() -> None:
    far = replace(WORKS, first=WORKS.first - 25e-6)
    assert [row.agrees for row in ngspice_dies._rows(one(WORKS, far))] == [True, False]
    assert [row.agrees for row in ngspice_dies._rows(one(WORKS, WORKS, converged=False))] == [True, False]
    assert [row.agrees for row in ngspice_dies._rows(one(WORKS, SILENT))] == [False]
    failed = Tuning(NeuronClass.FAILED)
    assert [row.agrees for row in ngspice_dies._rows(one(failed, failed))] == [False]


def test_the_summary_counts_classes_and_takes_the_worst_edge() -> None:
    late = replace(WORKS, last=WORKS.last + 15e-6)
    same, worst = ngspice_dies._summary([one(WORKS, late), one(WORKS, WORKS), one(SILENT, SILENT)])
    assert (same.shown, same.agrees) == (3.0, True)
    assert worst.shown == pytest.approx(15e-6)
    same, worst = ngspice_dies._summary([one(WORKS, SILENT)])
    assert (same.agrees, worst.shown, worst.agrees) == (False, None, False)


def test_the_picture_shows_what_does_not_work_too(drawn: Callable[[Draw], int]) -> None:
    found = [one(WORKS, WORKS), replace(one(SILENT, SILENT), die=1001)]
    assert drawn(lambda figure: ngspice_dies.draw(found, figure)) > 5_000
    assert "1 works, 1 never" in ngspice_dies._note(found)
