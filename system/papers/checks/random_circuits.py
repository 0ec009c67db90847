"""Random circuits in the solver and in ngspice: points and transients of circuits that nobody designed.

Each number is a circuit of 3 to 12 devices (`netlists.ngspice.random_circuit`). Both engines have the same
equations, on the nominal die at 27 degC. ngspice looks for its operating point by itself. Where the points
differ by more than 1 mV, each is given to the other engine as a start: where both stay, the circuit has
several, which is counted and is no disagreement; else one of them is wrong. The transients begin at the
solver's point. A node that swings by 100 mV or more has edges, its crossings of the middle of its swing, of
which both runs must have as many, each within 1 % of the run; and its highest and lowest voltage must agree
to 1 % of its swing, that of any other node to 1 mV. No value is fitted, and no paper has it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.circuit import GROUND
from circuits.errors import SimulatorError, SolverError
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_testbench
from netlists.ngspice import engine
from netlists.ngspice import run as ngspice
from netlists.ngspice.form import started
from netlists.ngspice.library import NoOperatingPointError
from netlists.ngspice.random_circuit import random_testbench
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, PALE, sized_axes
from system.rule import all_of, at_least
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered

CIRCUIT = "circuit"
FIRST, CIRCUITS = 1000, 200
POINT = 1e-3  # V, between operating points, and between the ends of a node that hardly swings
SHARE = 0.01  # of the run for an edge, of the swing for an amplitude
LIVELY = 0.1  # V, least swing of a node that has edges
FOUND = 0.99  # least share of circuits whose operating point the solver finds
_HYSTERESIS = 0.1  # of the swing, by which a node leaves the middle before it crosses it again
_RTOL, _RELTOL = 1e-6, 1e-6


@dataclass(frozen=True, slots=True)
class Beside:
    """One circuit in both engines.

    number, devices: which circuit, and how many devices it has. solved, converged: whether the solver and
    ngspice find an operating point. point: largest difference of a node, V, None unless both do. several:
    whether the points differ and each is a rest state of the other engine. edge: largest distance of two
    edges as a share of the run, infinite where one run has more; amplitude: largest difference of an end as a
    share of what is allowed; both None where a run fails, which `failed` says.
    """

    number: int
    devices: int
    solved: bool
    converged: bool
    point: float | None = None
    several: bool = False
    edge: float | None = None
    amplitude: float | None = None
    failed: str = ""


def run(progress: Progress, execution: Execution = ALONE, circuits: int = CIRCUITS) -> Report:
    """Run every circuit in both engines."""
    keys = [Numbered(CIRCUIT, FIRST + k) for k in range(circuits)]
    campaign = Campaign(EXPERIMENT.name, beside, Numbered, Beside, (version("noctule"), _RTOL, _RELTOL))
    found = execution.by_condition(campaign, keys, progress)[CIRCUIT]
    return Report(tuple(_rows(found)), lambda figure: draw(found, figure), _notes(found))


def beside(key: Numbered) -> Beside:
    """Run the circuit of a number in both engines."""
    silicon = Silicon()
    bench = random_testbench(key.number, silicon)
    count = len(bench.circuit.devices) + sum(s.quantity == "current" for s in bench.sources)
    ours, peer = _solved(bench, silicon), _converged(bench, silicon)
    found = Beside(key.number, count, solved=ours is not None, converged=peer is not None)
    if ours is None or peer is None:
        return found
    point = _apart(ours.voltages(), peer)
    several = point > POINT and _is_rest_of_both(bench, silicon, ours, peer)
    try:
        edge, amplitude = _transients(started(bench, silicon), silicon)
    except (SolverError, SimulatorError) as error:
        return replace(found, point=point, several=several, failed=str(error))
    return replace(found, point=point, several=several, edge=edge, amplitude=amplitude)


def _solved(bench: Testbench, silicon: Silicon) -> OperatingPoint | None:
    try:
        return operating_point(bench, silicon)
    except SolverError:
        return None


def _converged(
    bench: Testbench, silicon: Silicon, start: dict[str, float] | None = None
) -> dict[str, float] | None:
    """Voltages (V) of ngspice's own operating point, near a start where one is given; None without one."""
    given = (
        bench
        if start is None
        else Testbench(bench.title, bench.circuit, bench.sources, bench.stop, start=start)
    )
    try:
        found = ngspice.run(format_testbench(given, silicon, analysis="op", reltol=_RELTOL))
    except NoOperatingPointError:
        return None
    names = engine.node_names(bench, silicon)
    return {GROUND: 0.0} | {path: float(found.values[name][0]) for path, name in names.items()}


def _apart(one: dict[str, float], other: dict[str, float]) -> float:
    return max(abs(v - one[node]) for node, v in other.items())


def _is_rest_of_both(
    bench: Testbench, silicon: Silicon, ours: OperatingPoint, peer: dict[str, float]
) -> bool:
    """Whether each engine stays at the other's point."""
    mine = ours.voltages()
    there = _converged(bench, silicon, {n: v for n, v in mine.items() if n != GROUND})
    here = operating_point(ours.machine, start={n: v for n, v in peer.items() if n != GROUND}).voltages()
    return there is not None and _apart(mine, there) <= POINT and _apart(here, peer) <= POINT


