"""Section 3.7 and Figure 14 of Milde et al. 2017: towards a standing robot with a blinking LED.

The robot drives towards another one that stands there, with and without a block on the way, and how often it
gets there is compared with the paper's: of ten runs at speed and turn factor 0.5 "the robot successfully
turns and drives toward the target every time", to about 10 cm; in eight it is then taken for an obstacle and
avoided. Rules: reached, that is, within 25 cm of the other robot (passing by straight on leaves 30 cm; ours),
in at least 90 % of the runs; of those at least half without touching it; with a block on the way, the block
is not touched in at least 90 %.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.null import ROBOTS, always, runs_of
from system.papers.milde2017.picture import draw_paths
from system.pushbot.campaign import Drive, Runs, Summary, drive_repeats, summaries_of
from system.pushbot.run import Trace
from system.pushbot.scenario import Scenario
from system.rule import at_least
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.share import share_where
from system.verdict.null import nulls_of
from system.worlds.arena.file import load_scene
from system.worlds.arena.geometry import clearance

SCENES = ("target", "obstacle-against-target")
RUNS, DIES = 50, 10
DURATION = 9.0  # s of a run
NEAR = 0.25  # m
REACHED, AVOIDED, WON = 0.9, 0.5, 0.9
WINDOW = 0.1  # s; ours: with 500 ms the robot swings about the target
EVERY = 10  # steps between two looks at the distance
# straight on it passes the other robot 30 cm beside it, and touches neither that nor the block
STRAIGHT = always(reached=0.0, touched_robot=0.0, touched_block=0.0, touched_wall=1.0)
# the paper's ten runs, of which eight avoid the robot then, and that a block was avoided
PAPER: list[Summary] = [
    {"reached": 1.0, "touched_robot": float(k >= 8), "touched_block": 0.0} for k in range(10)
]
NULLS = {**ROBOTS, "drives straight on": STRAIGHT}


def reproduce(
    progress: Progress, execution: Execution = ALONE, count: int = RUNS, dies: int = DIES,
    duration: float = DURATION,
) -> Report:  # fmt: skip
    """Drive to the target, without and with a block on the way."""
    bases = {
        name: Scenario(scene=name, window=WINDOW, duration=duration, silicon_noise="off", **IDEAL_CURRENTS)
        for name in SCENES
    }
    cells = {name: Drive(base, outcome, with_path=True) for name, base in bases.items()}
    parts = drive_repeats(execution, EXPERIMENT.name, cells, Runs(count, dies), Runs(RUNS, DIES), progress)
    found = summaries_of(parts)
    reached, block = found.values()
    nulls = runs_of(NULLS, found)
    paths = {name: [d.path for d in part] for name, part in parts.items()}
    return Report(
        rows(reached, block), lambda figure: _draw(paths, figure), notes(reached, block),
        nulls_of(lambda runs: rows(*runs.values()), nulls), rows(PAPER, PAPER[:1]),
    )  # fmt: skip


def outcome(trace: Trace) -> Summary:
    """Give the closest approach to the robot with the LED (m), and what was touched."""
    drive = trace.drive
    path = drive.path[::EVERY]
    closest = min(clearance(drive.obstacles, (x, y, h), t, "robot") for t, x, y, h in path)
    touched = drive.touched or ""
    return {
        "closest": closest,
        "reached": float(closest <= NEAR),
        "touched_robot": float(touched.startswith("robot")),
        "touched_block": float(touched.startswith("block")),
        "touched_wall": float(touched == "wall"),
    }


def rows(reached: Sequence[Summary], block: Sequence[Summary]) -> tuple[Statement, ...]:
    """Make the statements about reaching the target, avoiding it then, and the block on the way."""
    there = [s for s in reached if s["reached"]]
    arrived = share_where(bool(s["reached"]) for s in reached)
    avoided = share_where(not s["touched_robot"] for s in there)
    won = share_where(not s["touched_block"] for s in block)
    return (
        Statement("reached", "10 of 10", arrived.measured(), at_least(REACHED)),
        Statement("then_avoided", "8 of 10", avoided.measured(), at_least(AVOIDED)),
        Statement("obstacle_against_target_won", "obstacle", won.measured(), at_least(WON)),
    )


def notes(reached: Sequence[Summary], block: Sequence[Summary]) -> tuple[str, ...]:
    """Tell the closest approaches."""
    close = [100.0 * (s["closest"] or 0.0) for s in reached]
    low, middle, high = np.quantile(close, (0.1, 0.5, 0.9))
    walls = sum(bool(s["touched_wall"]) for s in (*reached, *block))
    return (
        f"closest approach {middle:.0f} cm ({low:.0f} to {high:.0f}, 10 to 90 %); walls touched {walls}",
        f"window {WINDOW:g} s, sliding",
    )


def _draw(paths: dict[str, list[F64]], figure: Figure) -> None:
    figure.set_size_inches(9.0, 3.4)
    for ax, (name, mine) in zip(figure.subplots(1, len(paths)), paths.items(), strict=True):
        draw_paths(load_scene(name), mine, ax)
        ax.set_title(f"{name}, {len(mine)} runs", fontsize=9)


EXPERIMENT = Experiment(
    "milde2017-target", "towards a standing robot with a blinking LED", reproduce,
    {"count": RUNS, "dies": DIES}, tuple(NULLS),
)  # fmt: skip
