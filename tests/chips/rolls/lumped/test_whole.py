"""Networks under the law with second-order effects balance; without effects they are the ideal ones."""

from __future__ import annotations

import numpy as np
import pytest

from chips.rolls.lumped import network, whole_sum
from chips.rolls.lumped import whole_sum_lanes as lanes
from chips.rolls.lumped.whole import (
    amplifier,
    diode,
    fed_diode,
    middle_of,
    pair,
    points_of,
    rows_of,
    series,
)
from chips.rolls.lumped.whole_sum import mirrored_sum
from chips.rolls.synapse.whole_weight import sources
from circuits.blocks.rolls import dpi_synapse, neuron
from circuits.lowering.on_die import DieDevices, standing
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

POINTS = np.array([[0.05, 0.2, 0.6]])  # V


def devices(process=ROLLS_180) -> DieDevices:
    return standing(neuron.build(), Silicon(process, 40.0, Die(number=1001)))


def at(value) -> np.ndarray:
    return points_of(value, 1, POINTS.size)


def test_without_effects_they_are_the_ideal_networks() -> None:
    d = devices(ROLLS_180_IDEAL)
    low, high = d.fet["leak.ml3"], d.fet["leak.ml5"]
    found, expected = np.empty((1, 3)), np.empty(3)
    gates = d.gate["v_tau1"], d.v_dd
    series(rows_of(low), rows_of(high), at(gates[0]), at(gates[1]), POINTS, found)
    each = (np.full(3, float(x[0])) for x in (low.current, high.current))
    pinch = (
        np.full(3, float(np.ravel(d.pinch(n, g))[0]))
        for n, g in zip(("leak.ml3", "leak.ml5"), gates, strict=True)
    )
    (i1, i2), (p1, p2) = each, pinch
    network.stack(i1, p1, i2, p2, POINTS[0] / d.u_t, expected)
    assert found[0] == pytest.approx(expected, rel=1e-9)


def test_a_series_carries_the_same_current_in_both() -> None:
    d, found = devices(), np.empty((1, 3))
    low, high = rows_of(d.fet["leak.ml3"]), rows_of(d.fet["leak.ml5"])
    series(low, high, at(d.gate["v_tau2"]), at(d.v_dd), POINTS, found)
    # between what the lower one alone carries with its drain at either end of what the switch may drop
    alone = d.current("leak.ml3", d.gate["v_tau2"], POINTS[0])
    assert (found[0] <= alone * (1.0 + 1e-9)).all()
    assert (found[0] > 0.97 * alone).all()


def test_a_diode_carries_its_current_and_one_that_is_fed_too() -> None:
    d, volts, fed = devices(), np.empty((1, 3)), np.empty((1, 3))
    current = np.array([[1e-12, 1e-9, 1e-6]])
    diode(rows_of(d.fet["sodium.mn3"]), current, d.v_dd, volts)
    assert d.current("sodium.mn3", volts, volts)[0] == pytest.approx(current[0], rel=1e-8)
    fed_diode(
        rows_of(d.fet["sodium.mn1"]), rows_of(d.fet["sodium.mn3"]), at(0.5), at(np.array([[0.1, 0.2, 0.3]])),
        d.v_dd, fed, 0.0,
    )  # fmt: skip
    drawn = d.current("sodium.mn1", 0.5, d.v_dd - fed, np.array([[0.1, 0.2, 0.3]]))
    assert d.current("sodium.mn3", fed, fed)[0] == pytest.approx(drawn[0], rel=1e-6)


def test_a_pair_divides_all_of_its_current() -> None:
    d, source = devices(), np.empty((1, 3))
    names = "leak.ml1", "leak.ml2"
    gates, drains = (at(1.3), at(d.v_dd - POINTS)), (at(d.v_dd), at(d.v_dd - POINTS))
    total = at(1e-9)
    pair(*(rows_of(d.fet[n]) for n in names), gates, drains, total, source)
    silent = {n: f._replace(law=f.law.without_leakage()) for n, f in d.fet.items()}
    quiet = d._replace(fet=silent)
    found = sum(quiet.current(n, g, x, source) for n, g, x in zip(names, gates, drains, strict=True))
    assert found[0] == pytest.approx(total[0], rel=1e-9)


def test_an_amplifier_balances() -> None:
    d, drop = devices(), np.empty((1, 3))
    gates = at(np.array([[0.3, 0.5, 0.7]])), at(d.below("v_buf"))
    amplifier(rows_of(d.fet["reset.mc1"]), rows_of(d.fet["reset.mc2"]), *gates, d.v_dd, drop)
    up, down = (
        d.current("reset.mc2", gates[1], drop), d.current("reset.mc1", gates[0], d.v_dd - drop)
    )  # fmt: skip
    assert up[0] == pytest.approx(down[0], rel=1e-6)
    assert drop[0, 0] < 0.05
    assert drop[0, 2] > 1.5


def test_the_mean_of_one_place_is_that_place() -> None:
    d = devices()
    assert np.array_equal(middle_of(d, "leak.ml1"), rows_of(d.fet["leak.ml1"]))


def settles(rows, gates, at) -> bool:
    w = np.zeros(lanes.ROOM)
    lanes.take(rows, gates, 0, 1, w)
    lanes.begin(w, *at)
    return any(lanes.step_together(w, at[1]) == 0 for _ in range(lanes.TOGETHER))


@pytest.mark.parametrize("switch", [1.8, 0.0], ids=["on", "off"])
@pytest.mark.parametrize("bits", [(False, False), (True, False), (False, True), (True, True)])
def test_weights_on_a_switch_are_found_together_as_one_by_one(bits, switch) -> None:
    d = standing(dpi_synapse.build(), Silicon(ROLLS_180, 27.0, Die(number=1001)))
    lines = sources(d, bits)
    rows = rows_of(d.fet["synapse.me1"]), lines.rows, rows_of(d.fet["synapse.me7"])
    together = np.empty((3, 1))
    mirrored_sum(rows[0], rows[1], lines.gates, rows[2], (switch, d.v_dd), together)
    devices = whole_sum._placed(rows, 0)
    surely = whole_sum._mirrored_surely(devices, lines.gates, 0, (switch, d.v_dd))
    assert settles(rows, lines.gates, (switch, d.v_dd))
    # 1e-6: the nested loops end where the diode's gate moves by less than 1 uV
    assert together[:, 0] == pytest.approx(surely, rel=2e-6, abs=1e-18)


def test_weights_are_the_same_whatever_stands_beside_them() -> None:
    many = []
    for die in range(1001, 1041):
        d = standing(dpi_synapse.build(), Silicon(ROLLS_180, 27.0, Die(number=die)))
        lines = sources(d, (True, False))
        many.append((rows_of(d.fet["synapse.me1"]), *lines, rows_of(d.fet["synapse.me7"])))
    beside = np.empty((3, len(many)))
    top, rows, gates, mirror = (np.concatenate(each, axis=-1) for each in zip(*many, strict=True))
    mirrored_sum(top, rows, gates, mirror, (1.8, 1.8), beside)
    for k, each in enumerate(many):
        alone = np.empty((3, 1))
        mirrored_sum(*each, (1.8, 1.8), alone)
        assert alone[:, 0].tobytes() == beside[:, k].tobytes()
