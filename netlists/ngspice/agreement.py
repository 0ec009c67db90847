"""Agreement of the solver with ngspice: the same testbench, the same equations, both converged.

ngspice is converged where halving its reltol and its largest step moves nothing by more than a quarter of
what is allowed; where it moves more, both are tightened (reltol tenfold, the step fourfold) and halved again.
The solver runs at one tight rtol and is compared with the finest of these runs.

What may differ is an `Allowance`. The usual one allows spikes equally many, each within 1 us + 0.01 % of its
time; every node that no source fixes within 1 mV rms over time; operating points within 0.1 mV. It follows
from how both engines stop: ngspice's own error is at most about a third of it once halving moves a quarter
(an error that falls at least with the tolerance); the solver's at rtol 1e-8 is a hundredth of it or less.

Nothing agrees where nothing was compared. A testbench that drives or watches something must show a spike, or
a node that moves by more than what is allowed, so that a constant in its place would be told.

Edges. An edge of 5 V in 50 ns that comes 0.1 us late is 12 mV rms over 16 ms, though its time is well within
what is allowed. So voltages are compared on 20,001 equally spaced times without those within w of an edge: a
vertex of a stimulus (samples are none), or a crossing of half the supply by any node, in either direction and
in either run. w is 50 us, or less where the windows together would cover more than 10 % of the run:
`w = min(50 us, 10 % of the run / (2 edges))`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from circuits.arrays import F64, Bools
from circuits.devices.source import Constant
from circuits.lowering.supply import half_supply
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result
from circuits.solver.transient import simulate as solve
from circuits.testbench import Testbench
from netlists.ngspice import engine
from netlists.ngspice.deadline import DEADLINE
from netlists.ngspice.form import started
from netlists.registry import DEFAULT_RELTOL, POINTS, Method

CONVERGED = 0.25  # share of what is allowed, by which halving may move ngspice
SOLVER_RTOL = 1e-8

_SAMPLES = 20_001
_WINDOW = 50e-6  # s
_EXCLUDED = 0.1  # largest share of the run left out around edges
_TRIES = 4  # tightenings of ngspice before it counts as not converging


@dataclass(frozen=True, slots=True)
class Allowance:
    """What two converged runs of a testbench may differ by.

    Attributes
    ----------
    spike_time, spike_share
        A spike may come earlier or later by `spike_time` (s) and by `spike_share` of its time together.
    node_rms
        Difference of a node's voltage over the run, V rms.
    operating_point
        Difference of any node's voltage at the operating point, V.
    """

    spike_time: float = 1e-6
    spike_share: float = 1e-4
    node_rms: float = 1e-3
    operating_point: float = 1e-4


USUAL = Allowance()
"""What two converged runs may usually differ by: the defaults of `Allowance`."""


@dataclass(frozen=True, slots=True)
class Difference:
    """How far two runs of a testbench are apart.

    Attributes
    ----------
    same_count
        Whether both runs have equally many spikes at every port.
    spike_time, spike_allowance
        The spike that is worst by its share of what is allowed for it: how far apart the runs have it, and
        what is allowed, s. Without spikes the difference is 0.
    node_rms
        Difference of every node that no source fixes, V rms over the times that are compared.
    operating_point
        Difference of the worst node at the operating point, V.
    excluded
        Share of the run that is left out of `node_rms` because it is near an edge.
    moved
        How far the liveliest of these nodes is from its own mean in the first run, V rms over the same times.
    allowed
        What may differ.
    """

    same_count: bool
    spike_time: float
    spike_allowance: float
    node_rms: Mapping[str, float] = field(repr=False)
    operating_point: float
    excluded: float
    moved: float
    allowed: Allowance = USUAL

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
            self.worst_rms / self.allowed.node_rms,
            self.operating_point / self.allowed.operating_point,
        )


@dataclass(frozen=True, slots=True)
class Agreement:
    """The solver beside ngspice on one testbench.

    Attributes
    ----------
    name, temperature_c
        Title of the testbench, and the temperature of the silicon, degC.
    difference
        The solver's run against ngspice's finest.
    convergence
        ngspice's finest run against the one with twice its `reltol` and `tmax`.
    reltol, tmax
        Relative tolerance and largest step (s) of ngspice's finest run.
    solver, ngspice
        Both runs.
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
    def spike_count(self) -> int:
        """How many spikes the solver has, at all watched ports together."""
        return sum(times.size for times in self.solver.spikes.values())

    @property
    def compared(self) -> bool:
        """Whether there is something that could differ, see `shows_something`."""
        return shows_something(self.solver, self.difference)

    @property
    def agrees(self) -> bool:
        """Whether something was compared, both are converged, and all is within what is allowed."""
        return self.compared and self.converged and self.difference.share <= 1.0


