"""The plastic array on a chip: its rule, its weights between runs, events, refusals."""

from dataclasses import replace

import numpy as np
import pytest

from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.circuit import Params
from chips.rolls.plastic.circuit import Learning, plastic_chip
from chips.rolls.plastic.layout import OVER
from chips.rolls.plastic.program import PlasticArray
from chips.rolls.program.address import NEURONS
from chips.rolls.program.program import Program
from chips.rolls.setups.learning import learning_biases
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

SILENT = np.zeros((NEURONS, NEURONS), dtype=np.int8)
LATCHES = np.zeros((NEURONS, NEURONS), dtype=np.bool_)
LATCHES[:8, 200:208] = True
HIGH = np.zeros((NEURONS, NEURONS), dtype=np.bool_)
HIGH[:4, 200:204] = True


def chip_of(biases=None, die=1003, plastic=PlasticArray(LATCHES, HIGH), **options):  # noqa: B008 - frozen
    table = learning_biases() if biases is None else biases
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=die))
    return RollsChip(Program(SILENT, table, plastic=plastic), silicon, "ideal", **options)


@pytest.fixture(scope="module")
def chip():
    return chip_of()


def at(times, neuron, column):
    times = np.asarray(times, dtype=np.float64)
    return Inputs(times, np.full(times.size, neuron), np.full(times.size, column))


def calcium(chip, level):
    """The state at rest with the calcium's nodes as they are at a level of 0 to 3 thresholds passed."""
    state = chip.at_rest()
    filters = state.plastic.filters.copy()
    filters[OVER : OVER + level] = 1.8
    return replace(state, plastic=replace(state.plastic, filters=filters))


def test_weights_are_read_and_kept(chip):
    state = chip.at_rest()
    assert np.array_equal(chip.weights(state), HIGH)
    _, later = chip.run(state, 0.5)
    assert np.array_equal(chip.weight_voltages(later), chip.weight_voltages(state))


def test_an_event_moves_a_weight_down_only_with_little_calcium(chip):
    # the membrane rests at ground: down between the two lower thresholds, and not at all otherwise
    moved = []
    for level in range(4):
        _, after = chip.run(calcium(chip, level), chip.step, at([0.0], 0, 200))
        moved.append(float(1.8 - after.plastic.weights[0, 200]))
    built = chip.built().plastic.tables
    assert moved[1] == pytest.approx(built.down[200, 0], abs=1e-6)
    assert [m > 0.0 for m in moved] == [False, True, False, False]
    assert 0.05 < moved[1] < 0.3


def test_a_weight_drifts_to_its_nearer_rail_and_no_further(chip):
    state = chip.at_rest()
    volts = np.full((NEURONS, NEURONS), 0.7, np.float32)
    volts[0] = 1.1
    state = replace(state, plastic=replace(state.plastic, weights=volts))
    _, soon = chip.run(state, 0.02)
    rise, fall = chip.built().plastic.cells.rise, chip.built().plastic.cells.fall
    # float32 of a volt
    assert np.allclose(chip.weight_voltages(soon)[0], 1.1 + 0.02 * rise[:NEURONS], atol=1e-6)
    assert np.allclose(chip.weight_voltages(soon)[1], 0.7 - 0.02 * fall[NEURONS : 2 * NEURONS], atol=1e-6)
    _, late = chip.run(state, 2.0)
    assert set(np.unique(chip.weight_voltages(late)).tolist()) == {0.0, np.float32(1.8)}


def test_a_high_weight_drives_its_neuron_and_a_low_one_does_not(chip):
    times = np.repeat(np.arange(0.001, 0.2, 2e-3), 4)
    columns = np.tile(np.arange(200, 204), times.size // 4)
    counts = []
    for neuron in (0, 4):
        spikes, _ = chip.run(chip.at_rest(), 0.2, Inputs(times, np.full(times.size, neuron), columns))
        counts.append(int((spikes.neurons == neuron).sum()))
        assert set(spikes.neurons.tolist()) <= {neuron}
    assert counts[0] > 5
    assert counts[1] == 0


def test_a_spike_of_a_neuron_reaches_its_column_and_its_calcium():
    # neuron 3 runs on its own; its column's weights to 0 and 1 are high, that to 2 is not
    latches, high = np.zeros((2, NEURONS, NEURONS), np.bool_)
    latches[:3, 3], high[:2, 3] = True, True
    levels = SILENT.copy()
    levels[3, 7] = 4
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1003))
    program = Program(levels, learning_biases(), plastic=PlasticArray(latches, high))
    one = RollsChip(program, silicon, "ideal")
    times = np.arange(1e-3, 0.1, 2e-3)
    driven = Inputs(times, np.full(times.size, 3), np.full(times.size, 263))
    spikes, state = one.run(one.at_rest(), 0.1, driven)
    assert (spikes.neurons == 3).sum() > 10
    brought = state.plastic.filters - one.at_rest().plastic.filters
    assert brought[0, :2].min() > 0.0
    # neurons 0 and 1 may spike of it; a low weight brings nothing
    assert np.abs(brought[0, 2:]).max() < 1e-9
    assert brought[1, 3] > 0.0
    assert np.abs(brought[1, [2, 4]]).max() < 1e-9


