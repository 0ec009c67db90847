"""Devices of a model are those of the transistor level; what they carry is the law's."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.blocks.mos import mos
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, Instance, InstanceArray, Port
from circuits.devices import Capacitor, Transistor
from circuits.devices.transistor import drain_current
from circuits.errors import ParameterError, UnknownNameError
from circuits.lowering.capacitors_on_die import added_capacitance
from circuits.lowering.kernel import to_kernel
from circuits.lowering.made import made
from circuits.lowering.on_die import DieDevices, bias_lines, on_die
from circuits.silicon.die import Die, Path
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench

SILICON = Silicon(AMI_1500_IDEAL, 40.0, Die(number=1003))
PORTS = (Port("vdd", "supply"), Port("g", "analog"))
PAIR = Circuit(
    "pair", PORTS,
    (mos("a", "n", "g", "g", "0", 6, 3), replace(mos("b", "n", "x", "g", "0", 6, 6), multiplicity=3.0),
     mos("ip", "p", "y", "x", "vdd", 9, 3), mos("in", "n", "y", "x", "0", 3, 3),
     Capacitor("c", "x", "0", 1e-12)),
)  # fmt: skip
WIRES = {"vdd": "vdd", "g": "g"}
ROW = Circuit(
    "row", PORTS, (mos("top", "p", "g", "g", "vdd", 3, 3),),
    (InstanceArray("each", PAIR, (4,), WIRES, {"a.width": (6e-6, 7e-6, 8e-6, 9e-6)}),),
)  # fmt: skip
CHIP = Circuit(
    "chip", PORTS, (),
    (InstanceArray("rows", ROW, (2, 3), WIRES, {"each.b.width": 12e-6}),
     Instance("alone", ROW, WIRES, {"each.a.width": 5e-6})),
)  # fmt: skip


def of_the_solver(circuit: Circuit, silicon: Silicon) -> dict[str, tuple[F64, F64]]:
    """Specific currents (A) and thresholds (V) by the device's name, of all its places."""
    machine = to_kernel(Testbench("t", circuit, (), 1.0), silicon)
    table, start, found = machine.kernel.transistors, 0, {}
    for g in machine.flat.groups:
        if isinstance(g.device, Transistor):
            own = slice(start, start + g.nodes.shape[1])
            start = own.stop
            name = ".".join((*(n for n, _ in g.path), g.device.name))
            found[name] = table.specific_current[own], table.v_t0[own]
    return found


def same(d: DieDevices, name: str, expected: tuple[F64, F64]) -> bool:
    fet = d.fet[name]
    return np.allclose(fet.current.ravel(), expected[0], rtol=1e-14, atol=0.0) and np.allclose(
        fet.threshold.ravel(), expected[1], rtol=1e-14, atol=0.0
    )


def test_all_devices_are_those_of_the_solver_with_the_sizes_that_instances_set() -> None:
    d, expected = on_die(CHIP, SILICON), of_the_solver(CHIP, SILICON)
    assert set(d.fet) == set(expected)
    assert all(same(d, name, found) for name, found in expected.items())
    assert d.fet["rows.each.a"].current.shape == (2, 3, 4)
    assert d.fet["alone.top"].current.shape == ()


def test_a_part_at_its_place_has_the_chip_s_devices() -> None:
    place: Path = (("chip", ()), ("rows", (2, 3)))
    sizes = {"a.width": (6e-6, 7e-6, 8e-6, 9e-6), "b.width": 12e-6}
    wider = replace(ROW, instances=(InstanceArray("each", PAIR, (4,), WIRES, sizes),))
    d, whole = on_die(wider, SILICON, ("each.b", "top"), place), on_die(CHIP, SILICON)
    assert d.copies == 6
    assert np.array_equal(d.fet["each.b"].current, whole.fet["rows.each.b"].current)
    assert np.array_equal(d.fet["top"].threshold, whole.fet["rows.top"].threshold)
    there = replace(SILICON, place=(("chip", ()), ("rows", (1, 2))))
    alone = on_die(wider, there, ("each.b",))
    assert np.array_equal(alone.fet["each.b"].threshold, d.fet["each.b"].threshold[1, 2])


