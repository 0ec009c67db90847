"""Rows of the sonar head's experiment, from few dies and from made-up errors."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from system.head.run import SUMMARY
from system.papers.cheely2003 import head


def made(error: float, spikes: float = 2.0, spread: float = 0.1) -> dict[str, np.ndarray]:
    dies = len(head.DIES)
    found = {name: np.zeros(dies) for name in SUMMARY}
    found["error_rms_deg"] = error + spread * np.linspace(-1.0, 1.0, dies)
    found["settled_rms_deg"] = found["error_rms_deg"]
    return found | {"spikes_a_ping": np.full(dies, spikes), "pings": np.full(dies, 200.0)}


def cases(**changed: dict[str, np.ndarray]) -> dict[str, dict[str, np.ndarray]]:
    found = {name: made(3.0) for name in head.CASES}
    found |= {"one-ear": made(40.0), "one-ear, one range": made(10.0), "excitation": made(4.0, 20.0)}
    found[f"area {head.AREAS[0]:g}"] = made(8.0)
    return found | changed


def disagreeing(found: dict[str, dict[str, np.ndarray]]) -> set[str]:
    rows = (*head.die_rows(found), *head.wiring_rows(found), *head.silicon_rows(found))
    return {row.name for row in rows if not row.agrees}


def test_dies_that_report_are_not_those_that_tune() -> None:
    assert min(head.DIES) == 1000
    assert len(head.DIES) == 20


def test_rows_agree_by_their_rules_and_not_without() -> None:
    assert disagreeing(cases()) == set()
    assert disagreeing(cases(sine=made(9.0))) >= {"dies_sine_error_deg", "dies_sine_worst_deg"}
    assert disagreeing(cases(**{"one range": made(1.0)})) == {"changing_range_adds_deg"}
    assert disagreeing(cases(excitation=made(3.0, 4.0))) == {
        "excitation_spikes_ratio", "excitation_worst_die_ratio",
    }  # fmt: skip
    assert disagreeing(cases(**{"gate 0": made(5.0)})) == {"gate_temperature_moves_deg"}
    assert disagreeing(cases(**{f"area {head.AREAS[0]:g}": made(3.0)})) == {"area_1/16_adds_deg"}


def test_what_is_to_make_no_difference_is_shown_by_its_interval() -> None:
    dies = np.linspace(-1.0, 1.0, len(head.DIES))
    wide = made(3.0)
    wide["error_rms_deg"] = 3.0 + 6.0 * dies  # a mean that is the same, and not known well enough
    assert disagreeing(cases(**{"one range": wide})) == {"changing_range_adds_deg"}
    near = made(3.0)
    near["error_rms_deg"] = 3.4 + 0.5 * dies
    assert disagreeing(cases(**{"one range": near})) == set()


def test_lost_pings_are_a_share() -> None:
    lost = made(3.0) | {"lost": np.full(len(head.DIES), 10.0)}
    assert disagreeing(cases(sine=lost)) == {"dies_lost_share"}


def test_it_runs_on_few_dies(monkeypatch: pytest.MonkeyPatch) -> None:
    few = {name: {**options, "duration": 0.5} for name, options in head.CASES.items()}
    monkeypatch.setattr(head, "CASES", few)
    seen: list[float] = []
    report = head.reproduce(seen.append, dies=tuple(range(2)))
    assert seen[-1] == 1.0
    assert {row.fitted for row in report.rows if row.name.startswith("nominal")} == {True}
    assert len(report.notes) == len(few) + 1
    assert tuple(null.name for null in report.nulls) == head.EXPERIMENT.nulls
    stands = {row.name: row.agrees for row in report.nulls[0].rows}
    assert not stands["one_ear_error_ratio"]
    assert not stands["excitation_spikes_ratio"]
    report.draw(Figure(layout="constrained"))
