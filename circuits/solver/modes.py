"""Natural modes of a circuit about a rest state, which are the solutions of `C dv/dt = -G v`.

Combinations of voltages that carry no charge follow the others at once. They are eliminated first: as
infinite eigenvalues they would come back as large numbers of either sign.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from circuits.arrays import C128, F64
from circuits.catalogue import later

if TYPE_CHECKING:
    from scipy.sparse import csc_array

linalg = later("scipy.linalg")
csgraph = later("scipy.sparse.csgraph")

_CHARGELESS = 1e-9  # share of a node's own capacitance below which a combination of nodes carries no charge
ROUNDING = 1e-11  # share of the fastest rate below which the sign of another is rounding


def without_charges(charges: int, conductance: F64, charge: F64) -> tuple[F64, F64]:
    """Eliminate the unknowns that are charges of diodes: what is left has their capacitances in C.

    charges: how many they are, the first ones. conductance: float64[..., n, n], S; charge: float64[n, n], F.
    Returns G, float64[..., m, m], and C, float64[..., m, m], with m = n - charges.
    """
    if charges == 0:
        return conductance, charge
    capacitance = -conductance[..., :charges, charges:]
    inner = charge[charges:, charges:] + charge[charges:, :charges] @ capacitance
    return conductance[..., charges:, charges:], np.asarray(inner)


class Charged(NamedTuple):
    """A circuit in coordinates z that all carry charge: `dz/dt = matrix z`, with `z = into v`.

    `v = out z`, but for what follows without charge. matrix: float64[m, m], 1/s. into: float64[m, n]. out:
    float64[n, m].
    """

    matrix: F64
    into: F64
    out: F64


def charged(conductance: F64, charge: F64) -> Charged:
    """Reduce `charge dv/dt = -conductance v` to what carries charge.

    conductance: float64[n, n], S; charge: float64[n, n], F, symmetric and positive semidefinite.
    """
    scale, share, modes = _own_modes(charge)
    loaded = share > _CHARGELESS
    turned = modes.T @ (scale[:, None] * conductance * scale) @ modes
    inner = turned[np.ix_(loaded, loaded)]
    if loaded.any() and not loaded.all():
        free = turned[np.ix_(~loaded, ~loaded)]
        inner = (
            inner - turned[np.ix_(loaded, ~loaded)] @ linalg.lstsq(free, turned[np.ix_(~loaded, loaded)])[0]
        )
    weight = 1.0 / np.sqrt(share[loaded])
    basis = modes[:, loaded]
    return Charged(
        -weight[:, None] * inner * weight,
        np.asarray((basis / scale[:, None] / weight).T),
        np.asarray(scale[:, None] * basis * weight),
    )


def parts_without_charge(charge: csc_array) -> F64:
    """Parts of a circuit that no capacitance joins to a known voltage: float64[n, parts], 1 at their nodes.

    The nodes of one may all move by as much while every charge stays. charge: sparse[n, n], F.
    """
    count, part = csgraph.connected_components(charge, directed=False)
    outside, own = (np.bincount(part, each, count) for each in (charge.sum(axis=1), charge.diagonal()))
    return np.asarray(part[:, None] == np.flatnonzero(outside <= _CHARGELESS * own), dtype=np.float64)


def natural_rates(conductance: F64, charge: F64) -> C128:
    """Eigenvalues of `charge dv/dt = -conductance v`, 1/s, those of the nodes' charges only.

    conductance: float64[n, n], S; charge: float64[n, n], F, symmetric and positive semidefinite.
    """
    matrix = charged(conductance, charge).matrix
    if not matrix.size:
        return np.zeros(0, dtype=np.complex128)
    return np.asarray(linalg.eigvals(matrix), complex)


def all_natural_rates(conductances: F64, charge: F64) -> C128:
    """`natural_rates` of several points of one circuit, complex128[N, modes], 1/s.

    conductances: float64[N, n, n], S; charge: float64[n, n], F, symmetric and positive semidefinite, or one
    for each point.
    """
    if charge.ndim > conductances.ndim - 1:
        return np.array([natural_rates(*each) for each in zip(conductances, charge, strict=True)])
    scale, share, modes = _own_modes(charge)
    if not (share > _CHARGELESS).all():
        return np.array([natural_rates(each, charge) for each in conductances])
    turned = modes.T @ (scale[:, None] * conductances * scale) @ modes
    weight = 1.0 / np.sqrt(share)
    return np.asarray(np.linalg.eigvals(-weight[:, None] * turned * weight), complex)


def _own_modes(charge: F64) -> tuple[F64, F64, F64]:
    """Scale of each node, and the eigenvalues and eigenvectors of the charge matrix so scaled."""
    diagonal = charge.diagonal()
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, diagonal.max(initial=0.0) or 1.0))
    share, modes = linalg.eigh(scale[:, None] * charge * scale)
    return np.asarray(scale), share, modes


def unstable_part(conductance: F64, charge: F64) -> F64:
    """Projector onto the modes that grow, float64[n, n]: column k is the growing part of 1 V at node k.

    It is the same whatever basis the modes are given in. conductance: float64[n, n], S; charge: float64[n,
    n], F, symmetric and positive semidefinite.
    """
    reduced = charged(conductance, charge)
    rates, vectors = linalg.eig(reduced.matrix)
    grows = rates.real > ROUNDING * np.abs(rates).max(initial=0.0)
    projector = vectors[:, grows] @ linalg.inv(vectors)[grows]
    return np.asarray(reduced.out @ projector.real @ reduced.into)
