"""Places: a lone block at its place on a chip is the chip's own part."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chips.ranging import circuit as ranging_chip
from circuits.bias import bias_voltages, rebias
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import BiasKind, Circuit, Instance, InstanceArray, Port
from circuits.devices import Resistor, Source, Transistor
from circuits.devices.source import Constant
from circuits.errors import UnknownNameError
from circuits.lowering.kernel import Machine, to_kernel
from circuits.place import circuit_at
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

CHIP = ranging_chip.build()
SUPPLY = (Source("vdd", "vdd", Constant(5.0)), Source("call", "call", Constant(0.0)))
QUIET = (*SUPPLY, Source("echo", "echo", Constant(0.0)))


def lower(circuit: Circuit, silicon: Silicon) -> Machine:
    return to_kernel(Testbench("quiet", circuit, QUIET, 1e-3), silicon)


def devices(machine: Machine, prefix: str) -> dict[str, tuple[float, float]]:
    """V_T0 and I_S of the transistors below `prefix`, by the rest of their path."""
    labels = [
        g.label(k)
        for g in machine.flat.groups
        if isinstance(g.device, Transistor)
        for k in range(g.nodes.shape[1])
    ]
    table = machine.kernel.transistors
    rows = zip(labels, table.v_t0.tolist(), table.specific_current.tolist(), strict=True)
    return {name.removeprefix(prefix): (v, i) for name, v, i in rows if name.startswith(prefix)}


@pytest.mark.parametrize(("k", "kind"), [(2, "gate"), (7, "ideal")])
def test_a_lone_neuron_at_its_place_is_the_chip_s(k: int, kind: BiasKind) -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1003))
    chip = lower(rebias(CHIP, kind=kind), silicon)
    neuron, place = circuit_at(rebias(CHIP, kind=kind), (("neuron", (k,)),))
    alone = lower(neuron, replace(silicon, place=place))
    assert devices(alone, "") == devices(chip, f"neuron[{k}].")
    inside, whole = operating_point(alone), operating_point(chip)
    for node in ("v_mem", "v_r", "v_inh_tau", "v_rslope"):
        path = {"v_mem": f"v_mem[{k}]", "v_r": f"neuron[{k}].membrane.v_r", "v_inh_tau": f"v_inh_tau[{k}]"}
        own = "membrane.v_r" if node == "v_r" else node
        assert inside[own] == pytest.approx(whole[path.get(node, node)], abs=1e-6)


def test_without_its_place_it_is_another() -> None:
    die = Die(number=1003)
    neuron, place = circuit_at(CHIP, (("neuron", (2,)),))
    there, elsewhere = (
        devices(lower(neuron, Silicon(AMI_1500_IDEAL, die=die, place=p)), "") for p in (place, None)
    )
    assert not set(there.values()) & set(elsewhere.values())


def test_the_generator_s_copies_are_shared_as_on_the_chip() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1))
    chip = rebias(CHIP, kind="ideal")
    neurons = [circuit_at(chip, (("neuron", (k,)),)) for k in (2, 3)]
    voltages = [
        {b.name: float(bias_voltages(c, b, replace(silicon, place=place))) for b in c.biases}
        for c, place in neurons
    ]
    for bias in chip.biases:
        whole = bias_voltages(chip, bias, silicon)
        for k, found in zip((2, 3), voltages, strict=True):
            assert found[bias.name] == float(np.broadcast_to(whole, (13,))[k])
    assert voltages[0]["i_rslope"] == voltages[1]["i_rslope"]
    assert voltages[0]["i_inh_tau"] != voltages[1]["i_inh_tau"]


def test_a_place_brings_the_chip_s_biases() -> None:
    neuron, _ = circuit_at(CHIP, (("neuron", (12,)),))
    assert neuron.bias("i_inh_tau").value == ranging_chip.I_INH_TAU[12]
    assert neuron.bias("v_th").value == rebound_neuron.build().bias("v_th").value
    assert {b.name: b.value for b in neuron.biases} == ranging_chip.neuron_biases(CHIP, 12)


@given(number=st.integers(0, 10**6), k=st.integers(0, 12), extra=st.integers(1, 4))
@settings(max_examples=15, deadline=None)
def test_edits_elsewhere_change_nothing(number: int, k: int, extra: int) -> None:
    """Other devices on the chip, and more neurons: neuron k stays what it is."""
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=number))
    array = CHIP.instances[0]
    wider = InstanceArray(
        "neuron", array.circuit, (13 + extra,), dict.fromkeys(array.connections, "0") | {"vdd": "vdd"}
    )
    added = tuple(
        Transistor(f"extra{i}", "n", "vdd", "0", "0", "0", 1e-6 * (i + 1), 1e-6) for i in range(extra)
    )
    edited = Circuit(CHIP.name, (Port("vdd", "supply"),), added, (wider,))
    path = (("neuron", (13,)), ("membrane", ()), ("m1", ()))
    before = np.asarray(silicon.deviation(CHIP.name, path, 18e-12).v_t0)
    after = np.asarray(silicon.deviation(edited.name, (("neuron", (13 + extra,)), *path[1:]), 18e-12).v_t0)
    assert before[k] == after[k]


def test_parameters_of_an_instance_reach_its_devices() -> None:
    part = Circuit("part", (Port("a", "analog"),), (Resistor("r", "a", "0", 1e3),))
    middle = Circuit("middle", (Port("a", "analog"),), (), (Instance("part", part, {"a": "a"}),))
    top = Circuit(
        "top",
        (Port("a", "analog"),),
        (),
        (InstanceArray("x", middle, (2,), {"a": "a"}, {"part.r.resistance": (2e3, 3e3)}),),
    )
    circuit, place = circuit_at(top, (("x", (1,)), ("part", ())))
    assert circuit.device("r") == replace(part.devices[0], resistance=3e3)  # type: ignore[type-var]  # a dataclass
    assert place == (("top", ()), ("x", (1,)), ("part", ()))


@pytest.mark.parametrize("path", [(("neuron", (13,)),), (("neuron", ()),), (("neurons", (0,)),)])
def test_what_is_not_there_is_refused(path: tuple[tuple[str, tuple[int, ...]], ...]) -> None:
    with pytest.raises(UnknownNameError, match=r"known are neuron\[0:13\]"):
        circuit_at(CHIP, path)
    with pytest.raises(UnknownNameError, match="it has no instances"):
        circuit_at(Circuit("empty"), path)
