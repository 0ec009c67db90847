"""The selection under a law with second-order effects: the numbers of its devices on a die.

Under the full law a cell has an output conductance, v_p bends with the gate and the mobility falls, so that
no closed form holds. The decision is then integrated (`chips.selection.whole_kernel`), from here: each device
by the whole law with what it carries on the die, and the capacitances of the circuit. Taken from the circuit
alone; nothing is measured or fitted. Left out: the coupling of the excitations' gates and of the comparators,
and the time of the inverters.
"""

from __future__ import annotations

import numpy as np

from chips.selection.whole_kernel import DEVICE, MIRROR, MIRRORS, ROWS, SPECIFIC, THRESHOLD, Whole
from circuits.arrays import F64
from circuits.blocks.selection.winner_take_all import EDGE, Params
from circuits.circuit import Circuit
from circuits.devices.channel import Terms, height_of, leaked, terms_of
from circuits.devices.ekv import argument
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.capacitors_on_die import added_capacitance
from circuits.lowering.on_die import DieDevices, on_die
from circuits.silicon.silicon import Silicon
from circuits.vectors.vector import WIDTH, rows

OWN = ("mx", "my", "mk", "m1", "m2", "mo", "mb", "ms", "mr")
"""Devices of a cell in the order of `Whole.own`; behind them are the mirrors and the lone ones."""
_LONE = ("mt", "md", "me")
_TYPICAL = 50e-9  # A, of an excitation from whose rest others are looked for; ours
_NO_ROW = np.zeros(0)
_NO_TABLE = np.zeros((0, 0))


def no_whole() -> Whole:
    """Return what a selection under the ideal law has in this place."""
    tables = ("shared", "side", "inverse_capacitance", "work")
    return Whole(
        v_dd=0.0, u_t=0.0, v_tail=0.0, quiet=0.0, flat=_NO_ROW, span=0, mirrors=0, threshold_of_line=_NO_ROW,
        leak=(0.0, 0.0), share_capacitance=0.0, taken_capacitance=0.0, near=(0.0, 0.0, 0.0), begin=0.0,
        own=np.zeros((0, 0, 0)), **dict.fromkeys(tables, _NO_TABLE),
    )  # fmt: skip


def whole_of(circuit: Circuit, params: Params, silicon: Silicon, v_tail: float) -> Whole:
    """Return the numbers of a selection's circuit on a silicon, whose tail's line is at `v_tail` V."""
    d = on_die(circuit, silicon)
    cells = int(params.cells)
    shared = [*(_shared(d, f"cell.{name}") for name in (*OWN, "mk")), *map(d.terms, _LONE)]
    quiet = silicon.process.v_dd - _drop(d, v_tail, cells)
    near = _near(d, v_tail)
    inner, share, taken = _capacitances(circuit, silicon, cells)
    side = _side_by_side(d, cells, params.reach)
    return Whole(
        v_dd=d.v_dd,
        u_t=d.u_t,
        v_tail=v_tail,
        quiet=quiet,
        shared=np.array(shared),
        own=np.array([_own(d, f"cell.{name}") for name in OWN]),
        side=side,
        flat=side.reshape(-1),
        span=WIDTH * _rows_of(cells),
        mirrors=2 * params.reach + 1,
        threshold_of_line=d.inverter_threshold("cell.mi"),
        leak=_leaks(d, params.reach, near[0]),
        inverse_capacitance=inner,
        share_capacitance=share,
        taken_capacitance=taken,
        near=near,
        begin=EDGE * (1.0 - (near[0] + silicon.law("n").v_t0) / d.v_dd),
        work=np.zeros((ROWS, 2 * cells + 3)),
    )


