"""The chip whose neurons sleep against the same neurons, all of them integrated all the time."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chips.ranging import kernel
from chips.ranging.chip import RangingChip
from chips.ranging.law import Neurons
from chips.ranging.neuron_kernel import (
    COLUMNS,
    EARLY_STOP,
    MAY_STOP,
    NOW,
    PEAK,
    RESET_END,
    TOLERANCE,
    V_EX,
    V_R,
    advance,
    call,
    echo,
)
from circuits.arrays import F64
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon

Input = tuple[float, str, float]  # time s, what, level V
Spike = tuple[int, float]


def _stimuli(seed: int, calls: int) -> list[Input]:
    """Calls with three echoes each, one in four of them isolated."""
    draw = np.random.default_rng(seed)
    found: list[Input] = []
    time = 1e-3
    for _ in range(calls):
        found.append((time, "call", math.nan))
        delays, isolated = draw.uniform(0.3e-3, 28e-3, 3), draw.random(3) < 0.25
        found += [(time + d, "echo", 5.0 if i else math.nan) for d, i in zip(delays, isolated, strict=True)]
        time += draw.uniform(30e-3, 90e-3)
    return [*sorted(found), (time, "end", math.nan)]


def _asleep(m: Neurons, plan: kernel.Plan, inputs: list[Input]) -> tuple[list[Spike], kernel.Chip]:
    chip = kernel.new_chip(m, plan)
    found = []
    for time, what, level in inputs:
        while kernel.next_due(chip)[0] <= time:
            due, k = kernel.next_due(chip)
            if kernel.take(m, plan, chip, k):
                found.append((k, due))
        if what == "call":
            kernel.on_call(m, plan, chip, time)
        elif what == "echo":
            kernel.on_echo(m, plan, chip, time, level)
    return sorted(found), chip


def _awake(m: Neurons, states: F64, inputs: list[Input]) -> list[Spike]:
    found = []
    for time, what, level in inputs:
        for k in range(len(states)):
            while states[k, NOW] < time:
                spike = advance(m, k, states[k], time)
                if spike < math.inf:
                    found.append((k, spike))
            if what == "call":
                call(m, k, states[k])
            elif what == "echo":
                echo(m, k, states[k], float(m.v_ex_max[k]) if math.isnan(level) else level)
    return sorted(found)


@pytest.mark.parametrize(("die", "sleepers"), [(None, 13), (1007, 11), (5, 11)])
def test_sleeping_changes_no_spike(die: int | None, sleepers: int) -> None:
    part = RangingChip(
        Silicon(AMI_1500_IDEAL)
        if die is None
        else Silicon(AMI_1500_IDEAL, die=Die(number=die, process=False)),
        bias_kind="gate",
    )
    m = part.neurons_at(27.0)
    plan = kernel.new_plan(m)
    assert plan.certain.sum() == sleepers
    inputs = _stimuli(1, 40)
    ours, _ = _asleep(m, plan, inputs)
    theirs = _awake(m, part.begin().neurons.base, inputs)
    assert len(theirs) > 80
    assert [k for k, _ in ours] == [k for k, _ in theirs]
    # a step's error, 0.1 mV, over the slowest passage of a threshold that spikes of these inputs have
    assert np.abs(np.array(ours)[:, 1] - np.array(theirs)[:, 1]).max() < 20e-6


def _at_a_target(calls: int, delay: float, spread: float = 20e-6) -> list[Input]:
    """What a bat hears that hovers at a target: itself and what is behind in isolation, and the target."""
    draw = np.random.default_rng(2)
    found: list[Input] = []
    for time in 35e-3 * np.arange(1, calls + 1) + draw.normal(0.0, 2e-6, calls):
        jitter = draw.normal(0.0, spread, 2)
        found += [(time - 0.1e-3, "echo", 5.0), (time, "call", math.nan)]
        found += [
            (time + delay + jitter[0], "echo", math.nan),
            (time + delay + 6e-3 + jitter[1], "echo", 5.0),
        ]
    return [*found, (found[-4][0] + 30e-3, "end", math.nan)]


@pytest.mark.parametrize("process", [AMI_1500, AMI_1500_IDEAL])
def test_what_follows_a_spike_that_was_met_before_is_what_integration_finds(process: Process) -> None:
    part = RangingChip(Silicon(process), bias_kind="generator")
    m = part.neurons_at(27.0)
    m.v_ex_max[:] -= 0.1  # so that spikes come in trains
    plan, places = kernel.new_plan(m), 0
    inputs = _at_a_target(60, float(m.t_inh[1]) + 0.3e-3, 1e-6)
    ours, chip = _asleep(m, plan, inputs)
    theirs = _awake(m, part.begin().neurons.base, inputs)
    assert [k for k, _ in ours] == [k for k, _ in theirs]
    assert np.abs(np.array(ours)[:, 1] - np.array(theirs)[:, 1]).max() < 20e-6  # as in the first test
    draw, state = np.random.default_rng(3), np.zeros(COLUMNS)
    for k in range(13):
        for patch in chip.again[k][chip.again[k, :, 2] == kernel._MADE]:
            for x, r in draw.uniform(-1.0, 1.0, (8, 2)):
                v_ex, v_r = patch[0] + x * kernel.AGAIN_X, patch[1] + r * kernel.AGAIN_R
                spike = kernel._follows(m, plan, k, state, v_ex, v_r)
                # a third of what a first spike is off by at the tolerance of a step, 0.23 us in the median
                assert kernel._told(patch, 3, x, r) == pytest.approx(spike, abs=0.08e-6)
                assert kernel._told(patch, 4, x, r) == pytest.approx(state[V_EX], abs=0.5 * TOLERANCE)
                assert kernel._told(patch, 5, x, r) == pytest.approx(state[V_R], abs=0.5 * TOLERANCE)
                places += 1
    assert places >= 16


def test_a_patch_tells_nothing_of_what_an_input_comes_before() -> None:
    m = RangingChip(Silicon(AMI_1500), bias_kind="generator").neurons_at(27.0)
    m.v_ex_max[:] -= 0.1
    plan = kernel.new_plan(m)
    _, chip = _asleep(m, plan, _at_a_target(60, float(m.t_inh[1]) + 0.3e-3, 1e-6))
    k, i = np.argwhere(chip.again[:, :, 2] == kernel._MADE)[0]
    state, patch = plan.rest[k].copy(), chip.again[k, i]
    state[V_EX], state[V_R], state[NOW], state[RESET_END] = patch[0], patch[1], 1.0, 1.0 + m.pulse_width[k]
    for late, told in ((-1e-6, False), (1e-6, True)):
        chip.last[kernel.NEXT] = 1.0 + patch[15] + late
        assert kernel._goes_on(m, chip, k, state.copy()) == told
    kernel.forget_seen(chip)
    assert not kernel._goes_on(m, chip, k, state)


@pytest.mark.parametrize("lower", [0.0, 0.03, 0.06])
def test_what_was_seen_to_be_silent_is_silent(lower: float) -> None:
    part = RangingChip(Silicon(AMI_1500), bias_kind="generator")
    m = part.neurons_at(27.0)
    m.v_ex_max[:] -= lower
    inputs = _at_a_target(30, float(m.t_inh[1]) + 0.3e-3)
    ours, chip = _asleep(m, kernel.new_plan(m), inputs)
    assert np.isfinite(chip.calm[:, :, 0]).any()  # so that nearly no spike was looked beyond
    theirs = _awake(m, part.begin().neurons.base, inputs)
    assert len(theirs) >= 30
    assert [k for k, _ in ours] == [k for k, _ in theirs]
    assert np.abs(np.array(ours)[:, 1] - np.array(theirs)[:, 1]).max() < 20e-6  # as above


@pytest.mark.parametrize("die", [None, 1003, 1007])
@pytest.mark.parametrize("process", [AMI_1500, AMI_1500_IDEAL])
def test_a_peak_moves_by_less_than_is_taken_where_voltages_after_a_spike_do(
    die: int | None, process: Process
) -> None:
    silicon = Silicon(process) if die is None else Silicon(process, die=Die(number=die))
    m = RangingChip(silicon, bias_kind="generator").neurons_at(27.0)
    m.v_ex_max[:] -= 0.05
    rest, peaks = kernel.new_plan(m).rest, 0
    for k in range(13):
        state = rest[k].copy()
        call(m, k, state)
        advance(m, k, state, float(m.t_inh[k]))
        echo(m, k, state, float(m.v_ex_max[k]))
        while advance(m, k, state, float(m.t_inh[k]) + 10e-3) < math.inf:
            after = state.copy()
            advance(m, k, after, float(after[RESET_END]))
            found = []
            for column, change in ((V_EX, 0.0), (V_EX, -1e-3), (V_R, -1e-3)):
                moved = after.copy()
                moved[column] += change
                moved[PEAK] = -math.inf
                moved[EARLY_STOP] = MAY_STOP
                spike = advance(m, k, moved, float(after[NOW]) + 20e-3)
                found.append(moved[PEAK] if spike == math.inf else math.nan)
            if not np.isnan(found).any():
                assert np.abs(np.diff(found)).max() < kernel._STEEP * 1e-3
                peaks += 1
    assert peaks > 0


def test_only_what_holds_v_mem_back_more_counts_as_seen() -> None:
    m = RangingChip(Silicon(AMI_1500_IDEAL), bias_kind="gate").neurons_at(27.0)
    plan = kernel.new_plan(m)
    inputs = [(1e-3, "call", math.nan), (7.4e-3, "echo", math.nan), (30e-3, "end", math.nan)]
    _, chip = _asleep(m, plan, inputs)
    x, r, leeway = chip.calm[2, 0]
    below = m.v_threshold[2] - chip.ahead[2, PEAK]
    assert leeway == pytest.approx((below - kernel._BELOW) / kernel._STEEP)
    for x_less, r_less in ((0.0, 0.0), (-1e-3, 0.9 * leeway), (0.9 * leeway, 0.0)):
        assert kernel._seen(chip, 2, x - x_less, r - r_less)
    for x_less, r_less in ((1.1 * leeway, 0.0), (0.0, 1.1 * leeway)):
        assert not kernel._seen(chip, 2, x - x_less, r - r_less)
    # one that tells more takes its place, one that does not stands beside it
    kernel._remember(chip, 2, x - 1e-3, r, 0.0)
    nothing = [math.inf, math.inf, 0.0]
    assert chip.calm[2].tolist() == [[x - 1e-3, r, 0.0], *[nothing] * (kernel.CALM - 1)]
    kernel._remember(chip, 2, x, r - 1e-3, 1e-6)
    assert chip.calm[2, :2].tolist() == [[x, r - 1e-3, 1e-6], [x - 1e-3, r, 0.0]]
    kernel.forget_seen(chip)
    assert chip.calm[2].tolist() == [nothing] * kernel.CALM
    assert np.isinf(chip.lead).all()


def test_an_echo_before_one_that_was_silent_wakes_nobody() -> None:
    m = RangingChip(Silicon(AMI_1500_IDEAL), bias_kind="gate").neurons_at(27.0)
    plan = kernel.new_plan(m)
    delay = float(plan.early[2]) - 0.3e-3
    plan.early[:] = 0.0  # so that nothing is known of it
    inputs = [(1e-3, "call", math.nan), (1e-3 + delay, "echo", math.nan), (60e-3, "call", math.nan)]
    found, chip = _asleep(m, plan, inputs)
    assert all(k != 2 for k, _ in found)
    assert chip.lead[2] == pytest.approx(m.t_inh[2] - delay, abs=1e-12)
    for later, phase in ((-1e-6, kernel.ASLEEP), (1e-6, kernel.QUIET)):
        again = chip._replace(phase=chip.phase.copy(), counts=chip.counts.copy(), last=chip.last.copy())
        kernel.on_echo(m, plan, again, 60e-3 + delay + later, math.nan)
        assert again.phase[2] == phase


def test_an_isolated_echo_before_a_call_leaves_it_as_a_call_alone() -> None:
    m = RangingChip(Silicon(AMI_1500), bias_kind="generator").neurons_at(27.0)
    plan = kernel.new_plan(m)
    call_and_echo = [(1e-3, "call", math.nan), (3.7e-3, "echo", math.nan), (30e-3, "end", math.nan)]
    found, _ = _asleep(m, plan, [(0.9e-3, "echo", 5.0), *call_and_echo])
    alone, _ = _asleep(m, plan, call_and_echo)
    assert found == alone
    assert len(found) > 0


def test_a_chip_sleeps_but_for_what_an_echo_reaches() -> None:
    m = RangingChip(Silicon(AMI_1500_IDEAL), bias_kind="gate").neurons_at(27.0)
    plan = kernel.new_plan(m)
    chip = kernel.new_chip(m, plan)
    kernel.on_call(m, plan, chip, 1e-3)
    assert np.all(chip.phase == kernel.ASLEEP)
    assert kernel.next_due(chip)[0] == math.inf
    kernel.on_echo(m, plan, chip, 7.4e-3, math.nan)
    awake = np.flatnonzero(chip.phase != kernel.ASLEEP)
    assert 2 in awake
    assert awake.size <= 3
    due, k = kernel.next_due(chip)
    assert k == 2
    assert 7.4e-3 < due < 9e-3
    assert kernel.take(m, plan, chip, k)
    assert kernel.next_due(chip)[0] == math.inf


def test_echoes_up_to_early_are_silent_and_one_soon_after_is_not() -> None:
    m = RangingChip(Silicon(AMI_1500_IDEAL), bias_kind="gate").neurons_at(27.0)
    plan = kernel.new_plan(m)
    blind = plan._replace(early=np.zeros(13))
    for k in range(13):
        for delay, spikes in ((plan.early[k], 0), (plan.early[k] + 0.6e-3, 1)):
            inputs = [(1e-3, "call", math.nan), (1e-3 + delay, "echo", math.nan), (60e-3, "end", math.nan)]
            found, _ = _asleep(m, blind, inputs)
            assert sum(n == k for n, _ in found) == spikes, (k, delay)


def test_isolated_echoes_wake_nobody() -> None:
    m = RangingChip(Silicon(AMI_1500_IDEAL), bias_kind="gate").neurons_at(27.0)
    plan = kernel.new_plan(m)
    inputs = [(1e-3, "call", math.nan), (7.4e-3, "echo", 5.0), (30e-3, "end", math.nan)]
    found, chip = _asleep(m, plan, inputs)
    assert found == []
    assert np.all(chip.phase == kernel.ASLEEP)


def test_merged_inputs_and_doubts_are_counted() -> None:
    m = RangingChip(Silicon(AMI_1500_IDEAL), bias_kind="gate").neurons_at(27.0)
    plan = kernel.new_plan(m)
    inputs = [(1e-3, "call", math.nan), (1.005e-3, "call", math.nan), (30e-3, "end", math.nan)]
    _, chip = _asleep(m, plan, inputs)
    assert chip.counts[kernel.MERGED] == 1
    assert kernel.doubts(chip) == 0
    unsure = m._replace(margin=np.full(13, 0.15))
    plan = kernel.new_plan(unsure)
    assert not plan.certain.any()
    _, chip = _asleep(unsure, plan, [(1e-3, "call", math.nan), (60e-3, "end", math.nan)])
    assert kernel.doubts(chip) == 13
