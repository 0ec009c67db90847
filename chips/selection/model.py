"""Behavioural model of a winner-take-all selection: which direction it chooses on a die, and how fast.

Every mirror multiplies by a gain of its own pair of devices, at the inversion of its own current:

    ln g = d ln beta - x h + x^2 h' / 2,    x = kappa dV_T / U_T,
    h = d ln I / d(v_p / U_T) = (1 - e^{-s}) / s,    h' = (h e^{-s} - h^2) / 2,    s = sqrt(I / I_S)

(the EKV law to second order in the pair's threshold), so that of the currents at the ports

    I_k = g_k I_excite,k - sum_d w_d g_k,d I_risk,k+d,    merit_k = I_k / a_k

where a_k is the strength of the cell's `m1`. The greatest merit wins. From the release on v_in of cell k
falls behind the winner's by

    d_k = a_k (merit_w - merit_k) t / C + (1 - a_k / a_w) V_w

whose second term is what unequal `m1` took while v_common was below its end, when the winner's v_in rose
by V_w. The line's comparator turns when the winner's `m2` has x of the tail, which is solved with the EKV law
and the die's offsets of all `m2`. What is above x then charges the comparator's output. All deviations are
those that the transistor level draws; left out: the coupling of v_in through the projection's overlaps, and
the inverters.

Where no cell has a current above 0 nobody wins; a decision that takes longer than the caller waits is
undecided; below a margin of the two greatest merits (`MARGIN`) the model does not say who wins.

Against the transistors on dies A/1000 to A/1059 with mismatch and process variation, five random profiles
each (`chips.selection.measure`, a deadline of 1 ms, gate biases):

| degC | same answer | other winner | one level undecided | error of time, rms | largest |
|---|---|---|---|---|---|
| -20 | 298 of 300 | 0 | 2 | 11.3 % | 123 % |
| 0 | 297 of 300 | 0 | 3 | 9.2 % | 103 % |
| 27 | 298 of 300 | 0 | 2 | 6.5 % | 63 % |
| 60 | 300 of 300 | 0 | 0 | 5.6 % | 42 % |
| 85 | 299 of 300 | 0 | 1 | 5.1 % | 31 % |

Both levels were undecided on 3 to 6 of the 300. With all currents 0.4, 2 and 4 times as large (27 degC, 150
pairs each) no winner differs either, and the time is 7.0, 5.4 and 6.0 % rms off. The error of the time is the
coupling's: without overlaps of the nFETs it is 1.6 % rms (mismatch alone, 32 pairs on dies 0 to 7, 27 degC);
it grows near ties, where the time is long. Valid for excitations of 20 to 300 nA and risks from 0.1 nA to 0.4
of the least excitation, from -20 to 85 degC: nothing was measured outside. With devices a quarter as large
(90 pairs on dies A/1000 to A/1009 at -20, 27 and 85 degC) all answers are the same and the time is 5.7 % rms
off; a 16th as large, another cell wins once in 90, by a margin of 8e-4.

All that is the ideal law. Under a law with second-order effects the decision is integrated, with each device
by its whole law (`chips.selection.whole`), which takes some 1 ms in the place of 30 us. The coupling
through the projection is in it: of 240 pairs (dies A/1000 to A/1019 at -20, 27 and 85 degC) all have the same
answer, and the time is 1.3 % rms off and 2.4 % at most.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chips.measured.table_record import tables_of
from chips.selection.kernel import Selection, decide, inversion
from chips.selection.whole import input_change, no_whole, whole_of
from chips.selection.whole_kernel import NOBODY
from chips.validity import require_area, require_inside
from circuits.arrays import F64
from circuits.bias import bias_voltages
from circuits.blocks.selection import winner_take_all as circuit_of
from circuits.blocks.selection.winner_take_all import CELLS, Params
from circuits.circuit import Circuit
from circuits.devices import Capacitor, Transistor
from circuits.devices.device import Device
from circuits.devices.transistor import capacitances
from circuits.errors import ParameterError
from circuits.lowering.on_die import DieDevices, on_die, transistor_of
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process, TransistorAtTemperature
from circuits.silicon.silicon import Silicon

MARGIN = (
    1e-4  # ln of the merits' ratio; above its largest error, 6e-5 near ties on 300 pairs of dies below 100
)
MEASURED = -20.0, 85.0  # degC
LEAST_AREA = 0.25  # of the devices; ours: half of it has not been measured, at a 16th other cells win


@dataclass(frozen=True, slots=True)
class Decision:
    """A decision: the winner, a cell or -1 for nobody; its time from the release, s, or inf; its margin.

    The margin is the logarithm of the ratio of the two greatest merits.
    """

    winner: int
    time: float
    margin: float

    @property
    def certain(self) -> bool:
        """Whether the two greatest merits are further apart than the model's own error."""
        return self.winner != NOBODY and self.margin > MARGIN


