"""Figure 12 of Wen & Horiuchi 2022 on the latency chip: two pings, a reset, and the nodes of a unit.

The scene and its statements are those of `wen2022-fig12`; the chip is the nominal die with ideal
biases, and the unit that Figure 12C watches is of transistors inside the run, whose nodes are drawn. What
the scene fitted on the network is no fit here, but neither is it independent of it: the chip was made to
agree with the network. The unit's own statement: its spikes come within 20 us of the lumped model's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from chips.latency.chip import LatencyChip
from chips.latency.model import usual_biases
from chips.latency.unit_level import TransistorUnit
from circuits.arrays import F64, I64
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report
from system.openspace.law import ARCS, DIRECTIONS, MIDDLE, Arcs, Bat, arcs_of
from system.papers.wen2022.fig5 import NAMES
from system.papers.wen2022.fig12 import IN_WINDOW, SEVERAL, WINDOW, groups
from system.plot import COLOURS, INK, PALE
from system.rule import Measured, equal, within
from system.spiking_bat.bat import goal_neuron, seen_from
from system.spiking_bat.chip_brain import ChipBrain, ChipReply, brain_with, design_of
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.scene import HEADING, OBSTACLES, PING_RATE
from system.statement import Statement

NODES = ("seen[0]", "seen[1]", "cd.sum", "spike", "inh.cell.v_mem", "inh.hold.timer")
LABELS = ("A", "B", "sum of CD", "CD", "INH", "hold of INH")
NEAR = 20e-6  # s, between the unit of transistors and the model


@dataclass(frozen=True, slots=True)
class ChipStory:
    """Replies to two pings and to one after the reset, to a repeated recall, and the watched unit."""

    arcs: Arcs
    replies: tuple[ChipReply, ChipReply, ChipReply]
    recalled: tuple[F64, F64]
    modelled: tuple[float, ...]
    watched: tuple[int, int]
    unit: TransistorUnit


def reproduce(progress: Progress) -> Report:
    """Both pings, the reset, recalls."""
    story = tell()
    progress(1.0)
    return Report(rows(story), lambda figure: _draw(story, figure), notes(story))


def tell() -> ChipStory:
    """Run the scene on the chip, with the model's unit first, then with transistors in its place."""
    arcs, numbers = arcs_of(Bat(ping_rate=PING_RATE)), Numbers()
    design, silicon = design_of(arcs, numbers), Silicon(AMI_1500_IDEAL)
    biases = usual_biases(design, "ideal")
    bare = brain_with(LatencyChip(design, biases, silicon), arcs, numbers)
    replies = _scene(bare, arcs)
    stored = np.argwhere(np.isfinite(replies[0].response.detected))
    memory, number = (int(x) for x in stored[stored[:, 0] == stored[:, 0].max()][0])
    unit = TransistorUnit(biases, silicon, memory, number, NODES)
    chip = LatencyChip(design, biases, silicon, units={(memory, number): unit})
    again = _scene(brain_with(chip, arcs, numbers), arcs)
    asked = brain_with(LatencyChip(design, biases, silicon), arcs, numbers)
    asked.answer(DIRECTIONS // 2, MIDDLE, _view(arcs, DIRECTIONS // 2, 0.0))
    recalled = []
    for _ in range(2):
        asked.end(spoken=False)
        recalled.append(asked.answer(DIRECTIONS // 2, MIDDLE, np.empty((0, 2))).response.memory)
    modelled = tuple(float(r.response.detected[memory, number]) for r in replies)
    return ChipStory(arcs, again, (recalled[0], recalled[1]), modelled, (memory, number), unit)


def rows(story: ChipStory) -> tuple[Statement, ...]:
    """The statements of the figure that a chip can make."""
    one, two, three = story.replies
    group = story.arcs.group
    first = np.unique(group[np.isfinite(one.response.first)])
    heard = np.isfinite(one.response.memory)
    unseen = heard & ~np.isfinite(two.response.integrating)
    change = np.abs(two.response.memory[unseen] - one.response.memory[unseen])
    kept = np.where(heard, one.response.memory, math.nan)
    left = two.arcs.size > 0 and float(story.arcs.curvature[two.arcs].mean()) > 0.0
    off = [
        abs(float(r.response.detected[story.watched]) - m)
        for r, m in zip(story.replies, story.modelled, strict=True)
        if math.isfinite(m) or math.isfinite(float(r.response.detected[story.watched]))
    ]
    return (
        _same("ping_1_groups_of_memory_spikes", 3, len(groups(kept))),
        Statement("ping_1_first_layer", "several", Measured(first.size, _named(first)), SEVERAL),
        _same("ping_1_second_layer", "middle left", _named(np.unique(group[one.response.paths]))),
        _same("ping_1_head_turns_to", "middle left", NAMES[one.head] if one.head is not None else "none"),
        _same("ping_1_body_motor_spikes", 0, int(one.arcs.size)),
        _same("ping_2_second_layer", "middle left", _named(np.unique(group[two.response.paths]))),
        _same("ping_2_body_turns", "to the left", "to the left" if left else "not"),
        Statement("recall_change_s", WINDOW, float(change.max(initial=0.0)), IN_WINDOW),
        _same("recalls_differ", "no", "no" if np.array_equal(*story.recalled) else "yes"),
        _same("memory_spikes_after_reset", 0, int(np.isfinite(three.response.memory).sum())),
        Statement(
            "unit_of_transistors_off_s",
            NEAR,
            max(off),
            within(NEAR, "within {micro:g} us of the model's spikes", of=0.0),
        ),
    )


def notes(story: ChipStory) -> tuple[str, ...]:
    """Winners, and the unit that is watched."""
    one, two, _ = story.replies
    memory, unit = story.watched
    first = np.flatnonzero(np.isfinite(one.response.first)).tolist()
    return (
        f"watched: memory {memory}, unit {unit + 1}, of transistors",
        f"winners after ping 1: {first}, kept: {sorted(one.response.paths.tolist())}",
        f"arcs flown after ping 2: {two.arcs.tolist()}",
    )


def _scene(brain: ChipBrain, arcs: Arcs) -> tuple[ChipReply, ChipReply, ChipReply]:
    middle, goal = DIRECTIONS // 2, goal_neuron(arcs, HEADING)
    one = brain.ping(middle, goal, _view(arcs, middle, 0.0))
    head = middle if one.head is None else one.head
    two = brain.ping(head, goal, _view(arcs, head, float(arcs.speed[MIDDLE]) * brain.period))
    return one, two, brain.ping(head, goal, np.empty((0, 2)))


def _view(arcs: Arcs, head: int, flown: float) -> F64:
    """What a ping shows after `flown` m straight on."""
    place = np.array([(flown - ahead, -left) for ahead, left in OBSTACLES])
    return seen_from(arcs, place, HEADING, head)


def _named(found: Sequence[int] | I64) -> str:
    return ", ".join(NAMES[int(g)] for g in found) if len(found) else "none"


def _same(name: str, paper: float | str, ours: float | str) -> Statement:
    return Statement(name, paper, ours, equal())


def _draw(story: ChipStory, figure: Figure) -> None:
    """Raster of the layers, as Figure 12B, and nodes of the unit of transistors, as 12C."""
    figure.set_size_inches(9.0, 9.0)
    grid = figure.add_gridspec(2, 1, height_ratios=(1.2, 1.6))
    ax = figure.add_subplot(grid[0])
    for k, reply in enumerate(story.replies[:2]):
        begin = 100.0 * k
        ax.axvline(begin, color=INK, linewidth=0.6, linestyle=":")
        said = reply.response
        layers = ((said.free, PALE, "not stopped", "|"), (said.memory, COLOURS[0], "memory", "o"),
                  (said.first, COLOURS[1], "first layer", "o"))  # fmt: skip
        for times, colour, label, mark in layers:
            shown = np.flatnonzero(times < 0.1)
            ax.plot(begin + 1e3 * times[shown], shown, marker=mark, color=colour, linestyle="", markersize=4,
                    label=label if k == 0 else None)  # fmt: skip
        ax.plot(begin + 1e3 * said.times, said.paths, marker="o", color=INK, linestyle="", markersize=4,
                label="second layer" if k == 0 else None)  # fmt: skip
    ax.set(xlim=(-3.0, 200.0), ylim=(ARCS, -1), ylabel="arc, 0 to the left")
    ax.legend(fontsize=7, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    inner = grid[1].subgridspec(len(NODES), 1, hspace=0.1)
    time = 1e3 * (np.concatenate([t for t, _ in story.unit.kept]) - 0.1)
    volts = np.concatenate([v for _, v in story.unit.kept])
    for k, label in enumerate(LABELS):
        ax = figure.add_subplot(inner[k])
        last = k == len(NODES) - 1
        ax.plot(time, volts[:, k], color=COLOURS[0], linewidth=0.8)
        ax.set_ylabel(f"{label} (V)", fontsize=8, rotation=0, ha="right", va="center")
        ax.tick_params(labelsize=7, bottom=last, labelbottom=last)
        ax.set_xlim(-3.0, 300.0)
    ax.set_xlabel("time after the first ping (ms)")


EXPERIMENT = Experiment("wen2022-fig12-chip", "Figure 12 on the latency chip", reproduce)
