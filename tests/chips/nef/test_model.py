"""Lumped numbers beside the circuits that they are of, on dies that nothing was made from."""

from dataclasses import replace

import numpy as np
import pytest

from chips.nef.calibration import LEAST_MIDDLE, USUAL, trimmed
from chips.nef.circuit import chip_biases, column, filters, lines, neurons
from chips.nef.devices import PLACE, design_tau
from chips.nef.model import column_on, filters_on, lines_on, middle_over_leak, neurons_on, unit_of
from circuits.blocks.drive import powered
from circuits.blocks.nef import encoder as nef_encoder
from circuits.blocks.nef import synapse as nef_synapse
from circuits.blocks.nef.neuron import LEAK
from circuits.circuit import BiasKind
from circuits.lowering.check import check_circuit
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from system.papers.checks.nef_chip import rate_errors


@pytest.mark.parametrize(
    ("die", "temperature", "kind"), [(3100, 0.0, "gate"), (3101, 60.0, "gate"), (3102, 27.0, "ideal")]
)
def test_rates_are_the_transistor_circuits(die: int, temperature: float, kind: BiasKind) -> None:
    # the requirement; `noctule reproduce nef-chip` has 20 dies, three temperatures and both kinds
    assert np.abs(rate_errors(die, temperature, kind, (0.1, 1.0))).max() < 0.03


@pytest.mark.parametrize("process", [ROLLS_180_IDEAL, ROLLS_180])
def test_capacitors_that_deviate_move_rates_and_time_constants(process: Process) -> None:
    # the capacitors of die 3302 are 2.6 % more than drawn
    assert np.abs(rate_errors(3302, 27.0, "gate", (0.1, 1.0), process, "full")).max() < 0.01
    plain, full = (
        Silicon(process, die=Die(number=3302, variation=extent)) for extent in ("transistors", "full")
    )
    taus, biases = np.full(3, design_tau()), chip_biases()
    more = filters_on(full, taus, biases).tau / filters_on(plain, taus, biases).tau
    # of the filter's capacitance 4 % is a gate's
    assert more == pytest.approx(np.full(3, 1.025), abs=1e-3)
    assert len(set(more.tolist())) == 3


def test_a_stage_of_the_chip_is_its_circuit() -> None:
    die, number, code = Die(number=3103), 5, 37
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, die)
    found = column_on(silicon, 2, number + 1, chip_biases())
    on = (code >> np.arange(nef_encoder.BITS)) & 1
    there = Silicon(ROLLS_180_IDEAL, 27.0, die, (*PLACE, ("column", (2,)), ("stage", (number,))))
    bench = nef_encoder.testbench(nef_encoder.build(), {"code": code, "step": None}, ROLLS_180_IDEAL.v_dd)
    current = nef_encoder.measures(simulate(bench, there))["current_A"]
    assert current is not None
    a, b = float((on * found.signal[number]).sum()), float((on * found.reference[number]).sum())
    # the testbench's other bank has a twentieth of the unit
    expected = (a - 0.05 * b * found.mirror[number]) * 40e-12
    assert current == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("code", [0, 37, -37])
def test_what_a_stage_lets_through_in_the_heat_is_its_circuit_s(code: int) -> None:
    place = (*PLACE, ("column", (2,)), ("stage", (5,)))
    silicon = Silicon(ROLLS_180, 60.0, Die(number=3103), place)
    column_ = column_on(replace(silicon, place=None), 2, 6, chip_biases())
    v_dd = ROLLS_180.v_dd
    waves = {"i_out": nef_encoder.MEMBRANE, "v_pos": v_dd, "v_neg": v_dd, **nef_encoder.bits_of(code, v_dd)}
    bench = Testbench("stage", nef_encoder.build(), powered(v_dd, waves), 1e-6)
    found = float(nef_encoder.output_current(simulate(bench, silicon))[-1]) / LEAK
    told, sunk = column_.still(slice(5, 6), np.array([code]), (column_.off, column_.off))
    # either half lets half a threshold through; without switches, or what the mirror draws more, 0.1 were off
    assert told[0] == pytest.approx(found, abs=0.02)
    assert 0.3 < sunk[0] < 3.0


def test_a_filter_s_middle_is_trimmed_to_be_above_its_leak() -> None:
    silicon = Silicon(ROLLS_180, -10.0, Die(number=14))  # slow, so that its middle was below
    biases = trimmed(silicon, "gate", (), 64)
    assert middle_over_leak(silicon, USUAL, biases) > LEAST_MIDDLE
    assert filters_on(silicon, np.full(1, USUAL), biases).power > 0.5


def test_a_filter_is_its_circuit() -> None:
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=3104, mismatch=False))
    biases = chip_biases()
    found = filters_on(silicon, np.array([design_tau()]), biases)
    bench = nef_synapse.testbench(nef_synapse.build(), {"step": 0.3, "duration": 0.08}, ROLLS_180_IDEAL.v_dd)
    measured = nef_synapse.measures(simulate(bench, silicon))
    full = nef_synapse.LINE_UNITS * unit_of(silicon, biases) * 40e-12
    assert measured["time_constant_s"] == pytest.approx(found.tau[0], rel=0.03)
    # the pair's own strong inversion is left out: 3 % at the middle
    assert (measured["middle_A"] or 0.0) / full == pytest.approx(found.gain[0], rel=0.05)


def test_nominal_neurons_are_alike_and_a_dies_are_not() -> None:
    biases = chip_biases()
    nominal, own = (neurons_on(Silicon(ROLLS_180_IDEAL, 27.0, d), 50, biases) for d in (Die(), Die(number=1)))
    assert nominal.leak == pytest.approx(np.ones(50))
    assert own.leak.std() / own.leak.mean() == pytest.approx(0.065, rel=0.4)  # 2 um^2, 50 neurons
    assert (
        own.head(7).leak.tolist()
        == neurons_on(Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1)), 7, biases).leak.tolist()
    )


def test_lines_split_where_the_sum_is_the_reference() -> None:
    found = lines_on(Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1)), 64, chip_biases())
    for part in found[:3]:
        assert part.std() / part.mean() < 0.06  # mirrors of 32 um^2


def test_the_neurons_are_a_sound_circuit() -> None:
    check_circuit(neurons(2))
    assert [c.instances[0].shape for c in (column(3), filters(4), lines(5))] == [(3,), (4,), (5,)]