def _rows_of(cells: int) -> int:
    """How many rows of lanes hold a number of each cell."""
    return -(-cells // WIDTH)


def _side_by_side(d: DieDevices, cells: int, reach: int) -> F64:
    """What mk, m1, m2 and the mirrors carry on the die, in their groups of `Whole.side`.

    A mirror that would come from beyond the last cell carries nothing.
    """
    count = 2 * reach + 1
    found = rows((MIRRORS + MIRROR * count) * _rows_of(cells))
    group = found.reshape(MIRRORS + MIRROR * count, -1)
    for k, name in enumerate(("mk", "m1", "m2")):
        fet = d.fet[f"cell.{name}"]
        group[k * DEVICE + SPECIFIC, :cells] = fet.current
        group[k * DEVICE + THRESHOLD, :cells] = fet.threshold
    for m in range(count):
        inside = range(max(0, reach - m), min(cells, cells + reach - m))
        names = [f"mg{k}_{m}" for k in inside]
        group[MIRRORS + m * MIRROR, inside.start : inside.stop] = [d.fet[n].current.item() for n in names]
        group[MIRRORS + m * MIRROR + 1, inside.start : inside.stop] = [d.fet[n].v_t0.item() for n in names]
    return found


def input_change(circuit: Circuit, silicon: Silicon) -> F64:
    """Return what each cell's capacitor has on the die beyond what is drawn, F, float64[N]."""
    return np.asarray(added_capacitance(circuit, silicon, ("cell.c_in",))["cell.c_in"])


def _shared(d: DieDevices, name: str) -> Terms:
    """Numbers of a device of all cells without mismatch."""
    fet = d.fet[name]
    width, length = float(fet.width.flat[0]), float(fet.length.flat[0])
    return terms_of(fet.law, width, length, fet.law.square_current * width / length, fet.law.v_t0)


def _own(d: DieDevices, name: str) -> F64:
    """Numbers of a device of every cell, float64[N, terms]."""
    shared, fet = _shared(d, name), d.fet[name]
    each = zip(fet.current, fet.threshold, strict=True)
    return np.array([shared._replace(specific=i, threshold=v) for i, v in each])


def _drop(d: DieDevices, v_tail: float, cells: int) -> float:
    """Drop (V) of a `share` below the supply where the tail is shared evenly."""
    part = d.saturated("mt", v_tail) / cells + d.saturated("cell.mb", v_tail)
    return float(np.mean(d.fet["cell.mo"].gate_for(part, diode=True)))


def _near(d: DieDevices, v_tail: float) -> tuple[float, float, float]:
    """Joined v_in, v_common and the middle of the joint, V, about where they rest."""
    m1, m2 = d.fet["cell.m1"], d.fet["cell.m2"]
    common = float(np.mean(m1.gate_for(_TYPICAL, diode=True)))
    part = float(d.saturated("mt", v_tail)) / m2.current
    v_p = common + d.u_t * argument(part / m2.current.size)
    joined = float(np.mean(m2.threshold + height_of(m2.law, v_p)))
    return joined, common, 0.5 * joined


def _leaks(d: DieDevices, reach: int, joined: float) -> tuple[float, float]:
    """What junctions take from a v_in and from a risk, A, at about the voltages of their rest."""
    mirrors = [f"mg0_{m}" for m in range(2 * reach + 1)]
    taken = [leaked(_shared(d, name), joined, 0.0)[0] for name in (*mirrors, "cell.m1", "cell.me")]
    given = leaked(_shared(d, "cell.my"), d.v_dd - joined, 0.0)[0]
    gate = d.fet["cell.mk"].law.v_t0
    return float(sum(taken) - given), float(leaked(_shared(d, "cell.mk"), gate, gate)[0])


def _capacitances(circuit: Circuit, silicon: Silicon, cells: int) -> tuple[F64, float, float]:
    """Inverse capacitance matrix of v_in, the risks and v_common, 1/F, and C of `share` and `taken`, F."""
    nodes = [f"{name}[{k}]" for name in ("v_in", "risk") for k in range(cells)]
    matrix = capacitance_matrix(circuit, silicon.process, [*nodes, "v_common"])
    at = np.arange(cells)
    matrix[at, at] += input_change(circuit, silicon)
    middle = cells // 2
    share, taken = (
        float(capacitance_matrix(circuit, silicon.process, [node])[0, 0])
        for node in (f"share[{middle}]", f"cell[{middle}].taken")
    )
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64), share, taken
