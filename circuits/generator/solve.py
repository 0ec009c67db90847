"""Rest states of many copies of a small network of transistors and resistors at once.

Kirchhoff's current law at the unknown nodes is solved by Newton's method with the exact derivatives of the
law that the solver of circuits has (`circuits.devices.transistor`), second-order effects and all. The copies
have the same devices and nodes; they differ in what stands at their switches, in their deviations and in the
voltages that are given. Bulks stand at given nodes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, I64
from circuits.devices import Device, Resistor, Transistor
from circuits.devices.transistor import (
    TransistorArrays,
    TransistorWork,
    drain_currents,
    merge_arrays,
    transistor_arrays,
    transistor_work,
)
from circuits.errors import SolverError
from circuits.silicon.process import POLARITIES
from circuits.silicon.silicon import Deviation, Silicon

_TOLERANCE = 1e-9  # V, last update of a solve
_LARGEST = 0.2  # V, of a node in one iteration
_ITERATIONS = 600


@dataclass(frozen=True, slots=True)
class Network:
    """Copies of a network.

    copies : the devices of each, alike but for the nodes at their gates.
    given : names of the nodes whose voltages are given, ground `0` among them.
    """

    copies: Sequence[Sequence[Device]]
    given: Sequence[str]

    def transistors(self) -> list[Transistor]:
        """The transistors of the first copy."""
        return [d for d in self.copies[0] if isinstance(d, Transistor)]

    def unknown(self) -> list[str]:
        """The nodes that are solved for."""
        nodes = dict.fromkeys(node for device in self.copies[0] for node in device.terminals())
        return [node for node in nodes if node not in self.given]


def rest_state(
    network: Network,
    silicon: Silicon,
    deviation: Deviation,
    given: Mapping[str, F64],
    start: Mapping[str, F64],
) -> dict[str, F64]:  # fmt: skip
    """Voltages of the unknown nodes of all copies, V, float64[copies] each.

    Raises `SolverError` where none are found.

    Parameters
    ----------
    network
        The copies.
    silicon
        Process, temperature and what a die shares.
    deviation
        Of all transistors: those of the first one in all copies, then those of the next.
    given
        Voltages of the given nodes but ground, V, float64[copies].
    start
        A guess of every unknown node, V, float64[copies].
    """
    unknown, copies = network.unknown(), len(network.copies)
    column = {name: k for k, name in enumerate([*unknown, *network.given])}
    terminals = np.array(
        [[[column[n] for n in d.terminals()] for d in copy if isinstance(d, Transistor)]
         for copy in network.copies]
    )  # fmt: skip
    n, every = len(unknown), len(column)
    v = np.zeros((copies, every))
    for name, value in (*start.items(), *given.items()):
        v[:, column[name]] = value
    arrays = _arrays(network, silicon, deviation, terminals + every * np.arange(copies)[:, None, None])
    flow = _Flow(terminals, n, _conductance(network, column))
    work = transistor_work(arrays.sign.size)
    for _ in range(_ITERATIONS):
        drain_currents(arrays, v.ravel(), work)
        residual, jacobian = flow.currents(v, work)
        scale = np.maximum(np.abs(jacobian).max(axis=2), 1e-300)
        try:
            step = np.linalg.solve(jacobian / scale[:, :, None], (residual / scale)[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            break
        if not np.isfinite(step).all():
            break
        v[:, :n] -= np.clip(step, -_LARGEST, _LARGEST)
        if np.abs(step).max() < _TOLERANCE:
            return {name: v[:, k].copy() for k, name in enumerate(unknown)}
    raise no_room(silicon)


def no_room(silicon: Silicon) -> SolverError:
    """The error of a generator whose supply is too low for it."""
    return SolverError(
        f"bias generator: no operating point at {silicon.process.v_dd:g} V and"
        f" {silicon.temperature_c:g} degC; give a higher supply"
    )


def _arrays(network: Network, silicon: Silicon, deviation: Deviation, terminals: I64) -> TransistorArrays:
    """Coefficients of the transistors: each copy's first one, then each copy's next one."""
    copies, devices = len(network.copies), network.transistors()
    is_n = np.repeat([d.polarity == "n" for d in devices], copies)
    width, length, multiplicity = (
        np.repeat([getattr(d, name) for d in devices], copies) for name in ("width", "length", "multiplicity")
    )
    at = terminals.transpose(2, 1, 0).reshape(4, -1).astype(np.int32)
    each = {
        p: transistor_arrays(at, p, silicon.law(p), width, length, multiplicity, *deviation)
        for p in POLARITIES
    }
    return merge_arrays(is_n, each["n"], each["p"])


def _conductance(network: Network, column: Mapping[str, int]) -> F64:
    """Conductances between the nodes of a copy, S, float64[nodes, nodes]."""
    matrix = np.zeros((len(column), len(column)))
    for device in network.copies[0]:
        if isinstance(device, Resistor):
            i, j = (column[node] for node in device.terminals())
            matrix[[i, j], [i, j]] += 1.0 / device.resistance
            matrix[[i, j], [j, i]] -= 1.0 / device.resistance
    return matrix


class _Flow:
    """Where the currents of the transistors and their slopes go, once for all iterations."""

    def __init__(self, terminals: I64, unknown: int, conductance: F64) -> None:
        self.unknown, self.conductance = unknown, conductance
        self.copies, self.nodes = len(terminals), len(conductance)
        drain, gate, source, _ = terminals.transpose(2, 1, 0)  # [devices, copies] each
        self.row = [self._at(drain), self._at(source)]
        self.entry = {
            (i, j): (self._at(a) * self.nodes + b).ravel()
            for i, a in (("d", drain), ("s", source))
            for j, b in (("d", drain), ("g", gate), ("s", source))
        }

    def _at(self, node: I64) -> I64:
        return np.asarray(np.arange(self.copies) * self.nodes + node)

    def currents(self, v: F64, w: TransistorWork) -> tuple[F64, F64]:
        """Currents that leave the unknown nodes, A, [copies, unknown], and their derivatives, S."""
        n, size = self.unknown, self.copies * self.nodes
        residual = v @ self.conductance
        slopes: list[tuple[str, str, F64]] = []
        for row, end, sign in ((self.row[0], "d", 1.0), (self.row[1], "s", -1.0)):
            side = "ds".index(end)
            leaving = sign * w.current + w.junction[side]
            slopes += [(end, to, sign * w.conductance[k]) for k, to in enumerate("dgs")]
            slopes.append((end, end, w.junction_conductance[side]))
            slopes.append((end, "g", w.junction_conductance[2 + side]))
            residual += np.bincount(row.ravel(), leaving, size).reshape(self.copies, self.nodes)
        jacobian = np.zeros(size * self.nodes)
        for end, to, slope in slopes:
            jacobian += np.bincount(self.entry[end, to], slope, jacobian.size)
        square = jacobian.reshape(self.copies, self.nodes, self.nodes) + self.conductance
        return residual[:, :n], square[:, :n, :n]
