"""Capacitors, resistors and diodes as a die makes them: the same in every lowering."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Diode, Resistor, Source, Transistor
from circuits.devices.source import Constant
from circuits.errors import ParameterError
from circuits.lowering.flatten import flatten
from circuits.lowering.kernel import Machine, on_die, on_silicon, to_kernel
from circuits.lowering.made import made
from circuits.lowering.on_dies import on_dies
from circuits.lowering.variation import variation_draws, variation_labels, variation_sigma
from circuits.registry import load_block
from circuits.silicon.components import EXTENTS, Extent
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500_IDEAL, ROLLS_180, DiodeVariation
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
    for part in ("transistors", "diodes", "charge", "conductance"):
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


def test_a_machine_put_on_another_process_is_that_lowered_there() -> None:
    there = Silicon(ROLLS_180, 60.0, replace(FULL, variation="full"))
    found = on_silicon(to_kernel(divider(), Silicon(AMI_1500_IDEAL)), there)
    require_equal(found, to_kernel(divider(), there))
    assert found.silicon == there


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


SPREAD = replace(AMI_1500_IDEAL, diodes=DiodeVariation(pair_a_saturation=0.06, sigma_saturation=0.1))


def two_diodes() -> Testbench:
    devices = (
        Diode("small", "vdd", "mid", saturation_current=1e-15),
        Diode("large", "mid", "0", area=9.0, saturation_current=1e-15),
    )
    circuit = Circuit("pair", (Port("vdd", "supply"), Port("mid", "analog")), devices)
    return Testbench("pair", circuit, (Source("vdd", "vdd", Constant(1.2)),), stop=1e-3)


PAIR = flatten(two_diodes().circuit)


def saturations(die: Die) -> np.ndarray:
    """Saturation currents of both, over those that are drawn."""
    return np.concatenate([made(g, "pair", Silicon(SPREAD, die=die)) for g in PAIR.groups]) / 1e-15


def test_diodes_deviate_by_their_area_where_the_process_says_how_far() -> None:
    flat, dies = PAIR, [Die(number=n) for n in range(400)]
    silicon = Silicon(SPREAD, die=dies[0])
    wanted = {
        "pair.small.saturation_current": 0.06 / np.sqrt(2.0),
        "pair.large.saturation_current": 0.06 / np.sqrt(18.0),
        "process.diode.shared.saturation_current": 0.1,
    }
    labels, sigma = variation_labels(flat, silicon), variation_sigma(flat, silicon)
    own = {label: s for label, s in zip(labels, sigma, strict=True) if label in wanted}
    assert own == pytest.approx(wanted)
    assert not {*variation_labels(flat, Silicon(AMI_1500_IDEAL, die=dies[0]))} & wanted.keys()
    found = np.array([saturations(replace(die, process=False)) for die in dies])
    # 400 dies tell a standard deviation to 3.5 %
    ratio = found.std(axis=0) / np.array([0.06, 0.02]) * np.sqrt(2.0)
    np.testing.assert_allclose(ratio, 1.0, atol=0.11)
    together = np.array([saturations(replace(die, mismatch=False)) for die in dies])
    np.testing.assert_array_equal(together[:, 0], together[:, 1])
    assert together[:, 0].std() == pytest.approx(0.1, rel=0.11)
    drawn = variation_draws(flat, silicon, dies[7])
    moved = {label: s * z for label, s, z in zip(labels, sigma, drawn, strict=True) if label in wanted}
    small, large, both = (1.0 + moved[label] for label in wanted)
    np.testing.assert_allclose(saturations(dies[7]), [small * both, large * both], rtol=1e-12)


def test_machines_with_diodes_are_put_on_dies_as_they_are_lowered_there() -> None:
    machine = to_kernel(two_diodes(), Silicon(SPREAD))
    dies = [Die(number=n) for n in (1000, 1001)]
    for die, moved in zip(dies, on_dies(machine, dies), strict=True):
        require_equal(moved, to_kernel(two_diodes(), Silicon(SPREAD, die=die)))
        drawn = moved.kernel.diodes.saturation / np.array([1e-15, 9e-15])
        np.testing.assert_allclose(drawn, saturations(die), rtol=1e-12)
    assert (saturations(NOMINAL) == 1.0).all()


def test_a_diode_is_set_healed_and_refused_by_hand() -> None:
    die = Die(number=1003)
    np.testing.assert_allclose(
        saturations(NOMINAL.with_("pair.small", "saturation_current", 0.5)), [1.5, 1.0]
    )
    np.testing.assert_array_equal(saturations(die.healed("pair", "process.diode")), [1.0, 1.0])
    plain = Silicon(AMI_1500_IDEAL, die=Die().with_("pair.large", "saturation_current", -0.5))
    assert to_kernel(two_diodes(), plain).kernel.diodes.saturation[1] == pytest.approx(4.5e-15)
    with pytest.raises(
        ParameterError, match=r"pair.large.saturation_current: changes by -120 %, must be above -100 %"
    ):
        saturations(NOMINAL.with_("pair.large", "saturation_current", -1.2))
    with pytest.raises(ParameterError, match=r"diodes\.sigma_saturation: -1, must be >= 0"):
        DiodeVariation(0.1, -1.0)
