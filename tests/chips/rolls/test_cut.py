"""A row of ROLLS with its latched synapses is that die's very row."""

import numpy as np
import pytest

from chips.rolls.circuit import Params, chip
from chips.rolls.cut import cut_row, silicon_of
from chips.rolls.cut import testbench as bench_of
from chips.rolls.parts import devices_at, gate_voltages, part_gates, row_place
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program, VirtualInput
from circuits.bias import bias_voltages
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.devices import Transistor
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

SILICON = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1003))
TABLE = default_biases().with_code("IF_DC_P", 7, 0)
LEVELS = np.zeros((256, 256), np.int8)
LEVELS[5, 17], LEVELS[5, 40] = 4, -2
PROGRAM = Program(LEVELS, TABLE, tau1=(5,), inputs=(VirtualInput("in", (5, 6), 2),))


def test_devices_are_those_of_the_whole_chip() -> None:
    cut = cut_row(PROGRAM, 5)
    bench = bench_of(cut, {}, 1e-3, 1.8)
    machine = to_kernel(bench, silicon_of(cut, SILICON))
    labels = machine.flat.labels(Transistor)
    found = dict(zip(labels, machine.kernel.transistors.v_t0, strict=True))
    gates = gate_voltages(chip(Params(), TABLE), SILICON)
    s = dpi_synapse.Params()
    neuron = devices_at(
        rolls_neuron.build(), row_place(256, ("neuron", ())), SILICON, part_gates("neuron", gates)
    )
    for device in ("leak.ml4", "reset.mk5", "sodium.mn1"):
        assert found[f"row[0].neuron.{device}"] == neuron.fet[device].threshold[5]
    places = row_place(256, ("synapse", (256,)))
    synapses = devices_at(
        dpi_synapse.synapse(s), places, SILICON, part_gates("synapse", gates), ("me8", "mi4")
    )
    for element, column in enumerate((17, 40)):
        for device in ("me8", "mi4"):
            assert (
                found[f"row[0].synapse[{element}].{device}"]
                == synapses.fet[device].threshold[5 * 256 + column]
            )
    extenders = devices_at(
        dpi_synapse.pulse_extender(s), (("extender", (256,)),), SILICON, part_gates("extender", gates)
    )
    assert found["extender[1].mp2"] == extenders.fet["mp2"].threshold[40]
    places, own = row_place(256, ("virtual_exc", (4,))), part_gates("virtual_exc", gates)
    virtual = devices_at(dpi_synapse.synapse(s), places, SILICON, own, ("me2",))
    assert found["row[0].virtual_exc[1].me2"] == virtual.fet["me2"].threshold[5 * 4 + 1]


def test_biases_are_the_chip_s_also_from_the_generator() -> None:
    cut = cut_row(PROGRAM, 5, "ideal")
    on = silicon_of(cut, SILICON)
    gates = gate_voltages(chip(Params(), TABLE, "ideal"), SILICON)
    ports = {b.port for b in cut.circuit.biases}
    assert {"v_tau2", "v_pwlk", "excitatory_tau", "virtual_exc", "v_inh0"} <= ports
    for bias in cut.circuit.biases:
        assert float(bias_voltages(cut.circuit, bias, on)) == gates[bias.port]


def test_latches_leak_and_events_are_the_program_s() -> None:
    cut = cut_row(PROGRAM, 5)
    assert (cut.columns, cut.levels, cut.slow) == ((17, 40), (4, -2), True)
    bench = bench_of(cut, {"event[1]": pulse((1e-3,), 1.8)}, 1e-3, 1.8)
    level = {s.name: s.waveform for s in bench.sources}
    values = [getattr(level[f"{name}[0,1]"], "value", None) for name in dpi_synapse.LATCHES]
    assert values == list(dpi_synapse.latches(-2, 1.8).values())
    assert getattr(level["select"], "value", None) == 1.8
    assert {"event[0]", "virtual_exc_event[0,1]"} <= set(level)


def test_a_row_without_synapses_is_its_neuron_with_silent_filters() -> None:
    cut = cut_row(Program(np.zeros((4, 4), np.int8), TABLE), 9)
    assert cut.columns == ()
    to_kernel(bench_of(cut, {}, 1e-3, 1.8), silicon_of(cut, SILICON))


def test_the_nominal_die_needs_no_plan_and_a_257th_row_is_refused() -> None:
    cut, nominal = cut_row(PROGRAM, 6), Silicon(ROLLS_180_IDEAL)
    assert silicon_of(cut, nominal) is nominal
    with pytest.raises(ParameterError, match=r"row\[256\]: must be 0 to 255"):
        cut_row(PROGRAM, 256)
