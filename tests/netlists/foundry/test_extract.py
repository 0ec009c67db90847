"""Our law on a foundry's silicon: the curves, the fit, and how good the shipped extractions are."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.extraction.fit import distance
from circuits.silicon.process import POLARITIES
from circuits.silicon.process_file import UNREADABLE, foundry_names, foundry_process, process_of
from netlists.foundry import extract as extraction
from netlists.foundry.extract import HELD_OUT_UM, RANGE, curves, extract
from netlists.foundry.process import process_names, read_foundry
from tests.netlists.foundry.test_process import needs

pytestmark = pytest.mark.usefixtures("ngspice_library")


def test_every_foundry_s_process_has_its_extraction() -> None:
    assert foundry_names() == process_names()
    assert not set(UNREADABLE) & set(process_names())
    for name in process_names():
        process = process_of(name)
        assert (process.name, process.cards) == (f"{name}-ekv", name)
        assert process.v_dd == read_foundry(name).v_dd
        assert process.n.size is not None


@pytest.mark.parametrize(("name", "most"), [("gf180mcu", 0.10), ("sky130", 0.20)])
def test_the_shipped_law_is_near_the_cards_at_sizes_that_were_not_fitted(name: str, most: float) -> None:
    mapping, process = needs(read_foundry(name)), foundry_process(name)
    for polarity in POLARITIES:
        points = curves(mapping, polarity, HELD_OUT_UM).between(*RANGE)
        assert len(points) > 1000
        assert distance(process.model(polarity), process, points).median < most


def test_a_small_extraction_fits_what_its_curves_fix(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping = needs(read_foundry("gf180mcu"))
    monkeypatch.setattr(extraction, "TEMPERATURES_C", (27.0,))
    monkeypatch.setattr(extraction, "FITTED_UM", ((2.0, 1.0), (6.0, 3.0)))
    monkeypatch.setattr(extraction, "HELD_OUT_UM", ((3.0, 2.0),))
    found = extract(mapping, "mine")
    assert found.process.name == "mine"
    assert found.process.cards == ""
    for polarity in POLARITIES:
        assert "v_t0_drift" in found.fitted[polarity].free
        assert found.judged(polarity).median < 0.15
        roles = [
            (role, np.round(1e6 * np.array(size), 6).tolist()) for role, size, _ in found.distances(polarity)
        ]
        assert roles == [("fitted", [2.0, 1.0]), ("fitted", [6.0, 3.0]), ("held out", [3.0, 2.0])]
    # one sigma of the foundry's V_T of a long device: 5 and 15 mV (n), 5 and 18 mV (p), and its oxide's
    assert 0.015 < found.process.variation.sigma_v_t0 < 0.03
    assert found.notes[0].startswith("mismatch: one A_VT of ")