def compare(
    testbench: Testbench,
    silicon: Silicon,
    *,
    rtol: float = SOLVER_RTOL,
    reltol: float = DEFAULT_RELTOL,
    points: int = POINTS,
    method: Method = "gear",
    deadline_s: float | None = DEADLINE,
    allowed: Allowance = USUAL,
) -> Agreement:
    """Run a testbench in both engines.

    Where the testbench has a start, ngspice begins in the solver's rest state at this temperature.

    Parameters
    ----------
    testbench
        Circuit, sources and stop time; `netlists.ngspice.form` makes those of blocks.
    silicon
        Process, die and temperature.
    rtol
        The solver's relative tolerance.
    reltol, points
        Where ngspice begins: its relative tolerance, and how many steps a run has at least.
    method
        ngspice's integration.
    deadline_s
        Wall-clock time for each run of ngspice, s; None for as long as it takes.
    allowed
        What may differ.

    Raises
    ------
    SimulatorError
        ngspice is missing, fails, or is too slow.
    """
    if testbench.start:  # near the rest at one temperature, which can be too far at another
        testbench = started(testbench, silicon)
    ours = solve(testbench, silicon, rtol=rtol)
    tmax = testbench.stop / points
    found = _beside(ours, reltol, tmax, method, deadline_s, allowed)
    for k in range(1, _TRIES):
        if found.converged:
            break
        found = _beside(ours, reltol / 10.0**k, tmax / 4.0**k, method, deadline_s, allowed)
    return found


def shows_something(run: Result, apart: Difference) -> bool:
    """Whether a run, apart from another by so much, has something that could differ.

    That is a spike, a node that moves by more than may differ, or the operating point of a testbench that
    neither drives nor watches anything.
    """
    testbench = run.machine.testbench
    at_rest = all(isinstance(s.waveform, Constant) for s in testbench.sources) and not testbench.watch
    spikes = any(times.size for times in run.spikes.values())
    return at_rest or spikes or apart.moved > apart.allowed.node_rms


def difference(one: Result, other: Result, allowed: Allowance = USUAL) -> Difference:
    """Compare two runs of one testbench."""
    same, late, allowance = _spike_difference(one, other, allowed)
    keep = _kept(one, other)
    grid = np.linspace(0.0, one.machine.testbench.stop, _SAMPLES)[keep]
    solved = [n for n in one.nodes if one.machine.column_of(n) < one.machine.kernel.unknowns]
    own = {n: np.interp(grid, one.time, one[n]) for n in solved}
    rms = {n: _rms(v - np.interp(grid, other.time, other[n])) for n, v in own.items()}
    moved = max(_rms(v - np.mean(v)) for v in own.values())
    rest, again = one.operating_point.voltages(), other.operating_point.voltages()
    apart = max(abs(rest[node] - again[node]) for node in rest)
    return Difference(same, late, allowance, rms, apart, 1.0 - float(np.mean(keep)), moved, allowed)


def _beside(
    ours: Result,
    reltol: float,
    tmax: float,
    method: Method,
    deadline_s: float | None,
    allowed: Allowance,
) -> Agreement:
    """Set the solver's run beside ngspice's at `reltol` and `tmax` (s) and at half of both."""
    testbench, silicon = ours.machine.testbench, ours.machine.silicon
    coarse, fine = (
        engine.simulate(
            testbench, silicon, reltol=reltol / h, tmax=tmax / h, method=method, deadline_s=deadline_s
        )
        for h in (1.0, 2.0)
    )
    return Agreement(
        testbench.title, silicon.temperature_c,
        difference(ours, fine, allowed), difference(coarse, fine, allowed),
        0.5 * reltol, 0.5 * tmax, ours, fine,
    )  # fmt: skip


def _rms(values: F64) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _spike_difference(one: Result, other: Result, allowed: Allowance) -> tuple[bool, float, float]:
    """Whether counts are equal; the worst difference and what is allowed for it, s."""
    worst = (0.0, allowed.spike_time)
    for port, times in one.spikes.items():
        again = other.spikes[port]
        if times.size != again.size:
            return False, float("inf"), allowed.spike_time
        for a, b in zip(times.tolist(), again.tolist(), strict=True):
            found = (abs(a - b), allowed.spike_time + allowed.spike_share * b)
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
