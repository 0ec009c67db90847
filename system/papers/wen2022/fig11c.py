"""Figure 11C of Wen & Horiuchi 2022: immediacy functions, equation (11), against the normalised distance.

An obstacle is put straight ahead at all distances; its immediacy on the straight arc (gamma = 1) is what the
compiled loop adds to the risk of that arc. It is compared with the equation and with the paper's words: the
control falls linearly from E_MAX = 10 and is 0 at R_MAX = 5 m; "Steep"
(R_MAX0 = 3 m) is 0 from 3 m on, rectified; "Flat" (R_MAX0 = 7 m) still counts an obstacle at 5 m; "Squared"
emphasises close obstacles without ignoring far ones, 10 (1 - r / 5 m)^2. Rules: equation (11) within 1e-9 at
all distances of the figure, and these words.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report, with_progress
from system.openspace.law import ARCS, MIDDLE, Bat, arcs_of
from system.openspace.view import add_immediacies
from system.plot import COLOURS
from system.rule import Measured, above, at_most, exactly
from system.statement import Statement

CONTROL, STEEP, FLAT, SQUARED = "control", "Steep", "Flat", "Squared"
TOLERANCE = 1e-9
_POINTS = 101


def groups(bat: Bat) -> dict[str, Bat]:
    """Give the four bats of Figures 11C and 11D."""
    return {
        CONTROL: bat,
        STEEP: replace(bat, immediacy_range=3.0),
        FLAT: replace(bat, immediacy_range=7.0),
        SQUARED: replace(bat, immediacy="squared"),
    }


def reproduce(progress: Progress) -> Report:
    """Put an obstacle at all distances before each bat."""
    bats = groups(Bat())
    far = np.linspace(0.0, Bat().max_range, _POINTS)
    found = {name: immediacy(bat, far) for name, bat in with_progress(bats.items(), progress)}
    return Report(rows(far, found), lambda figure: _draw(far, found, figure))


def immediacy(bat: Bat, way: F64) -> F64:
    """Give what an obstacle adds to the straight arc, at ways (m) that the bat can fly before it collides."""
    arcs, values = arcs_of(bat), np.zeros(way.size)
    for k, r in enumerate(way):
        risk = np.zeros(ARCS)
        # the last of them lies beyond the arc's end, where its zone of collision still reaches
        add_immediacies(arcs, min(float(r) + bat.zone, bat.max_range), 0.0, risk)
        values[k] = risk[MIDDLE]
    return values


def rows(way: F64, found: Mapping[str, F64]) -> tuple[Statement, ...]:
    """Make the statements about equation (11), and about the paper's words."""
    seen = way <= Bat().max_range - Bat().zone
    laws = {
        CONTROL: 10.0 * (1.0 - way / 5.0),
        STEEP: 10.0 * np.maximum(1.0 - way / 3.0, 0.0),
        FLAT: 10.0 * (1.0 - way / 7.0),
        SQUARED: 10.0 * (1.0 - way / 5.0) ** 2,
    }
    by_law = [
        _row(f"{name}_largest_difference", float(np.abs(found[name] - law)[seen].max()), TOLERANCE)
        for name, law in laws.items()
    ]
    beyond = seen & (way >= 3.0)
    ignored = float(found[STEEP][beyond].max())
    last = np.flatnonzero(seen)[-1]
    counted = min(float(found[name][last]) for name in (FLAT, SQUARED))
    close, distant = _ratio(found, way, 0.5), _ratio(found, way, 4.0)
    shown = f"{close:.3g} of the control at 0.5 m, {distant:.3g} at 4 m"
    return (
        *by_law,
        Statement("steep_beyond_3_m", 0.0, ignored, exactly(0.0, "{limit:g}")),
        Statement("flat_and_squared_at_the_end", "above 0", counted, above(0.0)),
        Statement(
            "squared_emphasises_close",
            "close",
            Measured(close if distant > 0.0 else math.nan, shown),
            above(distant, "a larger part of the control when close"),
        ),
    )


def _row(name: str, value: float, most: float) -> Statement:
    return Statement(name, 0.0, value, at_most(most))


def _ratio(found: Mapping[str, F64], way: F64, at: float) -> float:
    k = int(np.argmin(np.abs(way - at)))
    return float(found[SQUARED][k] / found[CONTROL][k])


def _draw(way: F64, found: Mapping[str, F64], figure: Figure) -> None:
    ax = figure.subplots()
    seen = way <= Bat().max_range - Bat().zone
    for (name, values), colour in zip(found.items(), COLOURS, strict=False):
        ax.plot(way[seen], values[seen], color=colour, label=name)
    ax.set(xlabel="r' / gamma (m)", ylabel="immediacy")
    ax.legend()


EXPERIMENT = Experiment("wen2022-fig11c", "immediacy functions against distance", reproduce)
