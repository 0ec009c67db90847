"""The model's delays are those of the transistor level, on the same devices of the same dies."""

from dataclasses import replace

import numpy as np
import pytest

from chips.wavefront.axon_graph import AxonGraph, grid_graph
from chips.wavefront.axon_record import axon_record
from chips.wavefront.model import (
    LOCAL,
    SINK,
    TAIL,
    axon_delays,
    axon_draws,
    axon_model,
    chip_model,
    dies_delays,
    edge_delays,
    input_delay,
)
from circuits.bias import rebias
from circuits.blocks.wavefront import axon_delay
from circuits.blocks.wavefront.axon_linearity import delay_at, delay_machine
from circuits.blocks.wavefront.grid import CHIP, Params, build, firing_times, plan_testbench
from circuits.circuit import BiasKind
from circuits.devices import Transistor
from circuits.errors import DataError, ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.place import circuit_at
from circuits.silicon.components import Extent
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

# Of the delay: what the model leaves out, the axon's other devices, and interpolation; sinks spread by 4.4 %.
RMS, LARGEST = 5e-4, 2.5e-3
CODES = 1, 3, 9, 20, 31
BOTH = pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500], ids=lambda p: p.effects)


@BOTH
@pytest.mark.parametrize(
    ("temperature", "variation"), [(27.0, "plain"), (-10.0, "full"), (27.0, "full"), (60.0, "full")]
)
@pytest.mark.parametrize("kind", ["gate", "ideal", "generator"])
def test_a_lone_axon_has_the_delay_of_its_circuit(
    kind: BiasKind, temperature: float, variation: Extent, process: Process
) -> None:
    circuit = rebias(axon_delay.build(), kind=kind)
    model = axon_model(circuit, process)
    errors = []
    for number in range(1000, 1004):
        silicon = Silicon(process, temperature, Die(number=number, variation=variation))
        machine = delay_machine(circuit, silicon)
        for code in CODES:
            ours = float(axon_delays(model, silicon, np.array(code))[()])
            errors.append(ours / delay_at(machine, code) - 1.0)
    assert np.sqrt(np.mean(np.square(errors))) < RMS
    assert np.abs(errors).max() < LARGEST


@BOTH
@pytest.mark.parametrize("variation", ["plain", "full"])
@pytest.mark.parametrize("kind", ["gate", "ideal", "generator"])
def test_an_axon_of_the_chip_is_the_very_one_at_its_place(
    kind: BiasKind, variation: Extent, process: Process
) -> None:
    chip = rebias(CHIP.build(), kind=kind)
    silicon = Silicon(process, die=Die(number=1001, variation=variation))
    model = chip_model((20, 20), process, bias_kind=kind)
    codes = np.random.default_rng(1).integers(1, 32, (20, 20))
    delays = axon_delays(model, silicon, codes)
    for index in ((0, 0), (3, 4), (19, 19)):
        circuit, place = circuit_at(chip, (("axon", index),))
        machine = delay_machine(circuit, replace(silicon, place=place))
        solved = delay_at(machine, int(codes[index]))
        assert delays[index] == pytest.approx(solved, rel=LARGEST)


def test_the_draws_are_those_of_the_transistor_level() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1002, process=False))
    found = axon_draws(chip_model((2, 3)), silicon)
    grid = np.ones((2, 3), dtype=np.int64)
    bench = plan_testbench(build(Params(2, 3)), grid, (0, 0), 1e-3, 5.0)
    machine = to_kernel(bench, silicon)
    shift = machine.kernel.transistors.v_t0 - np.where(machine.kernel.transistors.sign > 0.0, 0.60, 0.85)
    labels = [
        g.label(k)
        for g in machine.flat.groups
        if isinstance(g.device, Transistor)
        for k in range(g.nodes.shape[1])
    ]
    own = {name: shift[labels.index(f"axon[1,2].{name}")] for name in (SINK, *LOCAL, TAIL)}
    assert found.sink[5] == pytest.approx(own[SINK], abs=1e-15)
    assert found.tail[5] == pytest.approx(own[TAIL], abs=1e-15)
    assert found.local[5] == pytest.approx([own[name] for name in LOCAL], abs=1e-15)


@BOTH
def test_a_wave_through_transistors_takes_the_delays_of_the_model(process: Process) -> None:
    silicon = Silicon(process, die=Die(number=1004))
    codes = np.array([[2, 1, 1]])
    bench = plan_testbench(build(Params(1, 3)), codes, (0, 0), 0.6e-3, 5.0)
    times = firing_times(simulate(bench, silicon))[0]
    delays = axon_delays(chip_model((1, 3), process), silicon, codes)[0] + input_delay(silicon)
    assert np.diff(times) == pytest.approx(delays[:2], rel=LARGEST)


