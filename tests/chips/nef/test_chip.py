"""Calibration, codes, limits, drops and temperature of the NEF chip."""

import numpy as np
import pytest

from chips.nef.build import build, exchanged, moved
from chips.nef.chip import CODE, FIFO, NefChip
from chips.nef.kernel import DROPPED, SPIKES, WAITING, advance_chip, new_chip_state
from chips.nef.network.curves import IdealCurves
from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Network, Neurons, Node, Probe
from chips.nef.simulation import Simulation
from circuits.circuit import BiasKind
from circuits.errors import ParameterError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from tests.chips.nef.paper import paper_chip

DIE = Die(number=42)


def one(neurons: int, dimensions: int = 1, radius: float = 1.0) -> Network:
    return Network(
        (Ensemble("x", neurons, dimensions, radius=radius),),
        (Node("in", dimensions),),
        (Connection("in", "x"),),
        (Probe("x?", "x", synapse=0.05),),
    )


def represented(chip: NefChip) -> Simulation:
    """A run of a chip whose 300 neurons have been given a vector for 0.4 s."""
    run = Simulation(build(one(300, 2, 0.7), chip.at(27.0), 1))
    run.set("in", [0.4, -0.2])
    run.advance(0.4)
    return run


@pytest.mark.parametrize("kind", ["gate", "ideal", "generator"])
def test_calibration_trims_the_median_neuron(kind: BiasKind) -> None:
    chip = NefChip(DIE, kind, calibration_c=60.0, neurons=1024, process=ROLLS_180_IDEAL)
    law = chip.at(60.0).law
    # a swing is PTAT unless gates are fixed, and so is the leak; steps of a bias are 1 %, half a code 1.5 %
    wanted = 1.0 if kind == "gate" else float(np.median(law.charge / paper_chip().at(27.0).law.charge[0]))
    assert float(np.median(law.leak)) == pytest.approx(wanted, rel=0.011 if kind == "gate" else 0.02)
    assert float(np.median(law.refractory)) == pytest.approx(2e-3, rel=0.02)
    assert law.leak.std() > 0.03  # each neuron's own stays


def test_codes_give_currents_to_half_a_step_on_a_nominal_chip() -> None:
    chip = paper_chip().at(27.0)
    bias = np.array([-20.0, -0.3, 0.0, 3.1, 50.0])
    codes = chip.bias_codes(bias)
    assert np.abs(chip.bias(0, codes) - bias).max() <= 0.51 * chip.unit
    row = np.array([5.0, -12.0, 100.0])
    codes = chip.codes(row, 2.0, 1)
    assert codes[0, 2] == CODE  # 200 thresholds at full scale, where a stage gives 127
    above, below = chip.stage(0, 1, codes)
    assert above[:2] == pytest.approx(codes[0, :2] * chip.unit)
    assert below[:2] == pytest.approx(-codes[0, :2] * chip.unit)


def test_more_columns_give_more() -> None:
    chip = paper_chip().at(27.0)
    codes = chip.codes(np.array([1.0, -0.5]), 440.0, 4)
    assert codes.shape == (4, 2)
    assert np.abs(codes).max() <= CODE
    assert chip.stage(0, 1, codes)[0] == pytest.approx(np.array([440.0, -220.0]) / 0.88, rel=2e-3)


@pytest.mark.parametrize("number", [None, 42])
def test_an_ensemble_represents_what_it_is_given(number: int | None) -> None:
    run = represented(paper_chip(Die(number=number)))
    # 300 neurons, 50 ms: a per cent of the radius, and as much of decoding
    assert run.read("x?") == pytest.approx([0.4, -0.2], abs=0.03)
    assert run.counters["spikes"] > 1000
    assert run.counters["dropped"] == run.counters["lost"] == 0


def test_what_is_beyond_full_scale_is_counted() -> None:
    run = Simulation(build(one(30), paper_chip().at(27.0), 1))
    run.set("in", 5.0)
    run.advance(0.1)
    assert run.counters["clipped"] == 100
    assert run.counters["lost"] > 90


def test_the_router_lets_spikes_wait_and_drops_the_rest() -> None:
    built = build(one(200), paper_chip().at(27.0), 1)
    assert built.chip is not None
    narrow = built.chip._replace(budget=2)
    state = new_chip_state(narrow, FIFO)
    advance_chip(narrow, state, 300, None, None)
    fired, dropped = state.counters[SPIKES], state.counters[DROPPED]
    assert state.counters[WAITING] == FIFO
    # two a step got through, but for the first steps, and the ring is full
    assert 2 * 290 + FIFO <= fired - dropped <= 2 * 300 + FIFO
    wide = new_chip_state(built.chip, FIFO)
    advance_chip(built.chip, wide, 300, None, None)
    assert wide.counters[DROPPED] == 0


def test_a_neuron_fires_at_its_rate_even_twice_a_step() -> None:
    built = build(Network((Ensemble("x", 3),)), paper_chip().at(27.0), 1)
    assert built.chip is not None
    driven = built.chip._replace(
        net=built.chip.net._replace(bias=np.array([0.9, 6.0, 300.0])), refractory=np.full(3, 2e-4)
    )
    state = new_chip_state(driven, FIFO)
    advance_chip(driven, state, 2000, None, None)
    period = 2e-4 + built.chip.speed**-1.0 / (np.array([1.0, 6.0, 300.0]) - built.chip.leak + 1e-12)
    assert state.base.spikes[0] == 0
    assert state.base.spikes[1:] == pytest.approx(2.0 / period[1:], abs=1.5)
    assert state.base.spikes[2] > 2 * 2000


