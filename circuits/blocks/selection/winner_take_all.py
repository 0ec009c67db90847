"""Winner-take-all: of N currents the greatest takes a shared tail current and raises its line.

The currents are the desirabilities of directions. Cell k has an excitation and a risk, both currents. Risks
inhibit their neighbourhood through a projection of current mirrors, whose widths are a Gaussian of the
distance up to `reach`:

    I_k = I_excite,k - sum_{|d| <= reach} e^{-d^2 / sigma^2} I_risk,k+d

This current charges v_in,k against the transistor `m1`. The gate v_common of all `m1` is shared. It follows
the highest v_in through `m2` and carries one tail current I_B away, so that it settles where the `m1` of the
best cell takes all of its current. The `m1` of all other cells could take more than they are given, and their
v_in fall. The winner is the cell whose current over the strength of its own `m1` is the greatest; a sum below
0 leaves its v_in at ground.

A line goes high where a cell has the share x = 0.64 of the tail: more than half, so that two lines are never
high at once. While `equalise` is high all v_in are joined, and a decision begins when it falls. Without it
cells that are tied would stay where the last decision left them, because the `m1` have no output resistance
to pull them together. From then on the v_in of the best two part at the difference of their currents,
whatever v_common does:

    t = t_0 + C dV / (c I),    m2 of the winner carries x I_B and that of the rival (1 - x) I_B at dV

with the contrast c = (I - I_rival) / I. There is no feedback within a cell, so that the time grows as 1/c and
not as ln(1/c), as the tests measure. Near a tie the answer does not come: no line is high.

A risk that falls leaves the gates of its mirrors slowly, as the diode's own current does: from 20 nA to 0.1
nA it is at 0.24 nA after 0.2 ms and at 0.107 nA after 1 ms (27 degC), so that `equalise` lasts a millisecond
or more.

`share` is the gate of each cell's output mirror: a pFET like `mo` there copies the cell's part of the tail.
The bleed `mb` keeps that node defined in a cell without current. While the v_in are joined, their sum rests
on the loop of `m1` and `m2` alone; the diodes `md`, `me` at the joint give it a conductance of its own.

Sources: the cell of two transistors is that of Lazzaro, Ryckebusch, Mahowald & Mead, "Winner-take-all
networks of O(N) complexity" (1989). Gaussian inhibition of desirabilities and 33 directions are from Wen &
Horiuchi 2022, equation (6), where `e^{-d^2 / sigma^2}` has no factor 2. The other circuits and all numbers
are ours; a reach of 3 at sigma 2 leaves weights of 1.8 % and less out. Beyond the last cell there is nothing,
as in the equation; the mirrors that would come from there are built with their gates at ground, so that all
v_in have one capacitance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, I64
from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import current_into, powered, step
from circuits.blocks.mos import current_mirror, inverter, mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, event_in, event_out
from circuits.blocks.rest import started_at_rest
from circuits.blocks.sizes import Sizes
from circuits.circuit import Bias, Circuit, Node, Port
from circuits.devices import Capacitor, Device
from circuits.errors import ParameterError
from circuits.lowering.supply import half_supply
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

CELLS = 33  # of the selection: the motor choices of the paper
PROJECTION = (30.0, 12.0)  # um, of the diode that takes a risk, and of the mirror at distance 0
TAIL = (12.0, 6.0)
REFERENCE = (8.0, 6.0)  # um: two thirds of the tail
BLEED = (3.0, 60.0)  # um: a fortieth of the tail
LOAD = (3.0, 12.0)  # um


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Number of cells, width and reach of the projection (cells), and a cell's capacitor (F); ours.

    Nine cells are enough to see a decision and quick in any simulator; the selection has `CELLS`.
    """

    cells: int = quantity(9, "", least=2)
    sigma: float = quantity(2.0, "")
    reach: int = quantity(3, "", least=0)
    input_capacitance: float = quantity(0.5e-12, "F")


BIASES = (Bias("i_tail", "v_tail", "gate", 1e-6, "mt"),)  # ours


