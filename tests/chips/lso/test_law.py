"""Closed forms against numerical integration of the same equations, and their limits."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chips.lso.law import (
    Comparator,
    Gate,
    Membrane,
    Steps,
    carried,
    lso_spikes,
    mirrored,
    moved,
    ramp_delay,
    rest_depth,
    rise_time,
    segments,
    spike_delay,
)
from circuits.lowering.on_die import Mirror

M = Membrane(5e-12, 2.0, 20e-6, 26e-3)
GATE = Gate(1.3e-13, 6e-9, 1.2e-14)
EQUAL = Mirror(1e-7, 1e-7, 0.0)
NEVER = Steps(np.array([math.inf]), np.array([4e-3]), np.array([6e-9]))


def steps(*given: tuple[float, float, float]) -> Steps:
    return Steps(*(np.array(column) for column in zip(*given, strict=True)))


@pytest.mark.parametrize(
    ("exc", "inh"), [(6e-9, 0.0), (6e-9, 5e-9), (12e-9, 6e-9), (6e-9, 6e-9), (6e-9, 7e-9)]
)
def test_the_membrane_is_that_of_its_equation(exc: float, inh: float) -> None:
    def slope(_: float, v: np.ndarray) -> np.ndarray:
        return np.asarray((exc - inh * (1.0 - np.exp(-v / M.u_t))) / M.capacitance)

    time = 1e-3
    found = solve_ivp(slope, (0.0, time), [0.0], rtol=1e-9, atol=1e-12, method="LSODA").y[0, -1]
    assert moved(M, 0.0, exc, inh, time) == pytest.approx(found, rel=1e-5)  # of the integration
    if exc > inh:
        rise = rise_time(M, 0.0, exc, inh)
        assert moved(M, 0.0, exc, inh, rise) == pytest.approx(M.reference, rel=1e-9)


def test_more_taken_than_given_never_spikes_and_rests() -> None:
    assert rise_time(M, 0.0, 6e-9, 7e-9) == math.inf
    assert rise_time(M, 0.0, 0.0, 0.0) == math.inf
    rest = -M.u_t * math.log(1.0 - 6.0 / 7.0)
    assert moved(M, 1.0, 6e-9, 7e-9, 1.0) == pytest.approx(rest)
    assert moved(M, 1.0, 0.0, 0.0, 1.0) == pytest.approx(1.0)


def test_spikes_of_one_input_come_with_the_charge_and_the_dead_time() -> None:
    found = lso_spikes(steps((1e-3, 4e-3, 6e-9)), NEVER, M, EQUAL)
    alone = 10e-12 / 6e-9
    assert found == pytest.approx([1e-3 + alone, 1e-3 + 2.0 * alone + M.dead])


def test_what_leaks_slows_the_membrane() -> None:
    found = lso_spikes(steps((1e-3, 5e-3, 6e-9)), NEVER, M._replace(leak=1e-9), EQUAL)
    alone = 10e-12 / 5e-9
    assert found == pytest.approx([1e-3 + alone, 1e-3 + 2.0 * alone + M.dead])


def test_equal_inputs_cancel_and_an_early_one_does_not() -> None:
    near, far = steps((1e-3, 4e-3, 12e-9)), steps((1e-3, 4e-3, 12e-9))
    assert lso_spikes(near, far, M, EQUAL).size == 0
    assert lso_spikes(near, steps((3e-3, 4e-3, 12e-9)), M, EQUAL).size == 2
    # what was switched off stays off, rounding of the sums or not
    assert lso_spikes(steps((0.0, 1e-4, 6e-9), (1e-5, 1e-4, 7e-9)), NEVER, M, EQUAL).size == 0


def test_a_mirror_is_nothing_but_its_devices() -> None:
    assert mirrored(EQUAL, 0.0) == 0.0
    assert mirrored(EQUAL, 12e-9) == pytest.approx(12e-9)
    assert mirrored(Mirror(1e-7, 2e-7, 0.0), 12e-9) == pytest.approx(24e-9)
    # far in weak inversion a shift of half a U_T is a factor e^(2 shift)
    assert mirrored(Mirror(1e-3, 1e-3, 0.1), 1e-12) == pytest.approx(math.exp(0.2) * 1e-12, rel=1e-3)


def test_a_mirror_carries_what_charges_its_gate_leaves() -> None:
    """Pieces have the charge of the law's own integral: it turns on, takes a second input, loses both."""
    edges, sums = [0.0, 100e-6, 160e-6, 400e-6, 3e-3], [6e-9, 15e-9, 4e-9, 0.0]
    marks, found = carried(edges, sums, GATE)
    assert set(edges) <= set(marks)
    assert np.all(np.diff(marks) > 0.0)

    def change(t: float, log: np.ndarray) -> np.ndarray:
        given = sums[int(np.searchsorted(edges, t, side="right")) - 1]
        return np.asarray((given - np.exp(log)) / GATE.fold)

    start = math.log(GATE.current) - GATE.charge / GATE.fold
    for begin, end, amperes in zip(marks[:-1], marks[1:], found, strict=True):
        middle = begin, 0.5 * (begin + end), end - 1e-9 * (end - begin)
        run = solve_ivp(
            change, (begin, middle[-1]), [start], method="LSODA", rtol=1e-10, atol=1e-12, dense_output=True
        )
        t = np.linspace(begin, middle[-1], 4001)
        assert amperes * (end - begin) == pytest.approx(np.trapezoid(np.exp(run.sol(t)[0]), t), rel=1e-4)
        start = float(run.y[0, -1])


