"""The ROLLS chip against the behavioural models of its blocks, and its bus, program and temperature."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from chips.aer import Bus
from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.circuit import Params, chip, row
from chips.rolls.layout import Z
from chips.rolls.neuron.model import respond
from chips.rolls.program.address import NEURONS, VirtualSynapses
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program, VirtualInput
from chips.rolls.synapse.reference import filter_errors
from chips.validity import outside_boxes
from circuits.errors import ParameterError
from circuits.event import WIDTH
from circuits.lowering.capacitors_on_die import added_capacitance
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

SILENT = np.zeros((NEURONS, NEURONS), dtype=np.int8)
QUIET = default_biases().with_code("IF_DC_P", 7, 0).with_code("VA_EXC_N", 3, 200)


def chip_of(
    levels=SILENT, biases=QUIET, inputs=(), temperature=27.0, die=1003, process=ROLLS_180_IDEAL, **options
):
    silicon = Silicon(process, temperature, die if isinstance(die, Die) else Die(number=die))
    return RollsChip(Program(levels, biases, inputs=inputs), silicon, **{"kind": "gate", **options})


def every(inputs, columns, times):
    """Events at `times` to all pairs of a neuron and a column."""
    pairs = [(k, c) for k in inputs for c in columns]
    t = np.repeat(times, len(pairs))
    neurons = np.tile([k for k, _ in pairs], len(times))
    return Inputs(t, neurons, np.tile([c for _, c in pairs], len(times)))


DRIVEN = default_biases().with_code("IF_DC_P", 5, 150)  # all neurons run on a direct current, about 100 Hz


@pytest.fixture(scope="module")
def driven():
    return chip_of(biases=DRIVEN)


def spikes_beside_the_neurons(driven):
    """Times of six neurons' spikes on the chip, and as the behavioural neurons have them, s."""
    spikes, _ = driven.run(driven.at_rest(), 0.5)
    neurons = driven.built().neurons
    few = neurons._replace(**{k: getattr(neurons, k)[:6] for k in neurons._fields})
    expected = respond(few, np.zeros((5000, 6)), 1e-4, np.zeros((6, 3))).spikes
    return [(spikes.times[spikes.neurons == k], expected[k]) for k in range(6)]


# 0.15 and 0.6 % seen: one evaluation a step against parts of 3 mV; the error goes with the step's square
@pytest.mark.parametrize(("step", "off"), [(0.2e-3, 5e-3), (0.4e-3, 1e-2)])
def test_rates_are_the_behavioural_neurons(step, off):
    for ours, theirs in spikes_beside_the_neurons(chip_of(biases=DRIVEN, step=step)):
        assert abs(ours.size - theirs.size) <= 1
        assert np.diff(ours).mean() == pytest.approx(np.diff(theirs).mean(), rel=off)
        assert ours[0] == pytest.approx(theirs[0], rel=1e-2)


@pytest.mark.parametrize("process", [ROLLS_180_IDEAL, ROLLS_180], ids=["ideal", "full"])
@pytest.mark.parametrize(("level", "rate"), [(1, 300.0), (-1, 100.0)])
def test_filters_are_the_behavioural_synapses(level, rate, process):
    levels = SILENT.copy()
    levels[:3, 7] = level
    chip = chip_of(levels, process=process)
    errors = filter_errors(chip, level, 7, range(3), np.arange(5e-3, 0.05, 1.0 / rate), 0.06)
    # 3.6 % seen: one equation for v_syn and the line; 5 % is what charges may be off under the full law
    assert np.abs(errors).max() < (0.04 if process is ROLLS_180_IDEAL else 0.05)


def test_rates_are_the_behavioural_neurons_under_the_full_law():
    for ours, theirs in spikes_beside_the_neurons(chip_of(biases=DRIVEN, process=ROLLS_180)):
        # 1.5 %: the step, as under the ideal law, and what I_dc changes over v_mem
        assert np.diff(ours).mean() == pytest.approx(np.diff(theirs).mean(), rel=1.5e-2)


def test_capacitors_of_a_die_are_those_of_its_circuit():
    levels = SILENT.copy()
    levels[:2, :3] = 1
    plain, varied = (
        chip_of(levels, die=Die(number=1003, variation=v)).built() for v in ("transistors", "full")
    )
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1003, variation="full"))
    names = ("row.neuron.leak.c_mem", "row.excitatory.c_syn", "extender.c_pw")
    more = added_capacitance(chip(), silicon, names)
    drawn = Params().neuron.membrane_capacitance, Params().synapse.synapse_capacitance
    moved = varied.neurons.capacitance - plain.neurons.capacitance
    assert moved == pytest.approx(more["row.neuron.leak.c_mem"], rel=1e-9)
    assert np.abs(moved / drawn[0]).max() > 0.01
    ratio = varied.filters[0].unit / plain.filters[0].unit - 1.0
    # what transistors add to the node does not deviate
    assert ratio == pytest.approx(more["row.excitatory.c_syn"] / drawn[1], rel=0.2)
    # I_pwlk fills the capacitor for all of the pulse but what the event itself lasts
    longer = (varied.lengths - plain.lengths) / (plain.lengths - WIDTH)
    expected = more["extender.c_pw"] / Params().synapse.pulse_capacitance
    assert longer == pytest.approx(expected, rel=0.2)