def _transients(bench: Testbench, silicon: Silicon) -> tuple[float, float]:
    """Worst edge and worst amplitude of both runs, as `Beside` has them."""
    ours = simulate(bench, silicon, rtol=_RTOL)
    peer = engine.simulate(bench, silicon, reltol=_RELTOL)
    edges, ends = [0.0], [0.0]
    for node in ours.nodes[1:]:
        a, b = ours[node], peer[node]
        swing = float(a.max() - a.min())
        allowed = SHARE * swing if swing >= LIVELY else POINT
        ends.append(max(abs(a.max() - b.max()), abs(a.min() - b.min())) / allowed)
        if swing >= LIVELY:
            middle = float(a.max() + a.min()) / 2.0
            edges.append(_edges_apart(ours, peer, node, middle, swing) / bench.stop)
    return max(edges), float(max(ends))


def _edges_apart(ours: Result, peer: Result, node: str, middle: float, swing: float) -> float:
    """Largest distance, s, of the crossings of the middle by both runs, in either direction."""
    worst = 0.0
    for sign in (1.0, -1.0):
        low = sign * middle - _HYSTERESIS * swing
        one, other = (
            engine.upward_crossings(r.time, sign * r[node], sign * middle, low) for r in (ours, peer)
        )
        if one.size != other.size:
            return float("inf")
        worst = max(worst, float(np.abs(one - other).max(initial=0.0)))
    return worst


def _rows(found: Sequence[Beside]) -> list[Statement]:
    """What must hold: points are found, points agree or are several, edges and amplitudes agree."""
    met = [one for one in found if one.point is not None]
    alike = sum(one.several or _least(one.point) <= POINT for one in met)
    edges = sum(_least(one.edge) <= SHARE for one in met)
    ends = sum(_least(one.amplitude) <= 1.0 for one in met)
    every = len(met)
    return [
        Statement(
            "share_with_a_point", None, sum(one.solved for one in found) / len(found),
            at_least(FOUND, "{limit:g} or more"),
        ),
        Statement("same_point", None, float(alike), all_of(every, "all {limit:g}, to 1 mV or several")),
        Statement("same_edges", None, float(edges), all_of(every, "all {limit:g}, to 1 % of the run")),
        Statement("same_amplitudes", None, float(ends), all_of(every, "all {limit:g}, to 1 % of the swing")),
    ]  # fmt: skip


def _least(value: float | None) -> float:
    return float("inf") if value is None else value


def _notes(found: Sequence[Beside]) -> tuple[str, ...]:
    met = [one for one in found if one.point is not None]
    fewest, most = min(o.devices for o in found), max(o.devices for o in found)
    told = (
        f"{len(found)} circuits of {fewest} to {most} devices:"
        f" ngspice finds a point of {sum(o.converged for o in found)}, the solver of"
        f" {sum(o.solved for o in found)}; {sum(o.several for o in met)} have several."
    )
    worst = [
        f"circuit {o.number}: point {_text(o.point, 'V')}, edges {_text(o.edge, 'of the run')}, amplitude"
        f" {_text(o.amplitude, 'of what is allowed')}{'; ' if o.failed else ''}{o.failed}."
        for o in met
        if not (o.several or _least(o.point) <= POINT) or _least(o.edge) > SHARE or _least(o.amplitude) > 1.0
    ]
    lost = [
        f"circuit {o.number}: no point in {_missing(o)}." for o in found if not (o.solved and o.converged)
    ]
    return (told, *worst, *lost)


def _missing(one: Beside) -> str:
    return " and ".join(n for n, has in (("the solver", one.solved), ("ngspice", one.converged)) if not has)


def _text(value: float | None, unit: str) -> str:
    return "none" if value is None else f"{value:.3g} {unit}"


def draw(found: Sequence[Beside], figure: Figure) -> None:
    """Fill `figure` with every circuit's difference as a share of what is allowed for it."""
    axes = sized_axes(figure, 7.0, 3.5)
    for values, colour, label in (
        (_shares(found, "point", POINT), PALE, "operating point"),
        (_shares(found, "edge", SHARE), COLOURS[0], "edges"),
        (_shares(found, "amplitude", 1.0), COLOURS[1], "amplitudes"),
    ):
        axes.plot(np.sort(values), np.linspace(0.0, 100.0, values.size), color=colour, label=label)
    axes.axvline(1.0, color="black", linewidth=0.8, linestyle=":")
    axes.set(xscale="log", xlabel="difference over what is allowed", ylabel="circuits (%)")
    axes.legend()


def _shares(found: Sequence[Beside], name: str, allowed: float) -> F64:
    values = [getattr(one, name) for one in found]
    return np.array([max(v / allowed, 1e-9) for v in values if v is not None and np.isfinite(v)])


EXPERIMENT = Experiment(
    "random-circuits", "random circuits of up to 12 devices in the solver and in ngspice",
    run, {"circuits": CIRCUITS},
)  # fmt: skip