def test_inhibition_begins_when_the_gate_is_charged_and_ends_late() -> None:
    slow, quick = M._replace(gate=GATE), M
    far = steps((1e-3, 1e-3, 6e-9))
    given = steps((1e-3, 5e-3, 12e-9))
    at_once, later = (dict(zip(*_taken(given, far, m), strict=True)) for m in (quick, slow))
    assert at_once == {1e-3: 6e-9, 2e-3: 0.0}
    taken = np.array(list(later.values()))
    begins = np.array([*later, 6e-3])
    charge = taken * np.diff(begins)
    # what charges the gate is missing, and what is left of it at the end comes back but for ln(1 + t / tau)
    left = GATE.charge - GATE.fold * math.log(1.0 + 6e-9 * 4e-3 / GATE.fold)
    assert charge.sum() == pytest.approx(6e-12 - left, rel=1e-3)
    assert charge[begins[:-1] >= 2e-3].sum() == pytest.approx(GATE.charge - left, rel=1e-3)
    assert (np.diff(taken[begins[:-1] >= 2e-3]) < 0.0).all()


def test_inputs_at_one_instant_are_a_sum() -> None:
    far = steps((1e-3, 1e-3, 6e-9), (1e-3, 1e-3, 4e-9))
    edges, given, taken = segments(steps((1e-3, 5e-3, 6e-9), (1e-3, 5e-3, 6e-9)), far, M._replace(gate=GATE))
    assert np.diff(edges).min() > 0.0
    assert set(given) == {12e-9}
    assert max(taken) == pytest.approx(10e-9, rel=1e-2)


def _taken(excitation: Steps, inhibition: Steps, membrane: Membrane) -> tuple[list[float], list[float]]:
    edges, _, taken = segments(excitation, inhibition, membrane)
    return edges[:-1], taken


def test_a_ramp_charges_the_axon() -> None:
    slope, charge, current, kappa, u_t = 800.0, 3e-12, 2.5e-7, 0.75, 26e-3
    time = np.linspace(0.0, float(ramp_delay(slope, charge, current, kappa, u_t)), 20_001)
    given = np.trapezoid(current * np.tanh(kappa * slope * time / (2.0 * u_t)), time)
    assert given == pytest.approx(charge, rel=1e-6)
    # a steep one is only current
    assert float(ramp_delay(1e9, charge, current, kappa, u_t)) == pytest.approx(charge / current, rel=1e-3)


def test_a_copy_that_is_too_weak_is_deaf() -> None:
    tail, least = np.full(2, 250e-9), np.array([160e-9, 260e-9])
    same = Mirror(np.full(2, 1e-6), np.full(2, 1e-6), np.zeros(2))
    found = rest_depth(tail, least, same, 1e-3, 0.75, 26e-3)
    # far in weak inversion the pair splits by e^(kappa x / U_T)
    assert found[0] == pytest.approx(26e-3 / 0.75 * math.log(160.0 / 90.0), rel=0.02)
    assert found[1] == math.inf


@pytest.mark.parametrize("given", [6e-9, 60e-9])
def test_a_spike_comes_when_the_pair_has_brought_up_its_charge(given: float) -> None:
    comparator = Comparator(0.1e-12, 50e-9, 0.7, 3e-6)
    membrane = M._replace(comparator=comparator)
    slope, late = given / M.capacitance, spike_delay(membrane, given, 0.0) - comparator.lag
    t = np.linspace(0.0, late, 20001)
    brought = np.trapezoid(comparator.current * np.tanh(0.7 * slope * t / (2.0 * M.u_t)), t)
    assert brought == pytest.approx(comparator.charge, rel=1e-6)
    assert spike_delay(M, given, 0.0) == 0.0
    assert spike_delay(membrane, given, 0.9 * given) > spike_delay(membrane, given, 0.0)
    assert spike_delay(membrane, given, 1.1 * given) == math.inf
    plain, later = (lso_spikes(steps((1e-3, 4e-3, given)), NEVER, m, EQUAL) for m in (M, membrane))
    assert later[:2] - plain[:2] == pytest.approx(np.array([1.0, 2.0]) * (late + comparator.lag))