def test_neurons_of_a_die_differ(driven):
    spikes, _ = driven.run(driven.at_rest(), 0.5)
    rates = np.bincount(spikes.neurons, minlength=NEURONS) / 0.5
    assert 0.01 < rates.std() / rates.mean() < 0.5


def test_a_run_in_pieces_is_the_run(driven):
    whole, _ = driven.run(driven.at_rest(), 0.1)
    state, times = driven.at_rest(), []
    for _ in range(5):
        part, state = driven.run(state, 0.02)
        times.append(part.times)
    assert np.allclose(np.concatenate(times), whole.times, atol=1e-6)


def test_same_die_same_bits():
    biases = default_biases().with_code("IF_DC_P", 5, 150)
    one, two = (c.run(c.at_rest(), 0.05)[0] for c in (chip_of(biases=biases), chip_of(biases=biases)))
    assert np.array_equal(one.times, two.times)
    assert np.array_equal(one.neurons, two.neurons)


def test_a_chip_that_was_pickled_is_the_same_chip(driven):
    whole, _ = driven.run(driven.at_rest(), 0.05)
    other, _ = pickle.loads(pickle.dumps(driven)).run(driven.at_rest(), 0.05)
    assert whole.times.size > 0
    assert np.array_equal(other.times, whole.times)
    assert np.array_equal(other.neurons, whole.neurons)


def test_a_silent_chip_is_silent():
    chip = chip_of()
    assert not chip.restless().any()
    assert chip.run(chip.at_rest(), 0.2)[0].times.size == 0


def test_virtual_events_excite_and_recurrence_inhibits():
    # neurons 0 to 9 are driven and inhibit 10 to 19, which are driven alike
    levels = SILENT.copy()
    levels[10:20, 0:10] = -1
    biases = QUIET.with_code("NPA_WEIGHT_INH_N", 3, 100)
    target = VirtualInput("drive", tuple(range(20)))
    times = np.arange(0.001, 0.3, 0.002)
    counts = {}
    for name, chosen in (("free", SILENT), ("inhibited", levels)):
        chip = chip_of(chosen, biases, (target,))
        spikes, _ = chip.run(chip.at_rest(), 0.3, every(range(20), (512, 513), times))
        counts[name] = np.bincount(spikes.neurons, minlength=NEURONS)
    assert counts["free"][:20].min() > 5
    assert counts["free"][20:].sum() == 0
    assert counts["inhibited"][10:20].sum() < 0.5 * counts["free"][10:20].sum()


def test_program_reaches_the_synapse_of_its_address():
    levels = SILENT.copy()
    levels[7, 3] = 4
    chip = chip_of(levels)
    times = np.arange(0.001, 0.1, 0.001)
    spikes, _ = chip.run(chip.at_rest(), 0.1, every((7,), (256 + 3,), times))
    assert set(spikes.neurons) == {7}
    spikes, _ = chip.run(chip.at_rest(), 0.1, every((7,), (256 + 4,), times))
    assert spikes.times.size == 0


def test_a_narrow_bus_drops_and_counts():
    biases = default_biases().with_code("IF_DC_P", 5, 150)
    chip = chip_of(biases=biases, bus=Bus(service=1e-4, depth=1))
    spikes, _ = chip.run(chip.at_rest(), 0.1)
    assert spikes.lost_out > 0


def test_temperature_may_change_in_a_run():
    chip = chip_of(biases=default_biases().with_code("IF_DC_P", 5, 150), kind="gate")
    warm, _ = chip.run(chip.at_rest(), 0.1, temperature=lambda t: 27.0 if t < 0.05 else 30.0)
    before = (warm.times < 0.05).sum()
    # a fixed gate gives 4 to 5 % a kelvin more current
    assert (warm.times > 0.05).sum() > 1.05 * before


@pytest.mark.parametrize(
    ("inputs", "text"),
    [
        (Inputs(np.array([0.1]), np.array([256]), np.array([512])), "neuron 256"),
        (Inputs(np.array([0.1]), np.array([0]), np.array([520])), "column 520"),
        (Inputs(np.array([0.1]), np.array([0]), np.array([5])), "column 5"),
        (Inputs(np.array([-0.1]), np.array([0]), np.array([512])), "an event at"),
        (Inputs(np.array([np.nan]), np.array([0]), np.array([512])), "an event at nan s"),
    ],
)
def test_inputs_that_it_does_not_have(driven, inputs, text):
    with pytest.raises(ParameterError, match=text):
        driven.run(driven.at_rest(), 0.01, inputs)


def test_step_must_be_positive():
    with pytest.raises(ParameterError, match=r"chip\.step"):
        chip_of(step=0.0)


