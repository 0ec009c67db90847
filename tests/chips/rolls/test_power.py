"""Power of ROLLS: energies are charges times the supply, and sums add up."""

import numpy as np
import pytest

from chips.rolls.power import (
    Activity,
    Energies,
    activity_of,
    bias_power,
    chip_power,
    energies,
    generator_power,
)
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program, level_current
from circuits.blocks.bias import generator
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.power import supply_power
from circuits.solver.transient import simulate

THRESHOLD = 1.22e-10  # A, of the nominal neuron
PULSE = 22.9e-6  # s, of the nominal extender


@pytest.fixture(scope="module")
def found() -> Energies:
    return energies(default_biases(), Silicon(ROLLS_180_IDEAL), THRESHOLD)


@pytest.mark.parametrize(("level", "branches"), [(4, 2), (3, 2), (-1, 1), (-4, 1)])
def test_an_event_costs_its_charge_through_the_supply(found: Energies, level: int, branches: int) -> None:
    # excitation flows twice, through the pFETs and their mirror; the rest is gates and inverters that cross
    charge = level_current(default_biases(), level) * PULSE
    least = branches * charge * ROLLS_180_IDEAL.v_dd
    assert least < found.event[level] < 1.6 * least


def test_a_spike_costs_more_than_its_capacitors_and_less_at_higher_rates(found: Energies) -> None:
    capacitors = (2.1e-12 + 0.5e-12) * ROLLS_180_IDEAL.v_dd**2
    assert (found.spike > capacitors).all()
    assert (np.diff(found.rates) > 0.0).all()
    assert (np.diff(found.spike) < 0.0).all()
    assert found.spike_at(1e-3) == found.spike[0]


def test_power_is_the_sum_of_its_parts(found: Energies) -> None:
    still = found.biases + found.generator + found.rest
    assert found.power(0.0, {}) == pytest.approx(still, rel=1e-12)
    one, many = (found.power(100.0, {1: n}) for n in (1, 65536))
    assert many - one == pytest.approx(65535 * 100.0 * found.event[1], rel=1e-9)
    assert found.column > 256 * 1e-15


def test_parts_of_a_run_are_energies_times_counts(found: Energies) -> None:
    levels = np.zeros((256, 256), np.int8)
    levels[:5, 3], levels[7, 3], levels[:, 9] = 2, -1, 1
    program = Program(levels, default_biases())
    spikes = np.repeat([3, 3, 8], 50)
    power = chip_power(found, activity_of(program, spikes, {1: 40}, 0.5))
    rates = np.zeros(256)
    rates[3], rates[8] = 200.0, 100.0
    spike = 200.0 * float(found.spike_at(200.0)) + 100.0 * float(found.spike_at(100.0))
    assert power.dynamic["neurons"] == pytest.approx(spike, rel=1e-12)
    assert power.dynamic["columns"] == pytest.approx(300.0 * found.column, rel=1e-12)
    synapses = 200.0 * (5 * found.event[2] + found.event[-1])
    assert power.dynamic["synapses"] == pytest.approx(synapses, rel=1e-12)
    assert power.dynamic["virtual"] == pytest.approx(80.0 * found.virtual[1], rel=1e-12)
    quiet = chip_power(found, Activity(np.zeros(256)))
    assert quiet.parts["dynamic"] == 0.0
    assert power.parts["static"] == quiet.parts["static"] == pytest.approx(found.rest, rel=1e-12)
    assert power.total == pytest.approx(quiet.total + power.parts["dynamic"], rel=1e-12)
    assert power.total > quiet.total


def test_a_virtual_event_costs_its_charge_through_the_supply_twice(found: Energies) -> None:
    charge = default_biases().current("VA_EXC_N") * PULSE
    assert found.virtual[1] > 2.0 * charge * ROLLS_180_IDEAL.v_dd


def test_events_without_an_energy_and_a_run_without_a_duration_are_refused(found: Energies) -> None:
    with pytest.raises(ParameterError, match=r"power\.activity: 3 Hz at level 9"):
        chip_power(found, Activity(np.zeros(256), {9: 3.0}))
    program = Program(np.zeros((256, 256), np.int8), default_biases())
    with pytest.raises(ParameterError, match=r"power\.duration: 0 s"):
        activity_of(program, np.empty(0, np.int64), {}, 0.0)


def test_a_splitter_takes_its_whole_coarse_current_as_the_solved_generator_does() -> None:
    # fine code 1, so that the copies behind the splitter take next to nothing
    on, v_dd = Silicon(AMI_1500_IDEAL), AMI_1500_IDEAL.v_dd
    taken = []
    for coarse in (2, 5):
        circuit = generator.build(generator.Params(coarse=coarse, fine=1))
        bench = generator.testbench(circuit, {"output": 2.5, "duration": 1e-4}, v_dd)
        taken.append(supply_power(simulate(bench, on)))
    assert taken[0] - taken[1] == pytest.approx(v_dd * (0.4e-6 - 820e-12), rel=0.05)
    table, at = default_biases(), Silicon(ROLLS_180_IDEAL)
    more = generator_power(table.with_code("IF_TAU1_N", 2, 1), at) - generator_power(table, at)
    assert more == pytest.approx(1.8 * (0.4e-6 - 15e-12), rel=1e-9)


def test_biases_are_codes_times_the_supply_and_follow_the_absolute_temperature() -> None:
    table = default_biases()
    total = sum(table.current(name) for name in table.codes() if not table.is_off(name))
    at, hot = (bias_power(table, Silicon(ROLLS_180_IDEAL, t)) for t in (27.0, 57.0))
    assert at == pytest.approx(1.8 * total, rel=1e-12)
    assert hot / at == pytest.approx(330.15 / 300.15, rel=1e-12)


def test_a_current_that_makes_no_spike_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"power\.rheobase: 1e-13 A"):
        energies(default_biases(), Silicon(ROLLS_180_IDEAL), 1e-13)
