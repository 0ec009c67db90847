"""Noise of the NEF chip: intervals against the closed form and the transistors, and what draws it."""

from dataclasses import replace

import numpy as np
import pytest

from chips.nef.build import build, moved
from chips.nef.chip import FIFO, NefChip
from chips.nef.kernel import advance_chip, new_chip_state
from chips.nef.model import neuron_charges
from chips.nef.network.curves import IdealCurves
from chips.nef.network.kernel import DT
from chips.nef.network.network import Ensemble, Network
from chips.nef.noise import copied
from chips.nef.simulation import Simulation
from chips.noise import SiliconNoise
from circuits.blocks.nef import neuron as nef_neuron
from circuits.blocks.nef.neuron import LEAK
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError
from circuits.generator.ripple import Ripple
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import ELEMENTARY_CHARGE, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import NoiseRun, simulate_noisy
from tests.chips.nef.paper import paper_chip
from tests.chips.nef.test_chip import one

N = 64
WHITE = SiliconNoise(1, flicker=WHITE_ONLY)
INPUT = 2.5  # thresholds, 0.1 nA


def driven(noise, silent_input=False):
    """Neurons without slots at one current, and their times of spikes."""
    built = build(Network((Ensemble("x", N),)), paper_chip(noise=noise).at(27.0), 1)
    chip = built.chip._replace(net=built.chip.net._replace(bias=np.full(N, INPUT)))
    own = None if noise is None else built.noise._replace(bias=np.full(N, 0.0 if silent_input else INPUT))
    return chip, own


def intervals(chip, noise, steps):
    """Times between spikes, s: where a membrane is tells when it last fired, to what a step's noise is."""
    state = new_chip_state(chip, FIFO)
    found, last = [], np.full(N, np.nan)
    for k in range(steps):
        before = state.base.spikes.copy()
        advance_chip(chip, state, 1, noise, None)
        fired = np.flatnonzero(state.base.spikes > before)
        # the refractory period began with the spike
        at = (k + 1) * DT - (chip.refractory[fired] - state.base.rest[fired] - DT) - DT
        found.append((at - last[fired])[np.isfinite(last[fired])])
        last[fired] = at
    return np.concatenate(found)


def expected(chip, current):
    """`[q (sum I) T + k T C] / (J - leak)^2 + q t_ref / I_rfr`, s^2; current: whose noise there is, A."""
    where = paper_chip().at(27.0)
    capacitance, emptied = neuron_charges(where.silicon, 1, where.biases)
    rising = LEAK * (INPUT - chip.leak[0])
    charging = LEAK / (rising * chip.speed[0])
    shot = ELEMENTARY_CHARGE * (current + LEAK * chip.leak[0]) * charging
    reset = ELEMENTARY_CHARGE * where.silicon.thermal_voltage * capacitance
    return (shot + reset) / rising**2 + ELEMENTARY_CHARGE * chip.refractory[0] ** 2 / emptied[0]


def test_intervals_vary_as_the_closed_form():
    chip, noise = driven(WHITE)
    found = intervals(chip, noise, 4000)
    quiet = intervals(*driven(None), 4000)
    assert quiet.std() < 1e-9
    assert found.mean() == pytest.approx(quiet.mean(), rel=1e-3)
    # 18,000 intervals know the deviation to 0.5 %; the step in which a spike falls has a little less noise
    assert found.std() == pytest.approx(np.sqrt(expected(chip, LEAK * INPUT)), rel=0.03)


def test_jitter_is_the_transistors():
    """With an ideal source as input, whose current makes no noise."""
    given = {"current": INPUT * LEAK, "duration": 0.9}
    machine = to_kernel(
        nef_neuron.testbench(nef_neuron.build(), given, ROLLS_180_IDEAL.v_dd), Silicon(ROLLS_180_IDEAL)
    )
    result = simulate_noisy(machine, NoiseRun(1, 20e-6, WHITE_ONLY), record=("v_mem",))
    theirs = np.diff(result.spikes["spike"])[1:]
    chip, noise = driven(WHITE, silent_input=True)
    ours = intervals(chip, noise, 1000)
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.02)
    # about 60 intervals know their deviation to 9 %: three of those
    assert ours.std() == pytest.approx(theirs.std(ddof=1), rel=0.27)


def lines(noise, seed=1, **fields):
    run = Simulation(build(one(60), paper_chip(Die(number=3), noise=noise, **fields).at(27.0), seed))
    run.set("in", 0.4)
    run.advance(0.3)
    return run.read("x?"), run.state.u.copy()


def same(a, b):
    return all((x == y).all() for x, y in zip(a, b, strict=True))