@pytest.mark.parametrize("counts", [(0, 0), (0, 2), (4, 4)])
def test_extenders_of_the_columns_keep_their_bias(counts):
    params = Params(virtual=VirtualSynapses(*counts))
    assert [b.device for b in chip(params).biases if b.name == "i_pwlk"] == ["extender.mp2"]
    assert ("v_pwlk" in {p.name for p in row(params).ports}) == any(counts)


def test_a_virtual_synapse_that_no_input_has_is_refused():
    one = chip_of()
    with pytest.raises(ParameterError, match=r"column 512.*declare a VirtualInput"):
        one.run(one.at_rest(), 0.01, every((3,), (512,), [0.005]))


def test_a_filter_at_the_end_of_its_table_is_counted():
    levels = SILENT.copy()
    levels[5, 7] = -4
    # 44 uA: an event brings 26,000 of the 262,000 that the table has
    one = chip_of(levels)
    with outside_boxes("warn"):
        few, _ = one.run(one.at_rest(), 0.02, every((5,), (256 + 7,), [0.001]))
        many, _ = one.run(one.at_rest(), 0.02, every((5,), (256 + 7,), np.full(20, 0.001)))
    assert few.held == 0
    assert many.held > 0


def test_what_was_not_measured_is_said():
    assert chip_of().cautions() == ()
    (long,) = chip_of(biases=QUIET.with_code("NPA_PWLK_P", 6, 100)).cautions()
    assert "raise NPA_PWLK_P" in long
    levels = SILENT.copy()
    levels[5, 7] = -4
    (strong,) = chip_of(levels).cautions()
    assert "level -4 draws" in strong
    with outside_boxes("warn") as left:
        chip_of(levels).at_rest()
    (outside,) = left.texts()
    assert outside.startswith("rolls_chip.synapse.level[-4].inversion: 5.39, must be 0 to 0.2, where")
    with pytest.raises(ParameterError, match=r"level\[-4\]\.inversion: 5.39, .*; take a smaller weight"):
        chip_of(levels).at_rest()


@pytest.mark.parametrize(("temperature", "says"), [(-0.5, "-0.5 degC, must be 0"), (60.5, "60.5 degC, must")])
def test_outside_its_temperatures_a_chip_is_refused(temperature, says):
    with pytest.raises(ParameterError, match=rf"rolls_chip\.temperature: {says}"):
        chip_of(temperature=temperature).at_rest()
    cold = chip_of()
    with pytest.raises(ParameterError, match=rf"rolls_chip\.temperature: {says}"):
        cold.run(cold.at_rest(), cold.step, temperature=temperature)
    with outside_boxes("warn") as left:
        chip_of(temperature=temperature).at_rest()
    assert len(left.texts()) == 1


def test_all_spikes_of_the_step_before_are_delivered_however_many():
    """A step at another temperature may have had more spikes than one at this can have."""
    levels = SILENT.copy()
    levels[3, 7] = 1
    chip = chip_of(levels)
    rest, drawn = chip.at_rest(), []
    for count in (1, 3 * NEURONS):
        chip.run(replace(rest, senders=np.full(count, 7)), chip.step)
        drawn.append(chip.synaptic_currents()[0][3])
    assert drawn[1] > 10.0 * drawn[0]


def test_a_run_is_of_whole_steps(driven):
    with pytest.raises(ParameterError, match=r"chip.run.duration: 0.001 s, must be whole steps of 0.0004 s"):
        driven.run(driven.at_rest(), 1e-3)


def test_an_idle_filter_rests_where_its_leaks_are_alike():
    # hot, leaks of a row's idle synapses are a sixth of the filter's own leak
    chip = chip_of(temperature=60.0)
    state = chip.at_rest()
    _, later = chip.run(state, 0.2)
    shapes = chip.built().shapes
    for k in range(2):
        drift = shapes[k].log_of(later.values[Z + k]) - shapes[k].log_of(state.values[Z + k])
        # ln u: a hundredth of a current, what the grid on which the rest is looked for has
        assert np.abs(drift).max() < 0.02


def test_regular_spikes_are_those_of_short_steps_up_to_a_spike_a_step():
    fast = default_biases().with_code("IF_DC_P", 3, 60)
    found = []
    for step in (0.4e-3, 0.02e-3):
        chip = chip_of(biases=fast, step=step)
        spikes, _ = chip.run(chip.at_rest(), 0.032)
        first = [spikes.times[spikes.neurons == k].min() for k in range(NEURONS)]
        found.append((np.bincount(spikes.neurons, minlength=NEURONS), np.array(first)))
    (ours, first), (fine, their_first) = found
    interval = 0.032 / fine.mean()
    assert interval < 1.5e-3
    assert ours.sum() == pytest.approx(fine.sum(), rel=5e-3)
    assert np.abs(ours - fine).max() <= 1
    assert np.abs(first - their_first).max() < 0.1 * interval
