"""The chip's circuit with cells of depression: sound, the same silicon but for them, and cut as a row."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.rolls.circuit import Params, chip
from chips.rolls.cut import cut_row, silicon_of
from chips.rolls.cut import testbench as bench_of
from chips.rolls.depression.circuit import CELLS, check_cell, depressing_chip
from chips.rolls.depression.model import CELL_DEVICES
from chips.rolls.depression.program import ShortTermDepression
from chips.rolls.parts import devices_at, gate_voltages, row_place
from chips.rolls.plastic.circuit import Learning, plastic_chip
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from circuits.bias import bias_voltages
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls.depressing_synapse import Params as CellParams
from circuits.blocks.rolls.depressing_synapse import depression
from circuits.circuit import Circuit
from circuits.devices import Transistor
from circuits.errors import ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

SILICON = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1003))
TABLE = default_biases().with_code("IF_DC_P", 7, 0).with_code("NPA_WEIGHT_STD_N", 5, 36)
LEVELS = np.zeros((256, 256), np.int8)
LEVELS[5, 17], LEVELS[5, 40] = 4, -2
STD = ShortTermDepression()


@pytest.mark.parametrize(
    "base", [chip(Params(), TABLE, "ideal"), plastic_chip(Params(), Learning(), TABLE, "ideal")]
)
def test_biases_of_the_chip_without_are_as_they_were(base: Circuit) -> None:
    made = depressing_chip(base, STD, TABLE, "ideal")
    before, after = gate_voltages(base, SILICON), gate_voltages(made, SILICON)
    assert {k: after[k] for k in before} == before
    assert set(after) - set(before) == {"depression_std", "depression_rec"}


@pytest.fixture(scope="module")
def thresholds() -> tuple[dict[str, float], dict[str, float]]:
    """Of the cut's transistors, with depression and without."""
    found = []
    for program in (Program(LEVELS, TABLE, depression=STD), Program(LEVELS, TABLE)):
        cut = cut_row(program, 5)
        machine = to_kernel(bench_of(cut, {}, 1e-3, 1.8), silicon_of(cut, SILICON))
        labels = machine.flat.labels(Transistor)
        found.append(dict(zip(labels, machine.kernel.transistors.v_t0.tolist(), strict=True)))
    return found[0], found[1]


def test_a_row_has_the_transistors_of_one_without(
    thresholds: tuple[dict[str, float], dict[str, float]],
) -> None:
    after, before = thresholds
    assert {name: after[name] for name in before} == before
    assert len(after) - len(before) == 2 * 3 * 8  # of two synapses, three cells with eight transistors each


def test_cells_of_a_cut_are_those_of_the_whole_chip(
    thresholds: tuple[dict[str, float], dict[str, float]],
) -> None:
    for name in CELLS:
        place = row_place(256, (name, (256,)))
        d = devices_at(depression(STD.cell), place, SILICON, {}, CELL_DEVICES)
        for device in ("ms3", "mr1"):
            own = thresholds[0][f"row[0].{name}[1].{device}"]
            assert own == d.fet[device].threshold[5 * 256 + 40]


def test_a_cut_has_the_chip_s_biases_and_a_row_without_synapses_no_cells() -> None:
    cut = cut_row(Program(LEVELS, TABLE, depression=STD), 5, "ideal")
    gates = gate_voltages(depressing_chip(chip(Params(), TABLE, "ideal"), STD, TABLE, "ideal"), SILICON)
    on = silicon_of(cut, SILICON)
    for bias in cut.circuit.biases:
        assert float(bias_voltages(cut.circuit, bias, on)) == gates[bias.port]
    assert {"depression_std", "depression_rec"} <= {b.port for b in cut.circuit.biases}
    empty = cut_row(Program(LEVELS, TABLE, depression=STD), 6)
    assert not any("depression" in i.name for i in empty.circuit.instances)
    to_kernel(bench_of(empty, {}, 1e-3, 1.8), silicon_of(empty, SILICON))


def test_a_cell_of_another_synapse_is_refused() -> None:
    other = CellParams(synapse=replace(dpi_synapse.Params(), weight_length=2.0))
    with pytest.raises(ParameterError, match=r"depression.cell.synapse: of other sizes"):
        check_cell(ShortTermDepression(cell=other), Params().synapse)