def test_draws_are_of_seed_and_die_alone():
    quiet, noisy = lines(None), lines(SiliconNoise(1))
    assert same(lines(None), quiet)
    assert same(lines(SiliconNoise(1)), noisy)
    for other in (None, WHITE, SiliconNoise(2), SiliconNoise(1, trial=1)):
        assert not same(lines(other), noisy)
    # a per mille of the radius and decoding's own noise
    assert noisy[0] == pytest.approx(quiet[0], abs=0.05)


def test_a_chip_whose_noise_is_nothing_is_one_without():
    built = build(one(60), paper_chip(noise=SiliconNoise(1)).at(27.0), 1)
    n = copied(built.noise)
    nothing = n._replace(
        grain=0.0, reset=0.0, dead=0.0 * n.dead, lanes=0.0 * n.lanes,
        slow=n.slow._replace(deviation=0.0 * n.slow.deviation),
    )  # fmt: skip
    runs = [Simulation(b) for b in (replace(built, noise=nothing), replace(built, noise=None))]
    for run in runs:
        run.set("in", 0.4)
        run.advance(0.2)
    assert (runs[0].state.u == runs[1].state.u).all()
    assert (runs[0].state.y == runs[1].state.y).all()


def test_noise_goes_along_to_another_temperature():
    built = build(one(60), paper_chip(noise=WHITE).at(27.0), 1)
    hot = moved(built, paper_chip(noise=WHITE).at(60.0))
    assert hot.noise is not None
    assert (hot.noise.dead != built.noise.dead).any()
    assert build(one(60), IdealCurves(), 1).noise is None


def test_a_filters_noise_is_that_of_its_capacitor():
    """A state that only noise moves keeps `q kappa / (C U_T)` of its own square."""
    built = build(one(60), paper_chip(noise=WHITE).at(27.0), 1)
    chip, noise = built.chip, copied(built.noise)
    state, found = new_chip_state(chip, FIFO), []
    for _ in range(4000):
        advance_chip(chip._replace(first=chip.first), state, 1, noise, None)
        found.append(state.s.copy())
    moving = np.flatnonzero(noise.lanes > 0.0)
    relative = np.array(found)[200:, moving]
    u_t = Silicon(ROLLS_180_IDEAL).thermal_voltage
    expected_variance = ELEMENTARY_CHARGE * 0.75 / (6.06e-12 * u_t)
    quiet = relative.std(axis=0) / relative.mean(axis=0)
    # the first lane is a node's and still; spikes move the others by more
    assert quiet.min() == pytest.approx(np.sqrt(expected_variance), rel=0.25)


def test_lines_move_all_neurons_as_other_currents_do():
    """A ripple too slow to see stands, as a leak and a refractory current that are so much larger."""
    ripple = SiliconNoise(1, flicker=WHITE_ONLY, ripple=Ripple(20e-3, 50.0))
    built = build(one(60), NefChip(neurons=64, noise=ripple).at(27.0), 1)
    lines = built.noise.lines
    assert lines.shift.size == 3
    assert (lines.ripple > 1e-5).all()
    held = lines._replace(
        white=0.0 * lines.white,
        pace=1e-9,
        phase=0.0,
        lag=np.full(3, 0.5 * np.pi),
        ripple=np.array([0.4, 0.05, 0.0]),
    )
    n = copied(built.noise)
    nothing = n._replace(grain=0.0, reset=0.0, dead=0.0 * n.dead, lanes=0.0 * n.lanes, lines=held)
    c = built.chip
    other = c._replace(leak=1.4 * c.leak, refractory=c.refractory / 1.05)
    found = []
    for chip, noise in ((c, nothing), (other, None)):
        run = Simulation(replace(built, chip=chip, noise=noise))
        run.set("in", 0.4)
        run.advance(1.0)
        found.append(run.state.spikes.astype(float))
    quiet = Simulation(replace(built, noise=None))
    quiet.set("in", 0.4)
    quiet.advance(1.0)
    fast = found[1] > 50.0
    # the refractory period is lengthened by its draw once a spike, to first order
    assert found[0][fast] == pytest.approx(found[1][fast], rel=0.01, abs=1.0)
    assert found[1][fast].sum() != pytest.approx(quiet.state.spikes[fast].sum(), rel=0.01)


def test_a_ripple_on_fixed_gates_is_refused():
    chip = paper_chip(noise=SiliconNoise(1, ripple=Ripple(20e-3, 50.0)))
    with pytest.raises(
        ParameterError, match=r"nef_chip\.i_leak: ripple of 20 mV at 50 Hz on a bias of kind gate"
    ):
        build(one(60), chip.at(27.0), 1)