def test_edges_carry_their_sender_s_delay_and_blocked_cells_none() -> None:
    graph = grid_graph(2, 3)
    codes = np.array([1, 2, 3, 4, 0, 31])
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1000))
    edges = edge_delays(graph, codes, silicon)
    cells = axon_delays(chip_model((2, 3)), silicon, codes) + input_delay(silicon)
    assert edges.shape == (graph.edges,)
    assert np.array_equal(edges, cells[graph.sources()])
    assert np.isinf(edges[graph.sources() == 4]).all()
    assert np.isfinite(edges[graph.sources() != 4]).all()


def test_a_graph_without_a_grid_has_axons_in_a_row() -> None:
    grid = grid_graph(1, 3)
    row = AxonGraph(grid.offsets, grid.targets, grid.inputs)
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1000))
    codes = np.array([1, 1, 1])
    assert not np.allclose(edge_delays(row, codes, silicon), edge_delays(grid, codes, silicon), rtol=1e-4)


def test_nominal_delays_are_the_codes_in_units() -> None:
    codes = np.arange(1, 32)
    for unit in (20e-6, 100e-6, 1e-3):
        delays = axon_delays(chip_model((31,), unit=unit), Silicon(AMI_1500_IDEAL), codes)
        slope, offset = np.polyfit(codes, delays, 1)
        # the unit is the mean step; the fixed charge cancels the comparator's delay at the usual unit alone
        assert slope == pytest.approx(unit, rel=2e-3)
        assert abs(offset) < 2e-6 + 0.03 * unit


def test_a_unit_under_the_full_law_is_that_of_the_same_currents() -> None:
    codes = np.arange(1, 32)
    shares = []
    for unit in (20e-6, 100e-6, 1e-3):
        delays = axon_delays(chip_model((31,), AMI_1500, unit=unit), Silicon(AMI_1500), codes)
        shares.append(np.polyfit(codes, delays, 1)[0] / unit)
    # the ramp's mean of 3.5 V over the diode's gate, at an Early voltage of 120 V: 2.4 % less at most
    assert shares == pytest.approx([shares[1]] * 3, rel=3e-3)
    assert 0.97 < shares[1] < 0.99


def test_many_dies_are_the_single_ones() -> None:
    model, silicon = chip_model((2, 2)), Silicon(AMI_1500_IDEAL)
    codes = np.array([[1, 5], [9, 0]])
    dies = [Die(number=k) for k in (1000, 1001)]
    found = dies_delays(model, silicon, codes, dies)
    for row, die in zip(found, dies, strict=True):
        here = replace(silicon, die=die)
        assert np.array_equal(row, axon_delays(model, here, codes).ravel() + input_delay(here))


def test_a_larger_area_spreads_less_by_pelgrom() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1000))
    small, large = (axon_draws(chip_model((20, 20), area=a), silicon) for a in (1.0, 4.0))
    assert large.sink == pytest.approx(0.5 * small.sink)
    assert large.local == pytest.approx(0.5 * small.local)


def test_outside_the_record_is_refused() -> None:
    model, codes = chip_model((1,)), np.array([1])
    with pytest.raises(ParameterError, match=r"wavefront_chip\.temperature: 80 degC, must be -10 to 65 degC"):
        axon_delays(model, Silicon(AMI_1500_IDEAL, temperature_c=80.0), codes)
    with pytest.raises(ParameterError, match=r"wavefront_chip\.unit: 1e-06 s, must be"):
        chip_model((1,), unit=1e-6)
    with pytest.raises(ParameterError, match=r"wavefront_chip\.area: 0 times"):
        chip_model((1,), area=0.0)
    slow = replace(AMI_1500_IDEAL, variation=replace(AMI_1500_IDEAL.variation, sigma_v_t0=0.5))
    with pytest.raises(ParameterError, match="use the transistor level"):
        axon_delays(model, Silicon(slow, die=Die(number=1000)), codes)


@pytest.mark.parametrize("codes", [[32], [-1], [1, 2]])
def test_codes_that_are_none_are_refused(codes: list[int]) -> None:
    with pytest.raises(ParameterError, match="must be 1 whole numbers from 0 to 31"):
        axon_delays(chip_model((1,)), Silicon(AMI_1500_IDEAL), np.array(codes))


def test_a_record_of_another_circuit_is_refused() -> None:
    other = replace(axon_record(), key="0")
    with pytest.raises(DataError, match="noctule characterise"):
        chip_model((1,), record=other)