def circuits() -> tuple[Circuit, ...]:
    """Return the circuit that the record of the model's errors is of."""
    return (circuit_of.build(Params(CELLS)),)


def selection_errors(process: Process = AMI_1500_IDEAL) -> Mapping[str, float]:
    """Return the model's errors from the record of a process.

    Raises `DataError` where that is of another circuit.
    """
    return tables_of("winner_take_all", circuits, process).errors


def selection(
    silicon: Silicon, params: Params | None = None, circuit: Circuit | None = None, *, area: float = 1.0
) -> Selection:
    """Return the selection's gains on the silicon's die, for `CELLS` cells or as `params` says.

    circuit: with biases of its own, else as built; area: of the drawn devices over the circuit's. Raises
    `ParameterError` for an area that is not above 0 and where the model was not measured, and `DataError`
    where the record of its errors is stale.
    """
    require_area("selection", area, LEAST_AREA)
    require_inside("selection.temperature", silicon.temperature_c, MEASURED, "degC")
    require_inside("selection.supply", silicon.process.v_dd, (AMI_1500_IDEAL.v_dd,), "V")
    params = params or Params(CELLS)
    circuit = circuit or circuit_of.build(params)
    law = {"n": silicon.law("n"), "p": silicon.law("p")}
    d = on_die(circuit, silicon.of_area(area), _wanted(params))
    # the model has no tables, but its errors may be of another circuit or law
    selection_errors(AMI_1500 if d.full else AMI_1500_IDEAL)
    drawn = _draws(d, params)
    kappa = {polarity: law[polarity].kappa / law[polarity].u_t for polarity in ("n", "p")}
    v_tail = float(bias_voltages(circuit, circuit.bias("i_tail"), silicon)[()])

    def pair(first: str, second: str, polarity: str) -> tuple[F64, F64]:
        return drawn[second][1] - drawn[first][1], (drawn[second][0] - drawn[first][0]) * kappa[polarity]

    excite, out = pair("mx", "my", "p"), pair("mo", "ms", "p")
    tail, reference, bleed = (d.saturated(name, v_tail) for name in ("mt", "cell.mr", "cell.mb"))
    level = float(reference.mean()) / _specific(circuit, "mo", law["p"])
    h, bend = inversion(level)
    out_gain = np.exp(out[0] - out[1] * (h - 0.5 * out[1] * bend))
    risk_beta, risk_threshold = _risk(drawn, params, kappa["n"])
    reach = range(-params.reach, params.reach + 1)
    threshold = _threshold(circuit, law, silicon.process.v_dd)
    return Selection(
        weight=np.array([circuit_of.weight(params, d) for d in reach]),
        excite_beta=excite[0],
        excite_threshold=excite[1],
        risk_beta=risk_beta,
        risk_threshold=risk_threshold,
        cell_beta=drawn["m1"][1],
        cell_threshold=drawn["m1"][0] * kappa["n"],
        share_beta=drawn["m2"][1],
        share_threshold=drawn["m2"][0] * kappa["n"],
        turn=reference / out_gain - bleed,
        out_gain=out_gain,
        tail=float(tail),
        excite_specific=_specific(circuit, "mx", law["p"]),
        risk_specific=_specific(circuit, "mk", law["n"]),
        cell_specific=_specific(circuit, "m1", law["n"]),
        share_specific=_specific(circuit, "m2", law["n"]),
        slope=kappa["n"],
        kappa=law["n"].kappa,
        input_capacitance=_capacitance(circuit, "v_in", silicon.process) + input_change(circuit, silicon),
        line_charge=_capacitance(circuit, "taken", silicon.process) * threshold,
        whole=whole_of(circuit, params, silicon.of_area(area), v_tail) if d.full else no_whole(),
    )