def test_a_run_in_pieces_is_the_run_and_its_own_repeat(chip):
    draw = np.random.default_rng(0)
    times = np.sort(draw.uniform(0.0, 0.1, 2000))
    inputs = Inputs(times, draw.integers(0, 8, 2000), draw.integers(200, 208, 2000))
    begin = calcium(chip, 1)
    whole, after = chip.run(begin, 0.1, inputs)
    again, repeated = chip.run(begin, 0.1, inputs)
    assert np.array_equal(whole.times, again.times)
    assert np.array_equal(after.plastic.weights, repeated.plastic.weights)
    state, parts = begin, []
    for k in range(5):
        mine = (times >= 0.02 * k) & (times < 0.02 * (k + 1))
        part, state = chip.run(state, 0.02, Inputs(times[mine], inputs.neurons[mine], inputs.columns[mine]))
        parts.append(part.times)
    assert np.allclose(np.concatenate(parts), whole.times, atol=1e-6)
    assert np.array_equal(state.plastic.weights, after.plastic.weights)
    assert np.array_equal(state.plastic.pending, after.plastic.pending)


def test_weights_stay_when_the_temperature_changes(chip):
    begin = calcium(chip, 1)
    _, after = chip.run(begin, 0.04, at([0.01], 0, 200), temperature=lambda t: 27.0 if t < 0.02 else 40.0)
    assert after.temperature_c == 40.0
    assert np.array_equal(chip.weights(after), HIGH)


def test_an_event_must_be_of_a_latched_synapse(chip):
    with pytest.raises(ParameterError, match=r"chip.inputs: plastic column 5 of neuron 0, must be latched"):
        chip.run(chip.at_rest(), 0.01, at([0.0], 0, 5))


def test_what_needs_an_array_says_so(chip):
    silicon = Silicon(ROLLS_180_IDEAL)
    with pytest.raises(ParameterError, match=r"chip.learning: given, must have a plastic array"):
        RollsChip(Program(SILENT), silicon, learning=Learning())
    plain = RollsChip(Program(SILENT), silicon)
    with pytest.raises(ParameterError, match=r"chip.run.state: of a chip with another array"):
        chip.run(plain.at_rest(), 0.01)
    with pytest.raises(ParameterError, match=r"program.plastic: ndarray, must be a PlasticArray"):
        Program(SILENT, plastic=LATCHES)
    with pytest.raises(ParameterError, match=r"chip.weights: none"):
        plain.weights(plain.at_rest())
    with pytest.raises(ParameterError, match=r"learning.weight_threshold: 2 V, must be within"):
        Learning(weight_threshold=2.0)


def test_an_array_that_does_not_learn_is_told(chip):
    assert chip.cautions() == ()
    off = chip_of(learning_biases().with_code("PA_DELTAUP_P", 7, 0))
    assert any("PA_DELTAUP_P has fine code 0" in text for text in off.cautions())
    # a drift below the leaks of the shut switches
    weak = chip_of(learning_biases().with_code("PA_WDRIFTUP_P", 7, 0))
    assert any("leak more than they drift up" in text for text in weak.cautions())


def test_draws_of_the_chip_without_the_array_are_the_same(chip):
    plain = RollsChip(Program(SILENT, learning_biases()), chip.silicon, "ideal").built()
    assert np.array_equal(plain.tables.membranes.lines, chip.built().tables.membranes.lines)
    assert plain.gates == {k: chip.built().gates[k] for k in plain.gates}


def test_biases_of_the_array_name_its_devices():
    whole = plastic_chip(Params(), Learning())
    for bias in whole.biases:
        if bias.kind != "voltage":
            assert whole.device(bias.device or "").name
