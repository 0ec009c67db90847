"""Figure 12 of Wen & Horiuchi 2022: the spike-latency network between two pings among six obstacles.

The network hears the two pings of a scene, and its spikes are compared with the paper's words: the first
ping, straight ahead, shows three obstacles, which make three groups of memory spikes; several neurons of the
first layer win, the second layer keeps one group, middle left; the head turns there and the body does not.
The second ping shows others; the memories of the obstacles out of view give the same latencies again; the
winners are middle left, and the body turns. Then the memories are reset.

A group here is a run of neighbouring arcs whose first spikes are within 3 ms of the neighbour's. Coordinates
are ours, near those of our Figure 5, for whose rows they do as well. They and the numbers of the network
(`Numbers`) were chosen so that the scene goes as the paper has it: the rows that say so count as fitted.
"""

from __future__ import annotations

import math

import numpy as np

from chips.latency.law import evaluation_latency, race_latency
from circuits.arrays import F64, I64
from system.experiment import Experiment, Progress, Report
from system.openspace.law import ARCS, DIRECTIONS, Bat
from system.papers.wen2022.fig5 import NAMES
from system.rule import Measured, all_of, at_least, at_most, equal, within, within_share
from system.spiking_bat.bat import Answer, goal_neuron
from system.spiking_bat.maps import blocking, places
from system.spiking_bat.picture import draw_figure_12
from system.spiking_bat.scene import HEADING, OBSTACLES, PING_RATE, Story, tell
from system.spiking_bat.topology import goal_charge, passive_current, suppression
from system.statement import Statement

WINDOW = 3e-3  # s, of a coincidence; the paper's
SILENCE, SILENCE_RANGE = 0.15, 0.2  # s, of INH after a spike of CD: "about 150 ms"; share, ours
CLOSE = 0.02  # share by which a latency may be off its closed form; ours

SEVERAL = at_least(2.0, "of two groups or more")
IN_WINDOW = at_most(WINDOW, "at most the window")
NEAR_LAW = within(CLOSE, "within {percent:g} % of the closed form", of=0.0)


def reproduce(progress: Progress) -> Report:
    """Both pings, the reset, and recalls."""
    story = tell(progress)
    progress(1.0)
    race, bat = [race_latencies(story, k) for k in range(2)], Bat(ping_rate=PING_RATE)
    return Report(
        rows(story), lambda figure: draw_figure_12(story, race, OBSTACLES, bat, figure), notes(story)
    )


def groups(latencies: F64) -> list[list[int]]:
    """Runs of neighbouring arcs whose latencies (s, nan without) differ by no more than the window."""
    found: list[list[int]] = []
    for p in np.flatnonzero(~np.isnan(latencies)):
        near = found and found[-1][-1] == p - 1 and abs(latencies[p] - latencies[p - 1]) <= WINDOW
        if near:
            found[-1].append(int(p))
        else:
            found.append([int(p)])
    return found


def rows(story: Story) -> tuple[Statement, ...]:
    """What the paper says of the figure, and closed forms."""
    return (*_size_rows(story), *_ping_rows(story), *_memory_rows(story))


def _size_rows(story: Story) -> tuple[Statement, ...]:
    w = story.network.wiring
    return (
        _same("integrate_and_fire_neurons", 2931, w.decay.size),
        _same("hodgkin_huxley_neurons", 2078, w.conductors),
        _same("neurons_of_a_map", 471, len(places())),
    )


def _ping_rows(story: Story) -> tuple[Statement, ...]:
    one, two, _ = story.answers
    group = story.arcs.group
    first = np.unique(group[one.spikes.of("wta1")[1]])
    second = [_named(np.unique(group[a.spikes.of("wta2")[1]])) for a in (one, two)]
    left = two.arcs.size > 0 and float(story.arcs.curvature[two.arcs].mean()) > 0.0
    return (
        _same("ping_1_detected", 3, story.detected[0]),
        _same("ping_1_groups_of_memory_spikes", 3, len(groups(story.memory[0])), fitted=True),
        Statement("ping_1_first_layer", "several", Measured(first.size, _named(first)), SEVERAL, fitted=True),
        _same("ping_1_second_layer", "middle left", second[0], fitted=True),
        _same("ping_1_head_turns_to", "middle left", _named(one.head), fitted=True),
        _same("ping_1_body_motor_spikes", 0, int(one.arcs.size)),
        _same("ping_2_second_layer", "middle left", second[1], fitted=True),
        _same("ping_2_body_turns", "to the left", "to the left" if left else "not", fitted=True),
    )


