"""Section 3.4, Figures 10 and 11 of Milde et al. 2017: 8 to 12 blocks, plain and modified architecture.

The paper: at 0.35 m/s the plain network touches two of the obstacles in its figure's run; the modified one
avoids collisions at 0.5 m/s. Both networks drive through the same scenes on the same dies; a run ends at its
first collision, the arena's wall included. As in the paper the plain network's spikes are counted in fixed
windows of 500 ms, the modified one's in a running window (ours: 100 ms); turn factor 1 (ours). Rule: at
0.5 m/s the modified network has fewer collisions, paired (exact sign test on the scenes in which they differ,
p < 0.05).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import binomtest

from system.experiment import Experiment, Progress, Report, Row
from system.plot import COLOURS
from system.pushbot import Scenario, Trace, summarise
from system.pushbot_campaign import Summary, drive_each, share_of, trials
from system.pushbot_readout import Kind
from system.pushbot_robot import SPEED_OF_FACTOR

SPEEDS = (0.35, 0.5)  # m/s; the paper's
NETWORKS = ("plain", "modified")
SCENES, DIES = 100, 25
DURATION = 20.0  # s; ours
TURN = 1.0  # turn factor; ours: the better one of Table 1
READOUTS: Mapping[str, Kind] = {"plain": "fixed", "modified": "sliding"}
P = 0.05

Found = Mapping[tuple[str, float], Sequence[Summary]]


def reproduce(
    progress: Progress, count: int = SCENES, dies: int = DIES, duration: float = DURATION
) -> Report:
    """Drive all scenes four times."""
    keys = [(network, speed) for network in NETWORKS for speed in SPEEDS]
    plan: list[Scenario] = []
    for network, speed in keys:
        base = Scenario(
            scene="clutter", turn_factor=TURN, duration=duration, modified=network == "modified",
            readout=READOUTS[network],
        )  # fmt: skip
        plan += trials(replace(base, speed_factor=speed / SPEED_OF_FACTOR), count, dies)
    all_found = drive_each(plan, _outcome, progress)
    found = {key: all_found[k * count : (k + 1) * count] for k, key in enumerate(keys)}
    return Report(rows(found), lambda figure: _draw(found, figure), notes(found))


def _outcome(trace: Trace) -> Summary:
    touched = trace.drive.touched or ""
    return summarise(trace) | {
        "touched_block": float(touched.startswith("block")), "touched_wall": float(touched == "wall")
    }  # fmt: skip


def rows(found: Found) -> tuple[Row, ...]:
    """The modified against the plain network at the higher speed."""
    plain, modified = (found[network, SPEEDS[1]] for network in NETWORKS)
    pairs = [(bool(a["collided"]), bool(b["collided"])) for a, b in zip(plain, modified, strict=True)]
    better, worse = pairs.count((True, False)), pairs.count((False, True))
    p = binomtest(better, better + worse).pvalue if better + worse else 1.0
    return (
        Row(
            "modified_collides_less_at_0.5_m_per_s", "no collisions",
            f"{better} scenes better, {worse} worse, p {p:.2g}", f"better, p < {P:g}", P, fitted=False,
            agrees=better > worse and p < P,
        ),
    )  # fmt: skip


def notes(found: Found) -> tuple[str, ...]:
    """Collisions of each, and the way driven to one."""
    out = []
    for (network, speed), runs in found.items():
        way = float(np.sum([s["path_m"] or 0.0 for s in runs]))
        met = share_of(runs, "collided")
        blocks, walls = (share_of(runs, f"touched_{name}").passed for name in ("block", "wall"))
        each = way / max(met.passed, 1)
        out.append(
            f"{network}, {speed:g} m/s: collided {met}, of them blocks {blocks}, wall {walls};"
            f" {each:.2f} m a collision"
        )
    return tuple(out)


def _draw(found: Found, figure: Figure) -> None:
    figure.set_size_inches(6.0, 3.4)
    ax = figure.subplots()
    for k, ((network, speed), runs) in enumerate(found.items()):
        ends = np.sort([s["time_s"] or 0.0 for s in runs if s["collided"]])
        left = 1.0 - np.arange(1, ends.size + 1) / len(runs)
        ax.step([0.0, *ends], [1.0, *left], where="post", color=COLOURS[k], label=f"{network}, {speed:g} m/s")
    ax.set_xlabel("time (s)")
    ax.set_ylabel("share without a collision")
    ax.set_ylim(0.0, 1.02)
    ax.legend(fontsize=8)


EXPERIMENT = Experiment("milde2017-clutter", "plain and modified network among many blocks", reproduce)
