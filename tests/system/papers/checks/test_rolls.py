"""Experiments on ROLLS chips, small."""

import numpy as np
from matplotlib.figure import Figure

from system.papers.checks import rolls_calibration, rolls_field, rolls_mapping
from system.study.campaign import Numbered


def test_calibration_of_one_die():
    report = rolls_calibration.reproduce(lambda _: None, dies=1, drifting=0)
    assert [row.name.split(":")[0] for row in report.rows] == ["ideal", "gate"]
    assert all(0.0 <= float(row.shown) <= 1.0 for row in report.rows)
    report.draw(Figure())


def test_drift_is_reported_at_every_temperature():
    drift = np.zeros((3, len(rolls_calibration.TEMPERATURES), 8))
    drift[:, 0] = -0.5
    rows = rolls_calibration.rows({"gate": rolls_calibration.Calibrated(np.zeros((3, 8)), drift, 5)})
    named = {row.name: row.shown for row in rows}
    assert named["gate: mean rate at 17 degC over its target"] == 0.5
    assert len(named) == len(rolls_calibration.TEMPERATURES)


def test_a_field_decides():
    bump = rolls_field.decide(Numbered("ideal", 8))
    # die 8 is one of those on which the numbers were chosen
    assert bump.right
    report_rows = rolls_field.rows({"ideal": [bump]})
    assert report_rows[0].shown == 1.0
    nulls = rolls_field._nulls({"ideal": [bump] * 40})
    assert tuple(nulls) == rolls_field.EXPERIMENT.nulls
    same, coin, nothing = (sum(each.right for each in made["ideal"]) for made in nulls.values())
    assert (same, nothing) == (20, 0)
    assert 10 <= coin <= 30


def test_mapped_networks_are_judged_on_the_nominal_die_by_ten_percent_or_two_hertz() -> None:
    rates = rolls_mapping.Rates(np.array([50.0, 5.0]), np.array([40.0, 1.0]), np.array([43.9, 2.9]))
    found = rolls_mapping.rows(dict.fromkeys(rolls_mapping.CONDITIONS, rates))
    assert [row.ours for row in found] == [1.0, 0.0] * 3  # 12 % and 2.1 Hz off what was asked for
    assert [row.agrees for row in found] == [True, None, None, None, None, None]
    network, events = rolls_mapping.drawn(1001)
    assert (network.neurons, network.channels) == (
        sum(p.size for p in network.populations),
        1 + events.addresses.max(),
    )
