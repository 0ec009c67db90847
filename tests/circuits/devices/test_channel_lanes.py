"""The channel in lanes against the channel of one device."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel, terms_of
from circuits.devices.channel_lanes import Effects, bent, channel_affected, channel_plain
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Polarity, Process
from circuits.silicon.silicon import Silicon
from circuits.vectors import vector
from circuits.vectors.vector import WIDTH, rows

every, load, store = vector.every, vector.load, vector.store


@compiled()
def in_lanes(t: Terms, affected: bool, x: F64, out: F64) -> None:
    """Rows of x: v_d, v_g and v_s; of out: the current, and its derivatives by them."""
    above = load(x, 1) - t.threshold
    lift = t.surface + t.gamma * np.sqrt(t.surface)
    v_p, kappa = bent(t.kappa * above, every(t.kappa), above + lift, every(t.gamma), every(t.surface))
    specific, half, v_d, v_s = every(t.specific), every(t.half), load(x, 0), load(x, 2)
    if affected:
        effects = Effects(
            every(t.early), every(t.early_rise), every(t.reduction), every(0.5 / (t.half * t.half))
        )
        found = channel_affected(specific, half, effects, v_d, v_p, v_s)
    else:
        found = channel_plain(specific, half, v_d, v_p, v_s)
    store(out, 0, found[0])
    store(out, 1, found[1])
    store(out, 2, kappa * found[2])
    store(out, 3, found[3])


@compiled()
def one_by_one(t: Terms, x: F64, out: F64) -> None:
    for i in range(x.shape[1]):
        out[0, i], out[1, i], out[2, i], out[3, i] = channel(t, x[0, i], x[1, i], x[2, i])


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500], ids=["ideal", "full"])
@pytest.mark.parametrize("polarity", ["n", "p"])
def test_every_lane_has_the_channel_of_its_device(process: Process, polarity: Polarity) -> None:
    law = Silicon(process).law(polarity)
    terms = terms_of(law, 3e-6, 3e-6, law.square_current, law.v_t0)
    affected = terms.early > 0.0
    draw = np.random.default_rng(7)
    for _ in range(50):
        x, ours, alone = rows(3), rows(4), rows(4)
        x[:] = draw.uniform(0.0, 5.0, (3, WIDTH))
        x[1, :4] = draw.uniform(-3.0, 0.3, 4)  # below flat band too
        in_lanes(terms, affected, x, ours)
        one_by_one(terms, x, alone)
        np.testing.assert_allclose(ours, alone, rtol=1e-9, atol=1e-12 * np.abs(alone).max())


def test_plain_and_affected_are_one_where_nothing_has_an_effect() -> None:
    law = replace(Silicon(AMI_1500).law("n"), early_field=0.0, mobility_reduction=0.0)
    terms = terms_of(law, 3e-6, 3e-6, law.square_current, law.v_t0)
    x, plain, affected = rows(3), rows(4), rows(4)
    x[:] = np.random.default_rng(8).uniform(0.0, 5.0, (3, WIDTH))
    in_lanes(terms, False, x, plain)
    in_lanes(terms, True, x, affected)
    np.testing.assert_allclose(affected, plain, rtol=1e-14)
