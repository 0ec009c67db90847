"""By how much deviations of a bias generator's devices move its lines: one transposed solve a network.

    dV / dV_T0k = -+ dV / dV_gk,     dV / dbeta_k = (dV / dI_k) I_k / (1 + beta_k)

with the slopes of the lines' operating point, the sign being that of an nFET. What lines share moves them by
the diode of their coarse current, and by the node at which switches that are off have their gates.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import F64
from circuits.generator.solve import AtRest, Network, Slopes, slopes_at
from circuits.generator.voltage import (
    OFF,
    RANGES,
    SHARED_PATH,
    Line,
    coded,
    line_network,
    lines_at_rest,
    masters_at_rest,
    masters_network,
    resistor_of,
    where_of,
)
from circuits.silicon.die import Path, Place
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon


@dataclass(frozen=True, slots=True, eq=False)
class Family:
    """Transistors whose deviations are drawn together.

    place, paths : where they stand, as `circuits.silicon.die.standard_normals` has them.
    area : `m W L` of each, m^2, float64[draws].
    """

    place: Place
    paths: tuple[Path, ...]
    area: F64


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """What a family's deviations move lines by.

    family : the transistors.
    by_v_t0 : by the magnitude of each threshold, V/V, float64[lines, draws].
    by_beta : by each relative current factor, V, float64[lines, draws].
    """

    family: Family
    by_v_t0: F64
    by_beta: F64


def line_families(lines: Line, current: F64, process: Process) -> tuple[Family, Family]:
    """Devices of lines alone, and those that they share; arguments as of `line_moves`."""
    own = line_network(lines, coded(current), process)
    place, path = where_of(lines)
    masters = masters_network(1.0, process)  # whatever its resistor is, which does not deviate
    return _family(own, place, path), _family(masters, lines.place, SHARED_PATH)


def line_moves(lines: Line, current: F64, silicon: Silicon) -> tuple[Moves, Moves]:
    """What the lines' own devices move them by, and what those do that they share.

    lines, current, silicon, and what it raises: as of `circuits.generator.voltage.line_voltages`.
    """
    codes, there, resistance = (
        coded(current),
        replace(silicon, place=lines.place),
        resistor_of(silicon.process),
    )
    rest = lines_at_rest(lines, codes, there, resistance)
    slopes, at = slopes_at(rest, there, lines.node), np.arange(len(codes))
    own = [np.zeros((at.size, each.shape[1], at.size)) for each in _by(rest, slopes)]
    for whole, each in zip(own, _by(rest, slopes), strict=True):
        whole[at, :, at] = each
    masters = masters_at_rest(there, resistance)
    nodes = {name: _by(masters, slopes_at(masters, there, name)) for name in (*RANGES, OFF)}
    shared = [
        slopes.by_given["range_n"][:, None] * np.concatenate([nodes[RANGES[c]][k] for c, _ in codes])
        + slopes.by_given[OFF][:, None] * nodes[OFF][k]
        for k in (0, 1)
    ]
    first, second = line_families(lines, current, silicon.process)
    by_v_t0, by_beta = (each.reshape(at.size, -1) for each in own)
    return Moves(first, by_v_t0, by_beta), Moves(second, shared[0], shared[1])


def _family(network: Network, place: Place, path: Path) -> Family:
    paths = tuple((*path, (device.name, ())) for device in network.transistors())
    return Family(place, paths, network.of_transistors("gate_area").ravel())


def _by(rest: AtRest, slopes: Slopes) -> tuple[F64, F64]:
    """By thresholds and current factors of each copy's own transistors, float64[copies, transistors]."""
    sign = np.array([1.0 if d.polarity == "n" else -1.0 for d in rest.network.transistors()])
    beta = np.broadcast_to(rest.deviation.beta, slopes.by_factor.size).reshape(-1, len(slopes.by_factor)).T
    return -sign * slopes.by_gate, slopes.by_factor / (1.0 + beta)