def weight(params: Params, distance: int) -> float:
    """Weight of a risk that is `distance` cells away, without dimension."""
    return math.exp(-((distance / params.sigma) ** 2))


def cell(params: Params = Params()) -> Circuit:
    """One direction: its input mirrors, the pair m1 and m2, and its share compared with the reference."""
    ports = (
        SUPPLY,
        *analog_in("excite", "risk"),
        *analog_out("v_in", "v_common", "joint"),
        *event_in("equalise"),
        *bias_in("v_tail"),
        *analog_out("share"),
        *event_out("line"),
    )
    devices: tuple[Device, ...] = (
        *current_mirror("mx", "my", "p", "excite", "v_in", (6, 24)),
        mos("mk", "n", "risk", "risk", "0", *PROJECTION),
        mos("m1", "n", "v_in", "v_common", "0", 6, 24),
        mos("m2", "n", "share", "v_in", "v_common", 12, 3),
        Capacitor("c_in", "v_in", "0", params.input_capacitance),
        mos("me", "n", "v_in", "equalise", "joint", 3, 1.5),
        mos("mo", "p", "share", "share", "vdd", 6, 6),
        mos("mb", "n", "share", "v_tail", "0", *BLEED),
        mos("ms", "p", "taken", "share", "vdd", 6, 6),
        mos("mr", "n", "taken", "v_tail", "0", *REFERENCE),
        *inverter("mi", "taken", "lost", width=3, length=1.5),
        *inverter("mj", "lost", "line", width=3, length=1.5),
    )
    return Circuit("selection_cell", ports, devices)


def build(params: Params = Params()) -> Circuit:
    """The circuit: ports excite[N] (currents out), risk[N] (currents in), equalise; share[N], line[N] (out).

    Raises `ParameterError` for sizes that cannot be built.
    """
    shape = (int(params.cells),)
    ports = (
        SUPPLY,
        Port("excite", "analog", "in", shape),
        Port("risk", "analog", "in", shape),
        *event_in("equalise"),
        Port("share", "analog", "out", shape),
        Port("line", "event", "out", shape),
        *bias_in("v_tail"),
    )
    cells = cell(params).array("cell", shape)
    shared = (
        mos("mt", "n", "v_common", "v_tail", "0", *TAIL),
        mos("md", "n", "joint", "joint", "half", *LOAD),
        mos("me", "n", "half", "half", "0", *LOAD),
    )
    devices = (*shared, *_projection(params))
    return Circuit("winner_take_all", ports, devices, (cells,), (Node("v_in", shape),), BIASES)


def projection_name(target: int, source: int, reach: int) -> str:
    """Name of the mirror by which the risk of cell `source` inhibits cell `target`."""
    return f"mg{target}_{source - target + reach}"


def _projection(params: Params) -> Iterator[Device]:
    """Single devices, because no array of instances connects shifted rows of nodes."""
    width, length = PROJECTION
    for k in range(int(params.cells)):
        for d in range(-params.reach, params.reach + 1):
            inside = 0 <= k + d < params.cells
            gate = f"risk[{k + d}]" if inside else "0"
            name = projection_name(k, k + d, params.reach)
            yield mos(name, "n", f"v_in[{k}]", gate, "0", width * weight(params, d), length)


RELEASE = 10e-6  # s, ours: a decision begins
EDGE = 0.1e-6  # s
STOP = 40e-6
STANDING = 0.1e-9  # A, ours: of a risk of 0, so that every mirror's gate is defined
OTHERS = 0.7  # excitation of the other cells, a share of the winner's; ours


def decision_testbench(
    circuit: Circuit, excite: F64, risk: F64, stop: float, v_dd: float, release: float = RELEASE
) -> Testbench:
    """One decision: currents from the beginning on, and `equalise` high until `release`, s.

    excite, risk: float64[N], A; a risk is at least `STANDING`. stop: s.
    """
    sources = [*powered(v_dd, {"equalise": step(release, release + EDGE, v_dd, 0.0)})]
    for k in range(excite.size):
        sources.append(current_into(f"excite[{k}]", -float(excite[k])))
        sources.append(current_into(f"risk[{k}]", max(float(risk[k]), STANDING)))
    return Testbench("winner-take-all", circuit, tuple(sources), stop, watch=("line",))


