"""Capacitors of a model are those of the transistor level, at every place of an array."""

import numpy as np
import pytest

from circuits.blocks.mos import mos
from circuits.circuit import Circuit, InstanceArray, Port
from circuits.devices import Capacitor, Source
from circuits.devices.source import Constant
from circuits.errors import ParameterError, UnknownNameError
from circuits.lowering.capacitors_on_die import (
    added_capacitance,
    capacitor_changes,
    capacitors_deviate,
    with_capacitors,
)
from circuits.lowering.kernel import to_kernel
from circuits.lowering.on_die import standing
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench

FULL = Silicon(AMI_1500_IDEAL, die=Die(number=1003, variation="full"))
LONE = Circuit(
    "lone", (Port("vdd", "supply"),),
    (mos("a", "n", "x", "x", "0", 6, 3), Capacitor("c", "x", "0", 1e-12), Capacitor("d", "x", "vdd", 2e-12)),
)  # fmt: skip
SIZES = (1e-12, 2e-12, 3e-12, 4e-12)
ROW = Circuit(
    "row", LONE.ports, (),
    (InstanceArray("each", LONE, (4,), {"vdd": "vdd"}, {"c.capacitance": SIZES}),),
)  # fmt: skip


def test_changes_are_those_of_the_solver_s_capacitors() -> None:
    found = capacitor_changes(ROW, FULL, ("each.d", "each.c"))
    assert [x.shape for x in found.values()] == [(4,), (4,)]
    assert np.unique(np.stack([*found.values()])).size == 8
    bench = Testbench("t", ROW, (Source("vdd", "vdd", Constant(5.0)),), 1.0)
    plain, moved = (to_kernel(bench, s).kernel.charge.value for s in (Silicon(AMI_1500_IDEAL), FULL))
    # each node x has an entry of the matrix for itself, for the supply and for ground
    to_ground, to_supply = found["each.c"] * np.array(SIZES), found["each.d"] * 2e-12
    different = (moved - plain)[moved != plain].reshape(4, 3)
    expected = np.stack([to_ground + to_supply, -to_supply, -to_ground], axis=1)
    np.testing.assert_allclose(different, expected, rtol=1e-9)


def test_a_place_on_a_chip_is_the_chip_s() -> None:
    assert capacitors_deviate(LONE, FULL)
    there = capacitor_changes(LONE, FULL, ("c",), (("row", ()), ("each", (4,))))["c"]
    # a capacitor's draw is of its place, its spread of its size
    chip = capacitor_changes(ROW, FULL, ("each.c",))["each.c"]
    assert there[0] == chip[0]
    assert (there[1:] != chip[1:]).all()


@pytest.mark.parametrize("die", [NOMINAL, Die(number=3), Die(number=3, variation="transistors")])
def test_other_dies_have_the_capacitors_that_were_drawn(die: Die) -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=die)
    assert not capacitors_deviate(LONE, silicon)
    assert capacitor_changes(LONE, silicon, ("c",))["c"] == 0.0


def test_what_is_no_capacitor_is_refused_by_name() -> None:
    with pytest.raises(ParameterError, match=r"lone\.a: must be a capacitor"):
        capacitor_changes(LONE, FULL, ("a",))
    with pytest.raises(UnknownNameError, match="b"):
        capacitor_changes(LONE, FULL, ("b",))


def test_devices_know_their_capacitors() -> None:
    d = with_capacitors(standing(ROW, FULL, "each"), ROW, FULL, inside="each")
    expected = added_capacitance(ROW, FULL, ("each.c",))["each.c"]
    assert np.array_equal(d.added("c"), expected)
    assert np.array_equal(d.taken(np.array([2, 0])).added("c"), expected[[2, 0]])
    assert np.array_equal(d.renamed("", "row.").added("row.c"), expected)


def test_devices_add_nothing_to_capacitors_that_do_not_deviate() -> None:
    plain = Silicon(AMI_1500_IDEAL, die=Die(number=1003))
    d = standing(ROW, plain, "each")
    assert with_capacitors(d, ROW, plain, inside="each") is d
    assert d.added("c") == 0.0
