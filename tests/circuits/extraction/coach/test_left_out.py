"""Leaving points out by one step is what a fit without them finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.extraction.coach.joint import Fit, fit
from circuits.extraction.coach.left_out import groups, left_out, share_inside
from circuits.silicon.process import ROLLS_180
from tests.circuits.extraction.coach.test_joint import CONDITIONS, made, prior


@pytest.fixture(scope="module")
def found() -> Fit:
    """A fit of three sweeps of known numbers."""
    start = prior()
    return fit(made({**start.values(), "n.v_t0": 0.49}, 7), start, ROLLS_180, rounds=1)


def test_each_sweep_is_left_out_once_and_whole(found: Fit) -> None:
    parts = groups(found, CONDITIONS)
    assert set(parts) == set(CONDITIONS)
    assert all(some.all() for group in parts.values() for some in group.values())


def test_points_of_the_model_lie_inside_their_bands(found: Fit) -> None:
    rows = list(left_out(found, CONDITIONS))
    assert sum(row.off.size for row in rows) == sum(b.residual.size for b in found.blocks.values())
    assert share_inside(rows) > 0.85


def test_one_step_is_what_a_fit_without_the_sweep_finds(found: Fit) -> None:
    start = prior()
    data = made({**start.values(), "n.v_t0": 0.49}, 7)
    name = "fet_n_sub_vg"
    less = fit([m for m in data if m.condition.name != name], start, ROLLS_180, rounds=1)
    (row,) = (row for row in left_out(found, CONDITIONS) if row.key[0] == name)
    k = start.names.index("n.v_t0")
    block = found.blocks["fet_n_sub_vg", "i_s_A"]
    # what the residuals of the sweep are at the fit that has not seen it, to first order
    moved = (less.posterior.mean - found.posterior.mean) / start.sd
    assert np.allclose(block.residual + block.jacobian @ moved, row.off, atol=0.5)
    assert less.posterior.sd[k] >= found.posterior.sd[k]


def test_a_point_far_off_is_outside(found: Fit) -> None:
    key = ("fet_n_sub_vg", "i_s_A")
    block = found.blocks[key]
    far = block._replace(residual=block.residual + np.where(np.arange(block.residual.size) == 2, 500.0, 0.0))
    changed = replace(found, blocks={**found.blocks, key: far})
    (row,) = (row for row in left_out(changed, CONDITIONS) if row.key == key)
    assert not row.inside[2]
