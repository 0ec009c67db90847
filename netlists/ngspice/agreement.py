"""Agreement of the solver with ngspice: the same testbench, the same equations, both converged.

ngspice is converged where halving its reltol and its largest step moves nothing by more than a quarter of
what is allowed; where it moves more, both are tightened (reltol tenfold, the step fourfold) and halved again.
The solver runs at one tight rtol and is compared with the finest of these runs.

Allowed: spikes equally many, each within 1 us + 0.01 % of its time; every node that no source fixes within
1 mV rms over time; operating points within 0.1 mV.

Edges. An edge of 5 V in 50 ns that comes 0.1 us late is 12 mV rms over 16 ms, though its time is well within
what is allowed. So voltages are compared on 20,001 equally spaced times without those within w of an edge: a
vertex of a stimulus (samples are none), or a crossing of half the supply by any node, in either direction and
in either run. w is 50 us, or less where the windows together would cover more than 10 % of the run:
`w = min(50 us, 10 % of the run / (2 edges))`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.block import Block
from circuits.circuit import GROUND
from circuits.lowering.supply import half_supply
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point as solve_point
from circuits.solver.transient import Result
from circuits.solver.transient import simulate as solve
from circuits.testbench import Testbench
from netlists.ngspice import engine
from netlists.ngspice.deadline import DEADLINE
from netlists.registry import DEFAULT_RELTOL, POINTS, Method

SPIKE_TIME, SPIKE_SHARE = 1e-6, 1e-4  # s, and share of the spike's time
NODE_RMS = 1e-3  # V
OPERATING_POINT = 1e-4  # V
CONVERGED = 0.25  # share of what is allowed, by which halving may move ngspice
SOLVER_RTOL = 1e-8

_SAMPLES = 20_001
_WINDOW = 50e-6  # s
_EXCLUDED = 0.1  # largest share of the run left out around edges
_GLANCE = 1e-3  # share of a run that tells which measures a block has
_TRIES = 4  # tightenings of ngspice before it counts as not converging


@dataclass(frozen=True, slots=True)
class Difference:
    """How far two runs of a testbench are apart.

    `spike_time` is the worst difference (s) by its share of `spike_allowance` (s), 0 without spikes;
    `node_rms` in V by node; `operating_point` the worst difference in V; `excluded` the share of the time
    left out of `node_rms`.
    """

    same_count: bool
    spike_time: float
    spike_allowance: float
    node_rms: Mapping[str, float] = field(repr=False)
    operating_point: float
    excluded: float

    @property
    def worst_node(self) -> str:
        """The node that differs most."""
        return max(self.node_rms, key=lambda node: self.node_rms[node])

    @property
    def worst_rms(self) -> float:
        """Difference of the worst node, V rms."""
        return self.node_rms[self.worst_node]

    @property
    def share(self) -> float:
        """The largest difference as a share of what is allowed for it; infinite if a spike is missing."""
        if not self.same_count:
            return float("inf")
        return max(
            self.spike_time / self.spike_allowance,
            self.worst_rms / NODE_RMS,
            self.operating_point / OPERATING_POINT,
        )


@dataclass(frozen=True, slots=True)
class Agreement:
    """The solver beside ngspice on one testbench.

    `difference`: solver against ngspice's finest run; `convergence`: that run against the one with twice its
    `reltol` and `tmax` (s).
    """

    name: str
    temperature_c: float
    difference: Difference
    convergence: Difference
    reltol: float
    tmax: float
    solver: Result = field(repr=False)
    ngspice: Result = field(repr=False)

    @property
    def converged(self) -> bool:
        """Whether ngspice's answer stays where it is when its tolerances are halved."""
        return self.convergence.share <= CONVERGED

    @property
    def agrees(self) -> bool:
        """Whether both are converged and within all that is allowed."""
        return self.converged and self.difference.share <= 1.0


def compare(
    target: Block | Testbench,
    silicon: Silicon,
    *,
    rtol: float = SOLVER_RTOL,
    reltol: float = DEFAULT_RELTOL,
    points: int = POINTS,
    method: Method = "gear",
    deadline_s: float | None = DEADLINE,
) -> Agreement:
    """Run a testbench, or a block's with its stimuli scaled to the temperature, in both engines.

    Where the testbench has a start, ngspice begins in the solver's rest state at this temperature.

    Parameters
    ----------
    target
        A testbench, or a block with its default parameters and stimuli (see `scaled_testbench`).
    silicon
        Process and temperature.
    rtol
        The solver's.
    reltol, points
        Where ngspice begins: its reltol, and steps at least in a run.
    method
        ngspice's integration.
    deadline_s
        Wall-clock seconds for each run of ngspice; None for as long as it takes.

    Raises
    ------
    SimulatorError
        ngspice is missing, fails, or is too slow.
    """
    testbench = scaled_testbench(target, silicon) if isinstance(target, Block) else target
    if testbench.start:  # near the rest at one temperature, which can be too far at another
        testbench = started(testbench, silicon)
    ours = solve(testbench, silicon, rtol=rtol)
    tmax = testbench.stop / points
    found = _beside(ours, reltol, tmax, method, deadline_s)
    for k in range(1, _TRIES):
        if found.converged:
            break
        found = _beside(ours, reltol / 10.0**k, tmax / 4.0**k, method, deadline_s)
    return found


