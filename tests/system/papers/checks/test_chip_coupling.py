"""Rows about the coupling: they agree with the documentation only where the measurement does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from chips.ranging.coupling import Coupling
from system.papers.checks import chip_coupling
from system.papers.checks.chip_coupling import coupling_note, coupling_rows

DOCS = Path(__file__).parents[4] / "docs" / "evidence" / "cheely2003.md"


def coupling(earlier: float = chip_coupling.INHIBITION) -> Coupling:
    """Two neurons; the second has the recorded figures."""
    length = np.array([20e-3, chip_coupling.INHIBITION / chip_coupling.SHARE])
    spike = length + 2e-3
    return Coupling(
        length - [1e-5, earlier], length, spike - [1e-5, chip_coupling.SPIKE], spike,
    )  # fmt: skip


def test_the_recorded_figures_agree() -> None:
    rows = coupling_rows(coupling())
    assert [row.name for row in rows] == [
        "coupling_t_inh_share", "coupling_t_inh_s", "coupling_spike_s", "coupling_fires_in_one_only",
    ]  # fmt: skip
    assert all(row.agrees and not row.fitted for row in rows)
    assert rows[1].shown == pytest.approx(chip_coupling.INHIBITION)


def test_other_figures_do_not() -> None:
    rows = coupling_rows(coupling(earlier=chip_coupling.INHIBITION + 10e-6))
    assert [row.agrees for row in rows] == [False, False, True, True]


def test_a_neuron_that_fires_in_one_only_disagrees() -> None:
    found = coupling()
    found.spike_coupled[0] = np.nan
    row = coupling_rows(found)[-1]
    assert (row.shown, row.agrees) == (1.0, False)


def test_the_note_names_the_worst_neuron() -> None:
    note = coupling_note(coupling())
    assert "most of its length in neuron 1, most in neuron 1" in note
    assert "10, 364 us" in note


def test_the_documentation_has_the_figures() -> None:
    text = DOCS.read_text()
    for figure in (
        f"{100 * chip_coupling.SHARE:.1f} %",
        f"{1e3 * chip_coupling.INHIBITION:.3f} ms",
        f"{1e3 * chip_coupling.SPIKE:.3f} ms",
    ):
        assert figure in text