def _memory_rows(story: Story) -> tuple[Statement, ...]:
    unseen = unseen_arcs(story)
    change = np.abs(story.memory[1] - story.memory[0])[unseen]
    finite = int(np.isfinite(change).sum())
    same = np.array_equal(story.recalled[1:], story.recalled[:-1], equal_nan=True)
    known = Measured(finite if unseen.size else math.nan, f"{finite} of {unseen.size}")
    return (
        Statement("unseen_recalled", "all", known, all_of(unseen.size, "all, at least one")),
        Statement("recall_change_s", WINDOW, float(np.nanmax(change, initial=0.0)), IN_WINDOW),
        _same("recalls_differ", "no", "no" if same else "yes"),
        _same("memory_spikes_after_reset", 0, int(np.isfinite(story.memory[2]).sum())),
        Statement("inh_silent_s", SILENCE, story.silence, within_share(SILENCE_RANGE), fitted=True),
        Statement("equation_9_error", CLOSE, evaluation_error(story), NEAR_LAW),
        Statement("equation_10_error", CLOSE, race_error(story), NEAR_LAW),
    )


def notes(story: Story) -> tuple[str, ...]:
    """What the figure says besides."""
    arc, unit = story.watched
    one, two, _ = story.answers
    return (
        f"watched: memory {arc}, unit {unit + 1}",
        f"winners after ping 1: {_listed(one, 'wta1')}, kept: {_listed(one, 'wta2')}",
        f"winners after ping 2: {_listed(two, 'wta1')}, arcs flown: {two.arcs.tolist()}",
        f"groups of memories after ping 1: {groups(story.memory[0])}",
        f"groups of memories after ping 2: {groups(story.memory[1])}",
    )


def unseen_arcs(story: Story) -> I64:
    """Arcs remembered at the first ping whose integrating neuron was silent at the second."""
    remembered = np.flatnonzero(np.isfinite(story.memory[0]))
    return np.setdiff1d(remembered, story.fresh)


def evaluation_error(story: Story) -> float:
    """Largest relative deviation of an integrating neuron's latency from equation (9), where it is valid."""
    s = story.numbers
    found = blocking(story.arcs, places(), s.constant_delay)
    n, worst = len(places()), 0.0
    for answer, start in zip(story.answers[:2], story.times[:2], strict=True):
        times, maps = answer.spikes.of("body_map")
        for t, p in zip(*answer.spikes.of("integrating"), strict=True):
            arrivals = [
                at - start + found.delay[k]
                for at, j in zip(times, maps, strict=True)
                for k in np.flatnonzero((found.direction * n + found.place == j) & (found.arc == p))
            ]
            latency = evaluation_latency(arrivals, 1.0 / s.integration)
            if latency - min(arrivals) < s.step_current:
                worst = max(worst, abs((t - start) / latency - 1.0))
    return worst


def race_error(story: Story) -> float:
    """Largest relative deviation of a first-layer neuron's latency from equation (10)."""
    worst = 0.0
    for k in range(2):
        start = story.times[k]
        expected = race_latencies(story, k)
        for t, p in zip(*story.answers[k].spikes.of("wta1"), strict=True):
            worst = max(worst, abs((t - start) / expected[p] - 1.0))
    return worst


def race_latencies(story: Story, k: int) -> F64:
    """Latencies of equation (10) after ping k without recurrent inhibition, s, float64[ARCS]."""
    s, head = story.numbers, (DIRECTIONS // 2, story.answers[0].head)[k]
    weight = suppression(s)
    passive = passive_current(story.arcs, s)
    charge = goal_charge(s)[goal_neuron(story.arcs, HEADING)]
    charge = charge + s.direction * (story.arcs.group == head)
    known = np.flatnonzero(np.isfinite(story.memory[k]))
    return np.array(
        [
            race_latency(
                float(passive[p]), float(charge[p]),
                [(float(story.memory[k, q]), float(weight[q, p])) for q in known if weight[q, p] > 0.0],
            )
            for p in range(ARCS)
        ]
    )  # fmt: skip


def _listed(answer: Answer, name: str) -> list[int]:
    return sorted(map(int, answer.spikes.of(name)[1]))


def _named(found: I64 | int | None) -> str:
    if found is None:
        return "none"
    return ", ".join(NAMES[int(g)] for g in np.atleast_1d(found))


def _same(name: str, paper: float | str, ours: float | str, *, fitted: bool = False) -> Statement:
    return Statement(name, paper, ours, equal(), fitted)


EXPERIMENT = Experiment("wen2022-fig12", "the spike-latency network between two pings", reproduce)