def decision(chip: Selection, excite: F64, risk: F64) -> Decision:
    """Decide once; excite, risk: currents at the circuit's ports, A, float64[N].

    Raises `ParameterError` for arrays of another size.
    """
    n = chip.excite_beta.size
    if excite.shape != (n,) or risk.shape != (n,):
        raise ParameterError(f"selection.currents: {excite.shape} and {risk.shape}, must be ({n},) both")
    scratch = np.empty((4, n))
    winner, time, margin = decide(chip, excite, risk, scratch)
    return Decision(int(winner), float(time), float(margin))


_OWN = ("mx", "my", "mk", "m1", "m2", "mo", "mb", "ms", "mr")


def _wanted(params: Params) -> tuple[str, ...]:
    """Transistors whose deviations count, mirrors of a cell one after the other."""
    mirrors = range(2 * params.reach + 1)
    projected = (f"mg{k}_{m}" for k in range(int(params.cells)) for m in mirrors)
    return ("mt", *projected, *(f"cell.{name}" for name in _OWN))


def _draws(d: DieDevices, params: Params) -> dict[str, tuple[F64, F64]]:
    """Deviations of V_T0 (V) and ln beta of a cell's devices by name, [N], and of `mg` [N, M]."""
    own = {name: d.fet[f"cell.{name}"] for name in _OWN}
    result = {name: (fet.v_t0, np.log1p(fet.beta)) for name, fet in own.items()}
    mirrors, shape = [fet for name, fet in d.fet.items() if name.startswith("mg")], (int(params.cells), -1)
    v_t0, beta = np.array([f.v_t0 for f in mirrors]), np.array([f.beta for f in mirrors])
    return result | {"mg": (v_t0.reshape(shape), np.log1p(beta).reshape(shape))}


def _risk(drawn: dict[str, tuple[F64, F64]], params: Params, kappa: float) -> tuple[F64, F64]:
    """Deviations of the mirrors mk, mg, float64[N, M]; 0 where there is no source."""
    n, reach = int(params.cells), params.reach
    source = np.arange(n)[:, None] + np.arange(-reach, reach + 1)
    inside = (source >= 0) & (source < n)
    source = np.clip(source, 0, n - 1)
    v_t0 = np.where(inside, drawn["mg"][0] - drawn["mk"][0][source], 0.0)
    beta = np.where(inside, drawn["mg"][1] - drawn["mk"][1][source], 0.0)
    return np.ascontiguousarray(beta), np.ascontiguousarray(v_t0 * kappa)


def _specific(circuit: Circuit, name: str, law: TransistorAtTemperature) -> float:
    """Specific current of a cell's device without mismatch, A."""
    return law.square_current * transistor_of(circuit, f"cell.{name}").square


def _capacitance(circuit: Circuit, node: str, process: Process) -> float:
    """Capacitance of a node of a cell, F, its projection included; what is across one device counts once."""
    part = next(i.circuit for i in circuit.instances)
    inner = [(d, node) for d in part.devices]
    middle = circuit.instances[0].shape[0] // 2
    projected = [(d, f"{node}[{middle}]") for d in circuit.devices] if node == "v_in" else []
    return sum(_between(d, n, process) for d, n in (*inner, *projected))


def _between(device: Device, node: str, process: Process) -> float:
    terminals = device.terminals()
    if isinstance(device, Capacitor):
        return device.capacitance if node in terminals else 0.0
    if not isinstance(device, Transistor):
        return 0.0
    one = np.ones(1)
    found = capacitances(
        process.model(device.polarity), device.width * one, device.length * one, device.multiplicity * one
    )
    return sum(float(c[0]) for (a, b), c in found.items() if (terminals[a] == node) != (terminals[b] == node))


def _threshold(circuit: Circuit, law: dict[str, TransistorAtTemperature], v_dd: float) -> float:
    """Input voltage at which the first inverter's devices carry the same, both in strong inversion, V."""
    n, p = (math.sqrt(_specific(circuit, f"mi{x}", law[x])) * law[x].kappa / law[x].u_t for x in ("n", "p"))
    return (n * law["n"].v_t0 + p * (v_dd - law["p"].v_t0)) / (n + p)
