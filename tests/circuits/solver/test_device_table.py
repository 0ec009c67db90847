"""The table by device against closed forms: weak-inversion efficiency, mirrors, Kirchhoff, differences."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, InstanceArray, Node, Port
from circuits.devices import Resistor, Source, Transistor
from circuits.devices.source import Constant
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, Polarity, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.device_table import TransistorTable, resistor_table_at, transistor_table_at
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.testbench import Testbench
from tests.circuits.solver.examples import UM, V_DD, neuron


def device(polarity: Polarity = "n", name: str = "m") -> Transistor:
    return Transistor(name, polarity, "d", "g", "s", "b", 6 * UM, 3 * UM)


def driven(polarity: Polarity, silicon: Silicon, **voltages: float) -> OperatingPoint:
    """One transistor with a source at each terminal."""
    circuit = Circuit("one", tuple(Port(n, "analog") for n in "dgsb"), (device(polarity),))
    sources = tuple(Source(n, n, Constant(voltages[n])) for n in "dgsb")
    return operating_point(Testbench("one", circuit, sources, 1.0), silicon)


def table(polarity: Polarity, silicon: Silicon | None = None, **voltages: float) -> TransistorTable:
    return transistor_table_at(driven(polarity, silicon or Silicon(AMI_1500_IDEAL), **voltages))


def with_models(**changes: object) -> Process:
    n, p = (replace(m, **changes) for m in (AMI_1500_IDEAL.n, AMI_1500_IDEAL.p))  # type: ignore[arg-type]
    return replace(AMI_1500_IDEAL, n=n, p=p)


@pytest.mark.parametrize("temperature_c", [-20.0, 27.0, 85.0])
@pytest.mark.parametrize(
    ("polarity", "at"),
    [("n", {"d": 2.0, "g": 0.3, "s": 0.0, "b": 0.0}), ("p", {"d": 3.0, "g": 4.5, "s": 5.0, "b": 5.0})],
)
def test_weak_inversion_has_the_efficiency_kappa_over_u_t(
    polarity: Polarity, at: dict[str, float], temperature_c: float
) -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    found = table(polarity, silicon, **at)
    limit = AMI_1500_IDEAL.model(polarity).kappa / silicon.thermal_voltage
    # EKV in saturation: (1 - e^-r) / r of the limit with r = IC^0.5; the reverse term, e^-20, is left out
    root = np.sqrt(found.inversion_coefficient[0])
    assert root < 0.1
    assert found.efficiency[0] == pytest.approx(limit, rel=0.05)
    assert found.efficiency[0] == pytest.approx(limit * -np.expm1(-root) / root, rel=1e-7)
    assert found.inversion == ("weak",)
    assert found.region == ("saturated",)
    assert np.sign(found.drain_current[0]) == (1.0 if polarity == "n" else -1.0)


def test_saturated_without_early_effect_ic_is_the_current_over_the_specific_current() -> None:
    silicon = Silicon(AMI_1500_IDEAL)
    for gate, word in ((0.4, "weak"), (0.65, "moderate"), (2.0, "strong")):
        found = table("n", silicon, d=5.0, g=gate, s=0.0, b=0.0)
        specific = silicon.law("n").square_current * 6.0 / 3.0
        assert found.inversion_coefficient[0] == pytest.approx(found.drain_current[0] / specific, rel=1e-9)
        assert found.inversion == (word,)


def test_strong_inversion_efficiency_is_two_over_the_overdrive() -> None:
    found = table("n", d=5.0, g=2.6, s=0.0, b=0.0)
    assert found.efficiency[0] == pytest.approx(2.0 / (2.6 - AMI_1500_IDEAL.n.v_t0), rel=1e-6)


@pytest.mark.parametrize("law", ["ekv", "ekv-gamma"])
@pytest.mark.parametrize("polarity", ["n", "p"])
@pytest.mark.parametrize("drain", [0.05, 0.3, 3.0, -0.4])
def test_conductances_are_the_slopes_of_the_current(polarity: Polarity, law: str, drain: float) -> None:
    silicon = Silicon(with_models(law=law, early_field=15e6))
    sign, base = (1.0, 0.5) if polarity == "n" else (-1.0, 4.5)
    bulk = 0.0 if polarity == "n" else 5.0
    at = {"d": base + sign * drain, "g": base + sign * 0.8, "s": base, "b": bulk}
    found, step = table(polarity, silicon, **at), 1e-5
    end = "d" if drain > 0.0 else "s"  # what acts as the drain
    for node, column in (("g", found.transconductance), (end, found.output_conductance)):
        high, low = (table(polarity, silicon, **at | {node: at[node] + h}) for h in (step, -step))
        slope = (high.drain_current[0] - low.drain_current[0]) / (2.0 * step)
        # central differences: relative error (h / U_T)^2 / 6, rounding of 1e-16 U_T / h; both below 1e-6
        assert column[0] == pytest.approx(abs(slope), rel=1e-5, abs=1e-12 * abs(found.drain_current[0]))
    assert found.drain_source[0] == pytest.approx(abs(drain))


def test_saturation_without_early_effect_has_the_conductance_of_the_reverse_term() -> None:
    silicon = Silicon(AMI_1500_IDEAL)
    found = table("n", silicon, d=0.2, g=0.3, s=0.0, b=0.0)
    # weak inversion: I = I_F (1 - x) with x = e^(-V_DS/U_T), so that g_ds / I_D = x / (1 - x) / U_T
    share = np.exp(-0.2 / silicon.thermal_voltage)
    expected = found.drain_current[0] * share / silicon.thermal_voltage / (1.0 - share)
    assert found.output_conductance[0] == pytest.approx(expected, rel=0.02)
    assert found.headroom[0] == pytest.approx(0.2 - 4.0 * silicon.thermal_voltage, abs=1e-4)


def test_words_for_off_and_linear() -> None:
    assert table("n", d=1.0, g=0.0, s=0.0, b=0.0).inversion == ("off",)
    assert table("p", d=1.0, g=5.0, s=5.0, b=5.0).inversion == ("off",)
    linear = table("n", d=0.05, g=2.0, s=0.0, b=0.0)
    assert (linear.inversion, linear.region) == (("strong",), ("linear",))
    assert linear.headroom[0] < 0.0
    rest = table("n", d=0.0, g=1.0, s=0.0, b=0.0)
    assert rest.drain_current[0] == 0.0
    assert np.isnan(rest.efficiency[0])


def mirrors(count: int) -> Testbench:
    """A resistor feeds a diode; `count` copies with growing widths pull their own resistors."""
    copy = Circuit(
        "copy",
        (Port("vdd", "supply"), Port("gate", "analog"), Port("out", "analog", "out")),
        (Resistor("load", "vdd", "out", 1e6), Transistor("m", "n", "out", "gate", "0", "0", 3 * UM, 6 * UM)),
    )
    array = InstanceArray(
        "copy", copy, (count,), {"vdd": "vdd", "gate": "gate", "out": "out"},
        {"m.width": tuple(3 * UM * (k + 1) for k in range(count))},
    )  # fmt: skip
    devices = (
        Resistor("feed", "vdd", "gate", 10e6),
        Transistor("diode", "n", "gate", "gate", "0", "0", 3 * UM, 6 * UM),
    )
    circuit = Circuit("mirrors", (Port("vdd", "supply"),), devices, (array,), (Node("out", (count,)),))
    return Testbench("mirrors", circuit, (Source("vdd", "vdd", Constant(V_DD)),), 1.0)


def test_a_mirror_copies_by_its_widths_and_every_element_is_listed() -> None:
    point = operating_point(mirrors(3), Silicon(AMI_1500_IDEAL))
    found, loads = transistor_table_at(point), resistor_table_at(point)
    assert found.name == ("diode", "copy[0].m", "copy[1].m", "copy[2].m")
    assert loads.name == ("feed", "copy[0].load", "copy[1].load", "copy[2].load")
    # all saturated by more than 1 V: what the reverse term leaves is below 1e-9
    np.testing.assert_allclose(found.drain_current / found.drain_current[0], [1, 1, 2, 3], rtol=1e-9)
    np.testing.assert_allclose(loads.current, found.drain_current, rtol=1e-6)
    np.testing.assert_allclose(
        loads.current[1:], [(5.0 - point[f"out[{k}]"]) / 1e6 for k in range(3)], rtol=1e-12
    )


@pytest.mark.parametrize("die", [Die(), Die("A", 7)])
def test_currents_of_the_table_add_up_to_nothing_at_every_free_node(die: Die) -> None:
    silicon = Silicon(with_models(junction_leakage=1e-9, early_field=30e6), 85.0, die)
    point = operating_point(neuron(), silicon)
    flat, found = point.machine.flat, transistor_table_at(point)
    assert resistor_table_at(point).name == ()
    total, size, k = np.zeros(flat.count), np.zeros(flat.count), 0
    for group in flat.groups:
        if not isinstance(group.device, Transistor):
            continue
        drain, _, source, bulk = (int(n) for n in group.nodes[:, 0])
        into_drain, into_source = found.leakage[:, k]
        flows = ((drain, into_drain), (source, into_source), (bulk, -into_drain), (bulk, -into_source),
                 (drain, found.drain_current[k]), (source, -found.drain_current[k]))  # fmt: skip
        for node, current in flows:
            total[node] += current
            size[node] += abs(current)
        k += 1
    assert k == len(found.name)
    free = point.machine.column < point.machine.kernel.unknowns
    assert free.sum() > 10
    # the last Newton update is below 1e-9 V, 4e-8 of a weakly inverted device's current; and a voltage's
    # rounding, 1e-15 V, times the conductance of an open inverter, 1e-4 S
    assert (np.abs(total[free]) <= 1e-6 * size[free] + 1e-19).all()


def test_a_die_moves_the_specific_current_too() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die("A", 3))
    found = transistor_table_at(operating_point(mirrors(3), silicon))
    nominal = transistor_table_at(operating_point(mirrors(3), Silicon(AMI_1500_IDEAL)))
    assert (np.abs(found.drain_current / nominal.drain_current - 1.0) > 1e-6).all()
    assert len(set(found.drain_current[1:] / nominal.drain_current[1:])) == 3