STIMULI = (
    Stimulus("winner", "", 4.0, "cell with the greatest excitation"),
    Stimulus("rival", "", 7.0, "cell with the second greatest", can_be_off=True),
    Stimulus("contrast", "", 0.05, "difference of these two over the greater"),
    Stimulus("scale", "A", 50e-9, "excitation of the winner"),
    Stimulus("obstacle", "", 1.0, "cell whose risk inhibits its neighbourhood", can_be_off=True),
    Stimulus("risk", "A", 10e-9, "its risk"),
    DURATION,
)
PLOTTED = ("equalise", "v_common", "v_in[4]", "v_in[7]", "v_in[1]", "line[4]")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A winner, a rival `contrast` below it, all others at 0.7 of it, and the risk of one obstacle."""
    n = circuit.port("line").shape[0]
    scale, contrast = stimuli["scale"] or 0.0, stimuli["contrast"] or 0.0
    if not (scale > 0.0 and 0.0 <= contrast <= 1.0):
        raise ParameterError(
            f"scale: {scale:g} A, contrast: {contrast:g}, must be > 0 and 0 to 1; give both so"
        )
    excite, risk = np.full(n, OTHERS * scale), np.zeros(n)
    for name, array, value in (
        ("rival", excite, scale * (1.0 - contrast)),
        ("winner", excite, scale),
        ("obstacle", risk, stimuli["risk"] or 0.0),
    ):
        number = stimuli[name]
        if number is None:
            continue
        if number != int(number) or not 0 <= number < n:
            raise ParameterError(f"{name}: {number:g}, must be a cell from 0 to {n - 1}, or off")
        array[int(number)] = value
    bench = decision_testbench(circuit, excite, risk, stimuli["duration"] or STOP, v_dd)
    return started_at_rest(bench, AMI_1500_IDEAL)


def lines_high(result: Result) -> I64:
    """Numbers of the cells whose line is high at the end of a run, int64[n]."""
    half = half_supply(result.machine)
    n = result.machine.testbench.circuit.port("line").shape[0]
    return np.flatnonzero([result[f"line[{k}]"][-1] > half for k in range(n)])


def decision_time(result: Result, release: float = RELEASE) -> float | None:
    """From `release` (s) to when the winner's line is the only one that is high, s.

    None without a winner, and where its line is the only high one from the beginning.
    """
    half = half_supply(result.machine)
    n = result.machine.testbench.circuit.port("line").shape[0]
    high = np.array([result[f"line[{k}]"] for k in range(n)])
    winners = lines_high(result)
    if winners.size != 1:
        return None
    alone = (high[winners[0]] > half) & (np.delete(high, winners[0], axis=0) <= half).all(axis=0)
    before = np.flatnonzero(~alone)
    if not before.size:
        return None  # high from the beginning: no decision of this run
    p = int(before[-1])
    own = high[winners[0], p : p + 2]
    if own[0] > half:
        return float(result.time[p + 1]) - release
    part = (half - own[0]) / (own[1] - own[0])
    return float(result.time[p] + part * (result.time[p + 1] - result.time[p])) - release


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `winner`, `decision_s` and `margin_V`.

    decision: as of `decision_time`. margin: by how much the winner's v_in is above the next at the end. None
    without a winner.
    """
    winners = lines_high(result)
    n = result.machine.testbench.circuit.port("line").shape[0]
    inputs = np.sort([result[f"v_in[{k}]"][-1] for k in range(n)])
    decided = winners.size == 1
    return {
        "winner": float(winners[0]) if decided else None,
        "decision_s": decision_time(result),
        "margin_V": float(inputs[-1] - inputs[-2]) if decided else None,
    }


def outcome(result: Result) -> str:
    """The number of the winner, `tie` with several lines high, or `undecided` with none."""
    winners = lines_high(result)
    return str(winners[0]) if winners.size == 1 else "tie" if winners.size else "undecided"


BLOCK = catalogued("winner-take-all", build, STIMULI, testbench, measures, outcome, PLOTTED)
