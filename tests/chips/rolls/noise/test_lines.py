"""How far lines of the generator move ROLLS' currents, against the noise of the generator's transistors."""

from dataclasses import replace

import numpy as np
import pytest

from chips.noise import SiliconNoise
from chips.rolls.circuit import Params, chip
from chips.rolls.noise.layout import LINE_DIRECT, LINE_LEAK
from chips.rolls.noise.model import generator_lines
from chips.rolls.parts import devices_at, gate_voltages, part_gates, row_place
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from circuits.blocks.ports import SUPPLY
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.circuit import Circuit
from circuits.devices import Resistor, Source, Transistor
from circuits.devices.noise import noise_model
from circuits.devices.source import Constant
from circuits.generator.circuit import line, line_sizes, masters
from circuits.generator.code import codes_of
from circuits.generator.voltage import resistor_of
from circuits.lowering.kernel import to_kernel
from circuits.lowering.on_die import transistor_of
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.analysis import noise
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

PROGRAM = Program(np.zeros((NEURONS, NEURONS), np.int8), default_biases())
CHIP, NEURON = chip(Params(), PROGRAM.biases, "generator"), rolls_neuron.build()
LOAD, STEP = 1e3, 0.4e-3  # Ohm, s
SHARE = 0.03  # of a density by which both may differ: the device ends at the supply, not at its node


def by_transistors(biased: Transistor, current: float, silicon: Silicon) -> tuple[float, float]:
    """White noise and flicker at 1 Hz of a line's current over its square, 1/Hz, by the generator's devices.

    The masters, the line at its code and the device that it biases are one circuit; the device's own noise
    is left out.
    """
    (coarse, fine), sizes = codes_of(np.array([current]))[0], line_sizes(silicon.process)
    own = [
        replace(
            d, **{n: f"range_{coarse}" for n in ("drain", "gate", "source") if getattr(d, n) == "range_n"}
        )
        for d in line(int(fine), biased, sizes[coarse])
    ]
    ground, other = ("0", "vdd") if biased.polarity == "n" else ("vdd", "0")
    size = biased.width, biased.length, biased.multiplicity
    output = Transistor("biased", biased.polarity, "out", f"v_{biased.polarity}", ground, ground, *size)
    devices = (
        *masters(resistor_of(silicon.process), sizes),
        *own,
        output,
        Resistor("load", other, "out", LOAD),
    )
    supply = Source("vdd", "vdd", Constant(silicon.process.v_dd))
    bench = Testbench("line", Circuit("line", (SUPPLY,), devices), (supply,), 1e-3)
    point = operating_point(to_kernel(bench, silicon))
    found = noise(point, "out", np.array([1.0]), model=noise_model(silicon.process))
    made = [k for k, name in enumerate(found.devices) if name not in {"biased", "load"}]
    over = float(point.voltage[point.machine.column_of("out")])
    drop = silicon.process.v_dd - over if biased.polarity == "n" else over
    return float(found.white[0, made].sum()) / drop**2, float(found.flicker[0, made].sum()) / drop**2


def test_currents_move_as_much_as_the_transistors_of_the_generator_make_them() -> None:
    for temperature in (-10.0, 27.0, 60.0):
        silicon = Silicon(ROLLS_180, temperature)
        gates = part_gates("neuron", gate_voltages(CHIP, silicon))
        d = devices_at(NEURON, row_place(NEURONS, ("neuron", ())), silicon, gates)
        ours = generator_lines(Params(), silicon, d, PROGRAM, "generator", SiliconNoise(1), STEP)
        held = 2.0 * STEP * np.exp2(ours.doubled)
        # an nFET in weak inversion, and a pFET of 88 nA in strong inversion
        for k, bias, name in ((LINE_LEAK, "i_tau2", "leak.ml4"), (LINE_DIRECT, "i_dc", "leak.ml9")):
            current = float(np.ravel(np.asarray(CHIP.bias(bias).value))[0])
            white, flicker = by_transistors(transistor_of(NEURON, name), current, silicon)
            assert (ours.white[k] ** 2).sum() * held[k] == pytest.approx(white, rel=SHARE)
            assert (ours.follow[k] ** 2).sum() == pytest.approx(flicker, rel=SHARE)
