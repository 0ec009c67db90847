"""Immediacies of obstacles against arcs that are sampled densely."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from circuits.arrays import F64
from system.openspace.law import ARCS, Arcs, Bat, arc_point, arcs_of
from system.openspace.view import add_immediacies

BAT = Bat()
STEPS = 40_001  # of an arc that is sampled
NEAR = 1e-6  # m by which sampling and formula may differ about a touch: half a step squared over the radius


def immediacies(arcs: Arcs, bat: Bat, x: float, y: float) -> tuple[F64, F64]:
    """Equation (11) with each arc sampled densely; also how near it comes to (x, y)."""
    risk, nearest = np.zeros(ARCS), np.zeros(ARCS)
    for p in range(ARCS):
        s = np.linspace(0.0, arcs.length[p], STEPS)
        px, py = arc_point(np.full(STEPS, arcs.curvature[p]), s)
        distance = np.hypot(px - x, py - y)
        k = int(np.argmin(distance))
        nearest[p] = distance[k]
        if distance[k] < bat.zone:
            gamma = arcs.length[p] / bat.max_range
            share = max(1.0 - (s[k] - bat.zone) / (bat.immediacy_range * gamma), 0.0)
            risk[p] = bat.max_risk * share ** (2 if bat.immediacy == "squared" else 1)
    return risk, nearest


@settings(max_examples=12, deadline=None)
@given(st.floats(0.31, 6.0), st.floats(-math.pi, math.pi), st.sampled_from(["control", "steep", "squared"]))
def test_immediacies_are_those_of_sampled_arcs(distance: float, bearing: float, form: str) -> None:
    changes: dict[str, dict[str, object]] = {
        "control": {},
        "steep": {"immediacy_range": 3.0},
        "squared": {"immediacy": "squared"},
    }
    bat = replace(BAT, zone=0.3, **changes[form])  # type: ignore[arg-type]
    arcs = arcs_of(bat)
    x, y = distance * math.cos(bearing), distance * math.sin(bearing)
    found = np.zeros(ARCS)
    add_immediacies(arcs, x, y, found)
    expected, nearest = immediacies(arcs, bat, x, y)
    sure = np.abs(nearest - bat.zone) > NEAR
    # a step of the sampling is at most 1.25e-4 m, which is at most 3e-3 of a risk of up to 10.6
    assert np.allclose(found[sure], expected[sure], atol=3e-3)