def test_an_inhibited_membrane_stops_at_the_floor() -> None:
    built = build(Network((Ensemble("x", 2),)), paper_chip().at(27.0), 1)
    assert built.chip is not None
    driven = built.chip._replace(net=built.chip.net._replace(bias=np.array([-400.0, 0.0])))
    state = new_chip_state(driven, FIFO)
    advance_chip(driven, state, 100, None, None)
    assert state.base.u == pytest.approx(built.chip.floor)


def test_temperature_moves_what_was_calibrated() -> None:
    chip = NefChip(DIE, "ideal", neurons=256)
    built = build(one(200), chip.at(27.0), 1)
    off = []
    for there in (
        built,
        moved(built, chip.at(60.0)),
        build(one(200), NefChip(DIE, "ideal", {}, 60.0, 256).at(60.0), 1),
    ):
        run = Simulation(there)
        run.set("in", -0.9)
        run.advance(0.4)
        off.append(abs(float(run.read("x?")[0]) + 0.9))
    assert off[1] > 3.0 * max(off[0], off[2])  # old decoders on a warm chip; new ones make it good again


def test_another_dies_decoders_are_worse() -> None:
    own, other = (build(one(300), paper_chip(Die(number=k)).at(27.0), 1) for k in (50, 51))
    rms = []
    for built in (own, exchanged(own, other)):
        run, seen = Simulation(built), []
        for x in (-0.7, -0.2, 0.3, 0.8):
            run.set("in", x)
            run.advance(0.5)
            seen.append(float(run.read("x?")[0]) - x)
        rms.append(float(np.sqrt(np.mean(np.square(seen)))))
    assert rms[1] > 1.5 * rms[0]  # one pair; `noctule reproduce nef-chip` asks three times of twenty


def test_area_takes_mismatch_away() -> None:
    small, large = (paper_chip(DIE, neurons=500, area=a).at(27.0).law.leak.std() for a in (1.0, 100.0))
    assert large == pytest.approx(0.1 * small, rel=0.2)


def test_what_has_no_room_is_refused() -> None:
    chip = paper_chip(neurons=100).at(27.0)
    with pytest.raises(ParameterError, match=r"x: neurons up to number 101, the chip has 100; take fewer"):
        build(one(101), chip, 0)
    with pytest.raises(ParameterError, match=r"x: 70 dimensions .* 71 encoder columns, the chip has 64"):
        build(one(80, 70), chip, 0)
    many = Network((EnsembleArray(Ensemble("x", 1), 90), Ensemble("y", 5)), (Node("in", 90),), tuple(
        Connection("in", "x", synapse=tau) for tau in (0.01, 0.02, 0.03, 0.04, 0.05, 0.06)
    ))  # fmt: skip
    with pytest.raises(ParameterError, match=r"nef-chip: 540 filters, the chip has 512; take fewer"):
        build(many, chip, 0)


def test_functions_of_the_wrong_shape_or_without_a_value_are_refused() -> None:
    chip = paper_chip(neurons=100).at(27.0)
    for function, says in ((lambda x: x[:, 0], "shape"), (lambda x: x * np.nan, "not finite")):
        network = Network((Ensemble("x", 20),), (), (Connection("x", "x", function),))
        with pytest.raises(ParameterError, match=rf"x->x.function: {says}"):
            build(network, chip, 0)


def test_chips_that_cannot_be() -> None:
    with pytest.raises(UnknownNameError, match="bias of the NEF chip i_leek"):
        NefChip(biases={"i_leek": 1e-12})
    with pytest.raises(ParameterError, match=r"nef-chip.i_leak: -1e-12, must be above 0"):
        NefChip(biases={"i_leak": -1e-12})
    with pytest.raises(ParameterError, match=r"nef-chip.area: 0, must be from 0.01"):
        NefChip(area=0.0)
    with pytest.raises(ParameterError, match=r"network: on ideal neurons"):
        moved(build(one(5), IdealCurves(), 0), paper_chip().at(27.0))


def test_a_bias_that_is_set_is_what_the_chip_is_trimmed_to() -> None:
    slow = paper_chip(DIE, biases={"i_leak": 20e-12}, neurons=200).at(27.0).law.leak
    assert float(np.median(slow)) == pytest.approx(0.5, rel=0.02)


def test_currents_into_neurons_silence_them() -> None:
    network = Network(
        (Ensemble("x", 100),),
        (Node("in", 1), Node("stop", 1)),
        (Connection("in", "x"), Connection("stop", Neurons("x"), transform=-100.0)),
    )
    run = Simulation(build(network, paper_chip(DIE).at(27.0), 1))
    run.set("in", 0.9)
    run.advance(0.2)
    before = run.spikes
    run.set("stop", 1.0)
    run.advance(0.1)
    at = run.spikes
    run.advance(0.2)
    assert before > 1000
    assert run.spikes == at
