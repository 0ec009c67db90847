"""The fit finds the numbers of the law that made the points, says how sure it is, and leaves the rest."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.errors import DataError, ParameterError
from circuits.extraction.extraction import extract_from, rounded
from circuits.extraction.fit import distance, fit, law_current, terms_for
from circuits.extraction.measured import COLUMNS, read_points
from circuits.extraction.points import Points, joined
from circuits.silicon.process import ROLLS_180
from circuits.silicon.size import SizeTerms

UM = 1e-6
SIZES = tuple(itertools.product((1.0, 2.0, 8.0), (0.5, 1.0, 4.0)))
TRUE = replace(
    ROLLS_180.n, v_t0=0.52, kappa=0.70, mu_cox=240e-6, mobility_reduction=0.3, early_rise=0.05,
    v_t0_drift=-0.9e-3, size=SizeTerms(1 * UM, 8 * UM, 0.5 * UM, 4 * UM, v_t0=(3e-8, -1e-14, 2e-9, 0.0),
    kappa=(1e-8, 0.0, 0.0, 0.0)),
)  # fmt: skip


def points(
    sizes: tuple[tuple[float, float], ...] = SIZES, celsius: tuple[float, ...] = (-20.0, 27.0, 85.0)
) -> Points:
    """Currents of the true law at some sizes (um) and temperatures (degC)."""
    gate, drain, source = np.linspace(0.3, 1.4, 12), (0.1, 1.0), (0.0, 0.3)
    grid = np.array(list(itertools.product(sizes, celsius, drain, source, gate)), dtype=object)
    size = np.array(list(grid[:, 0])) * UM
    t, d, s, g = (grid[:, k].astype(float) for k in (1, 2, 3, 4))
    blank = Points("n", size[:, 0], size[:, 1], t, d + s, g + s, s, np.ones(t.size))
    return replace(blank, current=law_current(TRUE, ROLLS_180, blank)).between(1e-10, 1e-5)


def test_numbers_of_the_law_come_back() -> None:
    start = replace(ROLLS_180.n, early_rise=0.1)
    found = fit(points(), start, ROLLS_180)
    for name, scale in (("v_t0", 1.0), ("kappa", 1.0), ("mu_cox", 240e-6), ("v_t0_drift", 1e-3)):
        assert getattr(found.model, name) == pytest.approx(getattr(TRUE, name), abs=1e-3 * scale), name
    assert found.model.size is not None
    assert found.model.size.v_t0[0] == pytest.approx(3e-8, rel=0.02)
    assert distance(found.model, ROLLS_180, points()).median < 1e-3
    assert found.correlation.shape == (len(found.names),) * 2
    assert np.all(found.errors >= 0.0)


def test_errors_of_noisy_points_cover_the_truth() -> None:
    clean, inside = points(), 0
    names = ("v_t0", "kappa", "mu_cox")
    start = replace(TRUE, v_t0=0.5, kappa=0.72)
    for seed in range(12):
        noise = np.exp(np.random.default_rng(seed).normal(0.0, 0.02, len(clean)))
        found = fit(replace(clean, current=clean.current * noise), start, ROLLS_180, names)
        true = np.array([TRUE.v_t0, TRUE.kappa, np.log(TRUE.mu_cox)])
        inside += int(np.sum(np.abs(found.values - true) < 2.0 * found.errors))
    assert inside >= 30  # of 36, of which two sigma hold 34


def test_what_points_do_not_fix_stays_and_is_told() -> None:
    one = points(sizes=((2.0, 1.0),), celsius=(27.0,))
    assert "v_t0 1/L" not in terms_for(one)
    found = fit(one, ROLLS_180.n, ROLLS_180)
    assert {"v_t0_drift", "mobility_exponent", "v_t0 1/L", "kappa 1/W"} <= set(found.free)
    assert found.model.v_t0_drift == ROLLS_180.n.v_t0_drift
    assert found.model.size is None
    with pytest.raises(ParameterError, match="fit: 3 points for"):
        fit(one.where(np.arange(len(one)) < 3), ROLLS_180.n, ROLLS_180)
    with pytest.raises(ParameterError, match="fit: v_t1, must be one of v_t0"):
        fit(one, ROLLS_180.n, ROLLS_180, ("v_t1",))


def test_a_polarity_without_points_stays_and_sizes_are_judged() -> None:
    found = extract_from({"n": points()}, ROLLS_180, {"n": points(sizes=((4.0, 2.0),))})
    assert found.process.p == rounded(ROLLS_180.p)
    roles = [(role, size) for role, size, _ in found.distances("n")]
    assert roles[-1] == ("held out", (4.0 * UM, 2.0 * UM))
    assert len(roles) == 10
    assert found.judged("n").median < 2e-3


def table(rows: Points, path: Path, **changed: str) -> Path:
    names = ("width", "length", "temperature_c", "v_d", "v_g", "v_s", "current")
    columns = (getattr(rows, name) for name in names)
    found = (",".join(["n", *(repr(float(x)) for x in row)]) for row in zip(*columns, strict=True))
    lines = [",".join(COLUMNS), *found]
    text = "\n".join(lines)
    for old, new in changed.items():
        text = text.replace(old, new)
    path.write_text(text + "\n")
    return path


def test_a_table_is_read_and_its_dark_rows_are_counted(tmp_path: Path) -> None:
    some = points(sizes=((2.0, 1.0),), celsius=(27.0,))
    path = table(some, tmp_path / "fet.csv")
    path.write_text(path.read_text() + "n,1e-6,1e-6,27,1,0,0,-1e-13\n")
    found, dropped = read_points(path)
    assert dropped == 1
    current: F64 = found["n"].current
    np.testing.assert_array_equal(current, some.current)
    for old, new, said in (
        ("width_m", "width", "no column width_m"),
        ("\nn,", "\nx,", "line 2, polarity: x, must be n or p"),
        ("n,2e-06", "n,wide", "line 2, width_m: wide, must be a number"),
    ):
        with pytest.raises(DataError, match=said):
            read_points(table(some, tmp_path / "bad.csv", **{old: new}))
    with pytest.raises(DataError, match="No such file"):
        read_points(tmp_path / "none.csv")


def test_points_of_both_polarities_or_without_current_are_refused() -> None:
    some = points(sizes=((2.0, 1.0),), celsius=(27.0,))
    with pytest.raises(ParameterError, match="of both polarities"):
        joined([some, replace(some, polarity="p")])
    with pytest.raises(ParameterError, match=r"points\.current: 0 A"):
        replace(some, current=np.zeros(len(some)))
    with pytest.raises(ParameterError, match=r"points\.v_d: 1 values"):
        replace(some, v_d=np.zeros(1))


def test_a_number_at_a_limit_is_told_and_the_farthest_ratio_is_the_worst() -> None:
    one = points(sizes=((2.0, 1.0),), celsius=(27.0,))
    steep = replace(TRUE, early_rise=0.6)
    seen = replace(one, current=law_current(steep, ROLLS_180, one))
    found = fit(seen, TRUE, ROLLS_180, ("v_t0", "early_rise"))
    assert found.limited == ("early_rise",)
    assert found.model.early_rise == 0.3
    assert fit(one, TRUE, ROLLS_180, ("v_t0", "early_rise")).limited == ()
    # a law that is eight times too high at a point, and ten times too low at another
    factor = np.ones(len(one))
    factor[[3, 7]] = 1.0 / 8.0, 10.0
    far = distance(TRUE, ROLLS_180, replace(one, current=one.current * factor))
    assert far.worst == pytest.approx(-0.9)
    assert far.where["v_g"] == one.v_g[7]
