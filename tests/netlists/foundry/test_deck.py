"""The rebound neuron on the foundry's process, in ngspice: it facilitates; biases carry their currents."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, InstanceArray, Node, Port
from circuits.devices import Resistor, Transistor
from circuits.devices.transistor import drain_current
from circuits.errors import DataError, ParameterError, UnknownNameError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.foundry.deck import format_foundry, gate_voltages, map_circuit, resized, sweep_gate
from netlists.foundry.process import DeviceMapping
from netlists.ngspice import run as ngspice
from netlists.ngspice.engine import upward_crossings
from tests.netlists.foundry.test_process import mapping

__all__ = ["mapping"]  # a fixture

pytestmark = pytest.mark.usefixtures("ngspice_library")


def neuron(mapping: DeviceMapping) -> Circuit:
    return map_circuit(rebound_neuron.build(), mapping, Silicon(AMI_1500_IDEAL))


def spikes(
    circuit: Circuit, mapping: DeviceMapping, temperature_c: float = 27.0, **stimuli: float | None
) -> int:
    values = {"delay": 4e-3, "call": 1.0, "echo": 1.0, "duration": 12e-3, **stimuli}
    bench = rebound_neuron.testbench(circuit, values, mapping.v_dd)
    run = ngspice.run(
        format_foundry(bench, mapping, Silicon(temperature_c=temperature_c)), vectors=("spike",)
    )
    return int(upward_crossings(run.axis, run.values["spike"], 0.5 * mapping.v_dd).size)


def test_the_neuron_facilitates_on_the_foundry_s_process(mapping: DeviceMapping) -> None:
    circuit = neuron(mapping)
    assert spikes(circuit, mapping, echo=None) == 0
    assert spikes(circuit, mapping, call=None) == 0
    assert spikes(circuit, mapping) == 1
    assert spikes(circuit, mapping, delay=1.5e-3) == 0
    assert spikes(circuit, mapping, delay=8e-3) == 0


def test_the_deck_needs_no_other_file_and_has_only_literals(mapping: DeviceMapping) -> None:
    bench = rebound_neuron.testbench(
        neuron(mapping), {"delay": 4e-3, "call": 1.0, "echo": 1.0, "duration": None}, mapping.v_dd
    )
    deck = format_foundry(bench, mapping, Silicon())
    words = deck.lower().split()
    assert not {".lib", ".include"} & set(words)
    assert "agauss" not in deck
    assert "Apache License 2.0" in deck
    assert sum(line.startswith("m") for line in deck.splitlines()) == 34
    assert deck == format_foundry(bench, mapping, Silicon())
    m1 = next(line for line in deck.splitlines() if line.startswith("mm1 "))
    # 3 um by 6 um halved; area and perimeter with a diffusion of 0.48 um
    assert m1.startswith("mm1 v_mem v_r v_rest 0 nfet_03v3 w=1.5e-06 l=3e-06 m=1.0 ad=7.2e-13 ")
    assert "pd=3.96e-06" in m1


@pytest.mark.parametrize(
    ("bias", "device", "current"),
    [("i_inh_tau", "inhibition.mi5", 199.9e-12), ("i_lim", "axon.ma1", 6.3e-6)],
)
def test_a_bias_s_current_flows_in_the_foundry_s_device(
    mapping: DeviceMapping, bias: str, device: str, current: float
) -> None:
    found = neuron(mapping).bias(bias)
    placed = resized(rebound_neuron.build().device(device), mapping)  # type: ignore[arg-type]
    assert found.kind == "voltage"
    assert isinstance(found.value, float)
    gate = found.value if placed.polarity == "n" else mapping.v_dd - found.value
    _, swept = sweep_gate([placed], mapping, (gate, gate + 1e-4, 1e-4), mapping.temperature_c)
    # interpolation over 1 mV: the curvature of ln I is below 1e-2 / mV^2 where it bends most
    assert swept[0, 0] == pytest.approx(current, rel=2e-3)


def test_voltages_follow_the_supply_and_a_gate_keeps_its_current(mapping: DeviceMapping) -> None:
    circuit = neuron(mapping)
    assert circuit.bias("v_rest").value == pytest.approx(1.8 * 3.3 / 5.0)
    v_ex_max, silicon = circuit.bias("v_ex_max").value, Silicon(AMI_1500_IDEAL)
    assert isinstance(v_ex_max, float)
    ours = float(drain_current(silicon.law("p"), "p", 6e-6, 3e-6, 0.0, 4.301, 5.0, 5.0)[0])
    device = Transistor("me5", "p", "d", "g", "s", "b", 3e-6, 1.5e-6)
    gate = mapping.v_dd - v_ex_max
    _, swept = sweep_gate([device], mapping, (gate, gate + 1e-4, 1e-4), mapping.temperature_c)
    assert swept[0, 0] == pytest.approx(-ours, rel=2e-3)
    given = replace(mapping, biases={"v_rest": ("volts", 1.3)})
    assert map_circuit(rebound_neuron.build(), given, Silicon(AMI_1500_IDEAL)).bias("v_rest").value == 1.3
    with pytest.raises(UnknownNameError, match="excitatory_synapse device me9"):
        map_circuit(
            rebound_neuron.build(),
            replace(mapping, biases={"v_th": ("gate_of", "excitation.me9")}),
            Silicon(AMI_1500_IDEAL),
        )


def test_a_current_that_the_device_cannot_carry_is_refused(mapping: DeviceMapping) -> None:
    device = Transistor("m", "n", "d", "g", "s", "b", 1e-6, 1e-6)
    for current in (1.0, 1e-18):
        with pytest.raises(
            ParameterError, match=rf"m: {current:g} A, must be within .* which nfet_03v3 carries"
        ):
            gate_voltages([(device, current)], mapping)
    assert gate_voltages([], mapping) == []


def test_arrays_and_wide_devices(mapping: DeviceMapping) -> None:
    cell = Circuit(
        "cell",
        (Port("g", "analog"), Port("d", "analog", "out")),
        (Transistor("m", "n", "d", "g", "0", "0", 3e-6, 6e-6), Resistor("r", "d", "0", 1e6)),
    )
    array = InstanceArray("cell", cell, (2,), {"g": "g", "d": "d"}, {"m.width": (6e-6, 0.1e-6)})
    wide = Transistor("wide", "n", "g", "g", "0", "0", 500e-6, 1.5e-6, 2.0)
    circuit = Circuit("top", (Port("g", "analog"),), (wide,), (array,), (Node("d", (2,)),))
    deck = format_foundry(
        Testbench("t", map_circuit(circuit, mapping, Silicon(AMI_1500_IDEAL)), (), 1e-3), mapping, Silicon()
    )
    sizes = [line.split()[6:9] for line in deck.splitlines() if line.startswith("mm ")]
    assert sizes == [["w=3e-06", "l=3e-06", "m=1.0"], ["w=2.2e-07", "l=3e-06", "m=1.0"]]
    # 250 um: three times 83 um, for each of the two
    assert [
        float(w[2:]) for w in next(x for x in deck.splitlines() if x.startswith("mwide ")).split()[6:9:2]
    ] == (pytest.approx([250e-6 / 3, 6.0]))


def test_currents_of_both_polarities_rise_with_the_gate(mapping: DeviceMapping) -> None:
    devices = [Transistor("m", p, "d", "g", "s", "b", 3e-6, 3e-6) for p in ("n", "p")]
    axis, current = sweep_gate(devices, mapping, (0.2, 1.2, 0.1), 27.0)
    assert axis == pytest.approx(np.arange(0.2, 1.25, 0.1))
    assert (np.diff(current, axis=1) > 0.0).all()
    _, raised = sweep_gate(devices, mapping, (0.2, 1.2, 0.1), 27.0, source=0.3)
    assert (raised < current).all()  # the gate is told to the bulk


def test_without_the_package_there_is_no_deck(
    mapping: DeviceMapping, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(DataError, match="not installed"):
        map_circuit(rebound_neuron.build(), replace(mapping, package="none-such"), Silicon(AMI_1500_IDEAL))