def test_deviations_are_local_and_zero_without_mismatch() -> None:
    d, bare = on_die(PAIR, SILICON), on_die(PAIR, replace(SILICON, die=replace(SILICON.die, mismatch=False)))
    fet, shared = d.fet["a"], bare.fet["a"]
    assert float(fet.threshold) == pytest.approx(float(shared.threshold + fet.v_t0), rel=1e-15)
    assert float(fet.current) == pytest.approx(float(shared.current * (1.0 + fet.beta)), rel=1e-15)
    assert np.array_equal(bare.offset("a", "b"), np.zeros(4))
    expected = [fet.v_t0, np.log1p(fet.beta), d.fet["b"].v_t0, np.log1p(d.fet["b"].beta)]
    assert np.array_equal(d.offset("a", "b"), expected)
    assert float(fet.v_t0) != 0.0


def carried(d: DieDevices, drain: float, gate: float, source: float) -> float:
    """Current of the pair's device `a` at these voltages by the law of transistors, A."""
    law, fet, device = SILICON.law("n"), d.fet["a"], PAIR.device("a")
    assert isinstance(device, Transistor)
    own = replace(
        law, v_t0=law.v_t0 + float(fet.v_t0), square_current=law.square_current * (1.0 + float(fet.beta))
    )
    return float(drain_current(own, "n", device.width, device.length, drain, gate, source)[0])


@pytest.mark.parametrize("gate", [0.4, 0.7, 2.0])
def test_a_saturated_device_carries_the_law_s_current(gate: float) -> None:
    d = on_die(PAIR, SILICON)
    expected = carried(d, 50.0, gate, 0.0)
    assert float(d.saturated("a", gate)) == pytest.approx(expected, rel=1e-12)
    assert float(d.gate_for("a", d.saturated("a", gate))) == pytest.approx(gate, rel=1e-12)


@pytest.mark.parametrize(("gate", "source", "drain"), [(0.4, 0.0, 0.02), (0.9, 0.2, 0.5), (2.0, 0.1, 3.0)])
def test_a_channel_carries_the_law_s_current_at_any_drain_and_source(
    gate: float, source: float, drain: float
) -> None:
    d = on_die(PAIR, SILICON)
    assert float(d.channel("a", gate, drain)) == pytest.approx(carried(d, drain, gate, 0.0), rel=1e-12)
    assert float(d.saturated("a", gate, source)) == pytest.approx(carried(d, 50.0, gate, source), rel=1e-12)


def test_weak_inversion_alone_is_the_law_far_below_the_threshold() -> None:
    d = on_die(PAIR, SILICON)
    assert float(d.weak("a", 0.0)) == pytest.approx(float(d.saturated("a", 0.0)), rel=1e-3)
    assert float(d.weak("a", 2.0)) > 10.0 * float(d.saturated("a", 2.0))


def test_columns_are_asked_at_several_voltages_each() -> None:
    gates = {"g": np.arange(6.0), "one": 0.5}
    d = on_die(PAIR, SILICON, ("a",), (("chip", ()), ("part", (6,))), gates)
    grid, over = np.array([0.3, 0.8]), d.columns()
    found = over.saturated("a", grid)
    assert found.shape == (6, 2)
    assert np.array_equal(found[:, 1], d.saturated("a", 0.8))
    assert over.gate["g"].shape == (6, 1)
    assert over.gate["one"].shape == ()


@pytest.mark.parametrize("current", [1e-12, 1e-8, 1e-5])
def test_a_mirror_s_copy_has_the_diode_s_gate(current: float) -> None:
    d = on_die(PAIR, SILICON)
    mirror, given = d.mirror("a", "b"), np.array(current)
    out = d.saturated("b", d.gate_for("a", given))
    assert float(mirror.copied(given)) == pytest.approx(float(out), rel=1e-12)
    assert float(mirror.needed(out)) == pytest.approx(current, rel=1e-12)
    assert float(mirror.weak) == pytest.approx(float(mirror.copied(np.array(1e-18))) / 1e-18, rel=1e-3)


def test_both_devices_of_an_inverter_carry_the_same_at_its_threshold() -> None:
    d = on_die(PAIR, SILICON, ("ip", "in"), (("chip", ()), ("part", (5,))))
    turns = d.inverter_threshold("i")
    assert turns.shape == (5,)
    assert d.saturated("in", turns) == pytest.approx(d.saturated("ip", d.v_dd - turns), rel=1e-12)
    assert np.all(d.inverter_lag("i", np.array(1.0), 1e-14, np.array(1e6)) > 0.0)


