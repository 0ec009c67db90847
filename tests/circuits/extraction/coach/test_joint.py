"""The joint fit finds the numbers that made some measurements, says how sure it is, and what stays free."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from circuits.errors import DataError, ParameterError
from circuits.extraction.coach.bench import Bench, bench_unknowns, process_unknowns
from circuits.extraction.coach.conditions import read_conditions
from circuits.extraction.coach.joint import Measured, Model, fit
from circuits.extraction.coach.readings import fet
from circuits.extraction.coach.table import Table, read_folder
from circuits.extraction.coach.unknown import Posterior, Theta, before
from circuits.silicon.process import ROLLS_180

NAMES = ("fet_n_sub_vg", "fet_n_backgate", "fet_n_sat_vg")
CONDITIONS = {name: condition for name, condition in read_conditions().items() if name in NAMES}
FIT = read_folder(None, "fit")
FITTED = ("n.v_t0", "n.kappa", "n.mu_cox", "shunt low", "n.early_rise")


def prior() -> Posterior:
    """Unknowns of an nFET, all but a few of them known."""
    known = (*process_unknowns(ROLLS_180), *bench_unknowns(), *fet.unknowns(CONDITIONS))
    return before(u if u.name in FITTED else replace(u, sd=1e-9 * max(u.sd, 1e-9)) for u in known)


def made(values: dict[str, float], seed: int, names: Iterable[str] = NAMES) -> list[Measured]:
    """Measurements of known numbers with noise, where the real ones were made."""
    found, random = [], np.random.default_rng(seed)
    for name in names:
        condition, table = FIT[name]
        clean = fet.predict(Bench(Theta(values), ROLLS_180), condition, table)
        spread = fet.noise(condition, clean)
        noisy = Table(
            {**table, **{n: v + spread[n] * random.standard_normal(v.size) for n, v in clean.items()}}
        )
        kept = fet.usable(condition, noisy)
        found.append(Measured(condition, noisy, Model(fet.predict, fet.usable, fet.noise), kept))
    return found


def test_numbers_that_made_the_curves_come_back_with_their_errors() -> None:
    start = prior()
    true = {**start.values(), "n.v_t0": 0.50, "n.kappa": 0.73, "shunt low": np.log(31e3)}
    found = fit(made(true, 5), start, ROLLS_180, rounds=1)
    for name in ("n.v_t0", "n.kappa", "n.mu_cox", "shunt low"):
        k = found.posterior.names.index(name)
        off = (found.posterior.mean[k] - true[name]) / found.posterior.sd[k]
        assert abs(off) < 3.5, (name, off)
        assert found.posterior.sd[k] < 0.7 * start.sd[k]
    assert np.allclose(np.diag(found.posterior.correlation), 1.0)


def test_what_no_measurement_reads_is_free() -> None:
    start = prior()
    found = fit(made(start.values(), 1, ("fet_n_sub_vg", *NAMES[1:2])), start, ROLLS_180, rounds=1)
    free = found.posterior.free()
    assert "p.v_t0" in free
    assert "n.v_t0" not in free


def test_the_noise_is_what_the_residuals_say() -> None:
    start = prior()
    data = made(start.values(), 3)
    wide = []
    for m in data:
        off = {
            c: m.table[c]
            + 4.0
            * (m.table[c] - fet.predict(Bench(Theta(start.values()), ROLLS_180), m.condition, m.table)[c])
            for c in m.kept
        }
        wide.append(replace(m, table=Table({**m.table, **off})))
    found = fit(wide, start, ROLLS_180, rounds=2)
    assert all(2.5 < factor < 8.5 for factor in found.factors.values()), found.factors


def test_a_fit_of_too_few_points_is_refused() -> None:
    data = made(prior().values(), 1)
    few = [replace(m, kept={c: k & (np.cumsum(k) < 3) for c, k in m.kept.items()}) for m in data]
    with pytest.raises(DataError, match=r"6 points for 22 numbers of the process, must be more"):
        fit(few, prior(), ROLLS_180)


def test_draws_have_the_mean_and_the_spread_of_the_posterior() -> None:
    start = before(u for u in prior().unknowns if u.name in FITTED)
    normals = np.random.default_rng(2).standard_normal((4000, len(start.names)))
    draws = np.array([[d[name] for name in start.names] for d in start.draws(normals)])
    assert np.allclose(draws.mean(axis=0), start.mean, atol=0.06 * start.sd)
    assert np.allclose(draws.std(axis=0), start.sd, rtol=0.05)


def test_an_unknown_that_is_there_twice_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"n\.v_t0: an unknown that is there twice"):
        before([*process_unknowns(ROLLS_180), *process_unknowns(ROLLS_180)])
