"""A chip's first neurons alone: to the bit what they do among all, and left whole where they would not."""

import numpy as np
import pytest

from chips.aer import Bus, send
from chips.noise import SiliconNoise
from chips.rolls.brief.encoded import encode
from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.program.bias_file import BiasTable, default_biases
from chips.rolls.program.program import Program, VirtualInput
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon

USED, WINDOW = 20, 40e-3
FAST = default_biases().with_code("IF_DC_P", 7, 0).with_code("VA_EXC_N", 0, 200)
SLOW = default_biases()
for _name, _code in {  # excitation of some 20 ms, and little inhibition
    "IF_DC_P": (7, 0), "VA_EXC_N": (2, 100), "VDPIE_TAU_P": (7, 43), "VDPIE_THR_P": (6, 98),
    "VA_INH_P": (6, 100),
    "NPDPIE_TAU_P": (7, 43),
}.items():  # fmt: skip
    SLOW = SLOW.with_code(_name, *_code)


def program_of(pre: int = 3, biases: BiasTable = SLOW) -> Program:
    """Twenty neurons that virtual synapses excite and inhibit, of which one excites another."""
    levels = np.zeros((256, 256), np.int8)
    levels[7, pre] = 4
    everywhere = tuple(range(USED))
    inputs = VirtualInput("excite", everywhere, 4), VirtualInput("inhibit", everywhere, 4, inhibitory=True)
    return Program(levels, biases, inputs=inputs)


def chip_of(program: Program, noise: SiliconNoise | None = None, bus: Bus | None = None) -> RollsChip:
    return RollsChip(program, Silicon(ROLLS_180, die=Die("A", 3)), "generator", bus=bus, noise=noise)


def events() -> Inputs:
    """Many excitations of the twenty, fewer inhibitions, in bursts."""
    rng = np.random.default_rng(2)
    times = np.sort(np.repeat(rng.uniform(0.0, WINDOW, 6000), 5))
    columns = np.where(rng.random(times.size) < 0.9, 512, 516) + np.arange(times.size) % 4
    return Inputs(times, rng.integers(USED, size=times.size), columns)


@pytest.mark.parametrize("noise", [None, SiliconNoise(4)], ids=["quiet", "noisy"])
def test_the_first_neurons_alone_do_what_they_do_among_all(noise: SiliconNoise | None) -> None:
    whole, given = chip_of(program_of(), noise), events()
    rest = whole.at_rest()
    few, first = whole.of_first(USED, rest)
    assert first.values.shape[1] == 64
    wanted, after = whole.run(rest, WINDOW, given)
    found, there = few.run(first, WINDOW, given)
    assert wanted.neurons.max() < USED
    assert wanted.neurons.size > 20
    assert wanted.lost_in == found.lost_in
    assert np.array_equal(found.times, wanted.times)
    assert np.array_equal(found.neurons, wanted.neurons)
    assert np.array_equal(there.values, after.values[:, :64])
    arrived = send(few.bus, given.times, given.neurons + (given.columns << 8))
    encoded = encode(arrived, few.step, round(WINDOW / few.step), USED)
    assert encoded is not None
    for chip, state in ((few.in_trial(0), first), (whole.in_trial(0), rest)):
        again = chip.run_encoded(state, encoded)
        assert again is not None
        assert np.array_equal(again.times, wanted.times)
        assert np.array_equal(again.neurons, wanted.neurons)
        assert (again.lost_in, again.lost_out) == (wanted.lost_in, wanted.lost_out)


def test_neurons_that_take_steps_in_parts_ask_for_single_events() -> None:
    whole, given = chip_of(program_of(biases=FAST)), events()
    rest = whole.at_rest()
    arrived = send(whole.bus, given.times, given.neurons + (given.columns << 8))
    encoded = encode(arrived, whole.step, round(WINDOW / whole.step), USED)
    wanted, _ = whole.run(rest, WINDOW, given)
    assert encoded is not None
    assert whole.run_encoded(rest, encoded) is None
    again, _ = whole.run(rest, WINDOW, given)  # of what was begun nothing is left
    assert np.array_equal(again.times, wanted.times)
    silent = encode(send(whole.bus, given.times[:0], given.neurons[:0]), whole.step, 10, USED)
    assert silent is not None
    spikes = whole.run_encoded(rest, silent)
    assert spikes is not None
    assert spikes.times.size == 0


@pytest.mark.parametrize(
    ("program", "bus"),
    [(program_of(pre=200), None), (program_of(), Bus(service=10e-6)), (program_of(), Bus(depth=255))],
    ids=["another excites it", "a slow bus", "a short line"],
)
def test_what_hangs_on_other_neurons_stays_whole(program: Program, bus: Bus | None) -> None:
    whole = chip_of(program, bus=bus)
    rest = whole.at_rest()
    found, state = whole.of_first(USED, rest)
    assert found is whole
    assert state is rest


def test_nothing_else_is_asked_of_the_first_neurons() -> None:
    whole = chip_of(program_of())
    few, first = whole.of_first(USED, whole.at_rest())
    with pytest.raises(ParameterError, match=r"chip.inputs: neuron 64, must be of the first 64"):
        few.run(first, 4e-3, Inputs(np.zeros(1), np.array([64]), np.array([512])))
    with pytest.raises(ParameterError, match=r"chip.at_rest: its first 64 neurons, must be whole"):
        few.at_rest()
    with pytest.raises(ParameterError, match=r"chip: its first 64 neurons at 40 degC, must be whole there"):
        few.run(first, 4e-3, temperature=40.0)
    assert few.of_first(64, first)[0] is few
