"""The slow filter of the plastic synapses: a chip's mean current against a circuit of weight and filter."""

from dataclasses import replace

import numpy as np
import pytest

from chips.rolls.chip import STEP, Inputs, RollsChip
from chips.rolls.plastic.biases import CELL_BIASES
from chips.rolls.plastic.program import PlasticArray
from chips.rolls.program.program import Program
from chips.rolls.setups.learning import learning_biases
from circuits.blocks.ports import SUPPLY
from circuits.blocks.rest import started_at_rest
from circuits.blocks.rolls import dpi_synapse, plastic_synapse
from circuits.blocks.rolls.neuron import RESTING
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.event import pulse
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

LONG = 0.1  # s


def weight_and_filter(table):
    """A plastic synapse whose weight is held high, on the plastic filter."""
    cell, slow = plastic_synapse.build(), dpi_synapse.excitatory_filter(dpi_synapse.Params())
    own = [
        replace(
            b,
            device=f"cell.{b.device}" if b.device else None,
            value=table.current(CELL_BIASES[b.name]) if b.name in CELL_BIASES else b.value,
        )
        for b in plastic_synapse.BIASES
    ]
    own.append(Bias("i_tau", "f_tau", "gate", table.current("PDPI_TAU_P"), "filter.md3"))
    own.append(Bias("i_thr", "f_thr", "gate", table.current("PDPI_THR_P"), "filter.md4"))
    wires = {
        "vdd": "vdd",
        "line": "line",
        "v_syn": "v_syn",
        "i_out": "i_out",
        "v_tau": "f_tau",
        "v_thr": "f_thr",
    }
    instances = (
        Instance("cell", cell, cell.wired()),
        Instance("filter", slow, wires),
    )
    names = ("event", "up_b", "dn", "w", "low", "i_out")
    ports = (SUPPLY, *(Port(n, "analog") for n in names), *(Port(b.port, "bias") for b in own))
    return Circuit("weight_and_filter", ports, (), instances, biases=tuple(own))


def of_the_circuit(table, times, silicon):
    held = {"vdd": 1.8, "up_b": 1.8, "dn": 0.0, "i_out": 0.4, "w": 1.8}
    sources = (
        *(Source(name, name, Constant(v)) for name, v in held.items()),
        Source("event", "event", pulse(tuple(times), 1.8)),
    )
    bench = Testbench("weight and filter", weight_and_filter(table), sources, LONG)
    result = simulate(started_at_rest(bench, ROLLS_180_IDEAL), silicon)
    return -np.trapezoid(drain_current(result, "filter.md5"), result.time) / LONG


def of_the_chip(table, times, silicon):
    latches = np.zeros((256, 256), np.bool_)
    latches[0, 3] = True
    chip = RollsChip(Program(np.zeros((1, 1)), table, plastic=PlasticArray(latches, latches)), silicon)
    state, total, steps = chip.at_rest(), 0.0, round(LONG / STEP)
    for k in range(steps):
        now = times[np.round(times / STEP) == k]
        inputs = Inputs(np.full(now.size, state.time), np.zeros(now.size, np.int64), np.full(now.size, 3))
        _, state = chip.run(state, STEP, inputs)
        total += float(chip._plastic_scratch.output[0]) + RESTING
    return total / steps


def test_a_high_weights_mean_current_is_the_circuits():
    table, silicon = learning_biases(), Silicon(ROLLS_180_IDEAL)
    times = STEP * np.round(np.arange(5e-3, LONG, 0.01) / STEP)
    ours, theirs = (of(table, times, silicon) for of in (of_the_chip, of_the_circuit))
    # 2.2 % seen: one equation for v_syn and the line, as in the other filters
    assert ours == pytest.approx(theirs, rel=0.035)


def test_weights_of_a_die_have_their_own_capacitors():
    program = Program(np.zeros((256, 256), np.int8), learning_biases(), plastic=PlasticArray(np.ones((2, 2))))
    plain, varied = (
        RollsChip(program, Silicon(ROLLS_180_IDEAL, die=Die(number=1000, variation=v))).built().plastic
        for v in ("transistors", "full")
    )
    assert plain.cells.capacitance.size == 1
    share = varied.cells.capacitance / plain.cells.capacitance
    assert share.shape == (256 * 256,)
    assert 1e-4 < share.std() < 0.02
    assert varied.cells.rise * share == pytest.approx(plain.cells.rise, rel=1e-6)
    # a pulse is longer by its own capacitor: [pre, post]
    longer = (varied.lengths / plain.lengths)[:2, None]
    jumps = varied.tables.up[:2, :2] / plain.tables.up[:2, :2]
    assert jumps * share.reshape(256, 256)[:2, :2].T == pytest.approx(
        np.broadcast_to(longer, (2, 2)), rel=1e-5
    )
