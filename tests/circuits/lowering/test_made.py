"""Capacitors and resistors as a die makes them: the same in every lowering."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Resistor, Source, Transistor
from circuits.devices.source import Constant
from circuits.lowering.flatten import flatten
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.lowering.made import made
from circuits.lowering.variation import variation_draws, variation_labels
from circuits.registry import load_block
from circuits.silicon.components import EXTENTS, Extent
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.device_table import resistor_table_at
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

BLOCK = load_block("rebound-neuron")
FULL = Die(number=1003, variation="full")


def divider() -> Testbench:
    devices = (
        Resistor("top", "vdd", "mid", 3e6),
        Resistor("bottom", "mid", "0", 2e6),
        Capacitor("c", "mid", "0", 1e-12),
        Transistor("m", "n", "mid", "0", "0", "0", 6e-6, 6e-6),
    )
    circuit = Circuit("divider", (Port("vdd", "supply"), Port("mid", "analog")), devices)
    drives = (Source("vdd", "vdd", Constant(5.0)), Source("i", "mid", Constant(1e-9), "current"))
    return Testbench("divider", circuit, drives, stop=1e-3)


def require_equal(one: Machine, other: Machine) -> None:
    for part in ("transistors", "charge", "conductance"):
        for a, b in zip(getattr(one.kernel, part), getattr(other.kernel, part), strict=True):
            np.testing.assert_array_equal(a, b)
    for name in ("source_charge", "source_conductance"):
        for a, b in zip(getattr(one, name), getattr(other, name), strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("variation", EXTENTS)
@pytest.mark.parametrize("bench", [divider(), BLOCK.bench(BLOCK.build())], ids=["divider", "rebound"])
def test_a_machine_put_on_a_die_is_that_lowered_there(bench: Testbench, variation: Extent) -> None:
    die = replace(FULL, variation=variation)
    there = to_kernel(bench, Silicon(AMI_1500_IDEAL, die=die))
    require_equal(on_die(to_kernel(bench, Silicon(AMI_1500_IDEAL)), die), there)
    require_equal(on_die(there, NOMINAL), to_kernel(bench, Silicon(AMI_1500_IDEAL)))


def test_a_divider_has_the_resistances_of_its_die() -> None:
    bench, silicon = divider(), Silicon(AMI_1500_IDEAL, die=FULL)
    point = operating_point(bench, silicon)
    change = made(flatten(bench.circuit).groups[0], "divider", silicon)[0] / 3e6
    assert abs(change - 1.0) > 1e-3
    table, nominal = resistor_table_at(point), resistor_table_at(operating_point(bench))
    # the current source and the transistor's are a thousandth of the resistors', so exact to a part in 1e4
    np.testing.assert_allclose(table.current * change, nominal.current, rtol=1e-4)


def test_labels_name_what_a_die_draws() -> None:
    circuit = divider().circuit
    flat = flatten(circuit)
    plain = variation_labels(flat, Silicon(AMI_1500_IDEAL, die=replace(FULL, variation="plain")))
    more = variation_labels(flat, Silicon(AMI_1500_IDEAL, die=replace(FULL, variation="transistors")))
    full = variation_labels(flat, Silicon(AMI_1500_IDEAL, die=FULL))
    assert set(plain) < set(more) < set(full)
    assert {label for label in more if label not in plain} == {
        *(f"gradient.{p}.{axis}.{name}" for p in "np" for axis in "xy" for name in ("v_t0", "beta")),
        *(f"wafer.{p}.shared.{name}" for p in "np" for name in ("v_t0", "beta")),
    }
    assert {label for label in full if label not in more} == {
        "divider.c.capacitance",
        *(f"{level}.capacitor.shared.capacitance" for level in ("process", "wafer")),
        *(f"{level}.resistor.shared.resistance" for level in ("process", "wafer")),
    }
    silicon = Silicon(AMI_1500_IDEAL, die=FULL)
    draws = dict(zip(full, variation_draws(flat, silicon, FULL), strict=True))
    near = dict(zip(full, variation_draws(flat, silicon, replace(FULL, number=1004)), strict=True))
    same = {label for label in full if draws[label] == near[label]}
    assert same == {label for label in full if label.startswith("wafer.")}