def scaled_testbench(block: Block, silicon: Silicon) -> Testbench:
    """Testbench of a block with its defaults, its delay scaled to the temperature.

    A block that measures `t_inh_s` has delays that follow it: `delay` is multiplied by
    `t_inh(T) / t_inh(27 degC)` of the nominal block, pulse widths stay, and the run gets longer by that ratio
    where it is above 1; so does the run of a block that measures its own `delay_s`. Other blocks keep their
    stimuli.
    """
    circuit = block.build(block.params())
    v_dd = silicon.process.v_dd
    stimuli = block.defaults
    nominal = block.testbench(circuit, stimuli, v_dd)
    ratio = delay_ratio(block, silicon)
    if ratio == 1.0:
        return nominal
    if "delay" in stimuli:
        stimuli["delay"] = ratio * (stimuli["delay"] or 0.0)
    if ratio > 1.0:
        stimuli["duration"] = ratio * nominal.stop
    return block.testbench(circuit, stimuli, v_dd)


def started(testbench: Testbench, silicon: Silicon) -> Testbench:
    """The testbench with the solver's rest state as ngspice's start, which saves it minutes on a chip.

    ngspice still solves for its own; that it is the same without the start is for `engine.operating_point`.
    """
    rest = solve_point(testbench, silicon).voltages()
    return replace(testbench, start={node: v for node, v in rest.items() if node != GROUND})


def delay_ratio(block: Block, silicon: Silicon) -> float:
    """Delay over that at 27 degC, nominal block: its t_inh after a call alone, or its `delay_s`; else 1."""
    nominal = _delay(block, Silicon(silicon.process))
    here = _delay(block, silicon)
    return 1.0 if nominal is None or here is None else here / nominal


def _delay(block: Block, silicon: Silicon) -> float | None:
    """The block's delay, s, from the first of ever longer runs that has it; None without one."""
    stimuli = block.defaults
    if "duration" not in stimuli:
        return None
    circuit, v_dd = block.build(block.params()), silicon.process.v_dd
    name = "t_inh_s" if "echo" in stimuli else "delay_s"
    if "echo" in stimuli:
        stimuli["echo"] = None
    bench = block.testbench(circuit, stimuli, v_dd)
    if name not in block.measures(solve(replace(bench, stop=_GLANCE * bench.stop), silicon)):
        return None
    for factor in (1.0, 4.0, 16.0, 64.0):
        stimuli["duration"] = factor * bench.stop
        found = block.measures(solve(block.testbench(circuit, stimuli, v_dd), silicon))[name]
        if found is not None:
            return found
    return None


def difference(one: Result, other: Result) -> Difference:
    """Compare two runs of one testbench."""
    same, late, allowed = _spike_difference(one, other)
    keep = _kept(one, other)
    grid = np.linspace(0.0, one.machine.testbench.stop, _SAMPLES)[keep]
    solved = [n for n in one.nodes if one.machine.column_of(n) < one.machine.kernel.unknowns]
    rms = {n: _rms(np.interp(grid, one.time, one[n]) - np.interp(grid, other.time, other[n])) for n in solved}
    rest, again = one.operating_point.voltages(), other.operating_point.voltages()
    apart = max(abs(rest[node] - again[node]) for node in rest)
    return Difference(same, late, allowed, rms, apart, 1.0 - float(np.mean(keep)))


def _beside(ours: Result, reltol: float, tmax: float, method: Method, deadline_s: float | None) -> Agreement:
    """Set the solver's run beside ngspice's at `reltol` and `tmax` (s) and at half of both."""
    testbench, silicon = ours.machine.testbench, ours.machine.silicon
    coarse, fine = (
        engine.simulate(
            testbench, silicon, reltol=reltol / h, tmax=tmax / h, method=method, deadline_s=deadline_s
        )
        for h in (1.0, 2.0)
    )
    return Agreement(
        testbench.title, silicon.temperature_c, difference(ours, fine), difference(coarse, fine),
        0.5 * reltol, 0.5 * tmax, ours, fine,
    )  # fmt: skip


def _rms(values: F64) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _spike_difference(one: Result, other: Result) -> tuple[bool, float, float]:
    """Whether counts are equal; the worst difference and what is allowed for it, s."""
    worst = (0.0, SPIKE_TIME)
    for port, times in one.spikes.items():
        again = other.spikes[port]
        if times.size != again.size:
            return False, float("inf"), SPIKE_TIME
        for a, b in zip(times.tolist(), again.tolist(), strict=True):
            found = (abs(a - b), SPIKE_TIME + SPIKE_SHARE * b)
            worst = max(worst, found, key=lambda w: w[0] / w[1])
    return True, *worst


def _kept(one: Result, other: Result) -> Bools:
    """Samples that are not within the window of an edge."""
    stop = one.machine.testbench.stop
    edges = np.sort(np.concatenate([_vertices(one), _crossings(one), _crossings(other), [-np.inf, np.inf]]))
    count = edges.size - 2
    window = min(_WINDOW, _EXCLUDED * stop / (2.0 * max(count, 1)))
    grid = np.linspace(0.0, stop, _SAMPLES)
    after = np.searchsorted(edges, grid)
    return np.asarray(np.minimum(grid - edges[after - 1], edges[after] - grid) > window)


def _vertices(result: Result) -> F64:
    """Times of the stimuli's vertices within the run, s."""
    machine = result.machine
    lines = [t for (t, _), sampled in zip(machine.polylines, machine.sampled, strict=True) if not sampled]
    times = np.concatenate([np.zeros(0), *lines])
    return times[(times > 0.0) & (times < machine.testbench.stop)]


def _crossings(result: Result) -> F64:
    """Times at which any node crosses half the supply, s; crossings of one step of a run count once."""
    above = result.voltage >= half_supply(result.machine)
    k = np.flatnonzero((above[1:] != above[:-1]).any(axis=1))
    return np.asarray(0.5 * (result.time[k] + result.time[k + 1]))