def test_copies_names_and_dimensions_of_devices() -> None:
    d = on_die(CHIP, SILICON, ("rows.each.a",)).renamed("rows.each.", "own.").flat()
    assert list(d.fet) == ["own.a"]
    taken = d.taken(np.array([23, 0, 0]))
    assert taken.copies == 3
    assert np.array_equal(taken.fet["own.a"].current, d.fet["own.a"].current[[23, 0, 0]])


def test_lines_are_those_of_the_circuit_s_own_biases() -> None:
    neuron = rebound_neuron.build()
    lines = bias_lines(neuron, SILICON)
    assert set(lines) == {b.port for b in neuron.biases}
    d = on_die(neuron, SILICON, ("membrane.mr1",), gate=lines)
    assert float(d.below("v_pw")) == AMI_1500_IDEAL.v_dd - float(lines["v_pw"])


def test_what_is_no_transistor_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"pair\.c: must be a transistor"):
        on_die(PAIR, SILICON, ("c",))
    with pytest.raises(UnknownNameError, match="nothing"):
        on_die(CHIP, SILICON, ("rows.nothing",))


def test_capacitors_have_what_the_solver_gives_them() -> None:
    silicon = replace(SILICON, die=Die(number=1003, variation="full"))
    names = ("rows.each.c", "alone.each.c")
    found, flat = (
        added_capacitance(CHIP, silicon, names),
        to_kernel(Testbench("t", CHIP, (), 1.0), silicon).flat,
    )
    for group in (g for g in flat.groups if isinstance(g.device, Capacitor)):
        name = ".".join((*(n for n, _ in group.path), group.device.name))
        expected = made(group, "chip", silicon) - 1e-12
        assert np.ravel(found[name]) == pytest.approx(expected, rel=1e-9)
        assert np.ptp(expected) > 0.0
    assert np.shape(found["rows.each.c"]) == (2, 3, 4)
    place: Path = (("chip", ()), ("rows", (2, 3)))
    there = added_capacitance(ROW, silicon, ("each.c",), place)["each.c"]
    assert np.array_equal(there, found["rows.each.c"])
    assert not any(x.any() for x in added_capacitance(CHIP, SILICON, names).values())
    with pytest.raises(ParameterError, match=r"pair\.a: must be a capacitor"):
        added_capacitance(PAIR, silicon, ("a",))


FULL = replace(SILICON, process=AMI_1500)


def test_a_current_under_the_full_law_is_the_solvers() -> None:
    d = on_die(PAIR, FULL)
    law = FULL.law("n")
    drains = np.linspace(0.0, 5.0, 7)
    for name, source in (("a", 0.0), ("b", 0.3)):
        fet = d.fet[name]
        own = replace(
            law,
            v_t0=float(fet.threshold),
            square_current=float(fet.current) * float(fet.length / fet.width),
        )
        width, length = float(fet.width), float(fet.length)
        expected = drain_current(own, "n", width, length, drains, 0.8, source)
        assert d.current(name, 0.8, drains, source) == pytest.approx(expected, rel=1e-12)
        assert d.terms(name).specific == float(fet.current)


def test_gates_and_mirrors_are_inverses_under_the_full_law() -> None:
    d = on_die(CHIP, FULL)
    for current in (1e-12, 1e-9, 1e-6):
        gate = d.gate_for("alone.each.b", current)
        assert d.saturated("alone.each.b", gate) == pytest.approx(np.full(4, current), rel=1e-9)
        mirror = d.mirror("alone.each.a", "alone.each.b")
        assert mirror.needed(mirror.copied(np.array(current))) == pytest.approx(np.full(4, current), rel=1e-9)
        # the diode's drain is at its gate
        volts = d.fet["alone.each.a"].gate_for(np.array(current), diode=True)
        leakage = d.current("alone.each.a", 0.0, volts) if current == 1e-12 else 0.0
        carried = d.current("alone.each.a", volts, volts)
        assert carried - leakage == pytest.approx(np.full(4, current), rel=0.2 if current == 1e-12 else 1e-3)


def test_an_inverter_under_the_full_law_turns_where_its_devices_carry_the_same_at_half_the_supply() -> None:
    d = on_die(PAIR, FULL)
    turned = d.inverter_threshold("i")
    half = 0.5 * d.v_dd
    assert d.current("in", turned, half) == pytest.approx(d.current("ip", d.v_dd - turned, half), rel=1e-9)
    assert d.full
    assert not on_die(PAIR, SILICON).full
