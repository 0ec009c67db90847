"""Noise of the selection: by how much the currents that its cells compare are off in a decision.

From the release on each v_in integrates its cell's currents for the decision's time t, so that their means
are off, in squares, by

    (q / t) [phi_x I_x + phi_y I_x + sum_d phi_g w_d I_risk,d + phi_1 I_k] + k T C / t^2      white
    sum over the same devices of (psi kappa / U_T)^2 I^2 <V_G^2>(t)                           flicker

I_x the excitation, whose mirror makes noise on both sides (mx, my), mg the projection's mirrors, I_k what m1
takes away; phi and psi of `chips.shot_noise`; k T C is what `equalise` leaves on each v_in, <V_G^2>(t) the
variance of the mean of a gate's wander. A risk's diode mk is off by q phi I / t itself, in all cells that it
inhibits at once. A decision is made twice: without noise for its t (`LONGEST` where it has none), by the
closed form under any law, then with the currents that are drawn. Flicker is drawn anew for each decision.

Left out: the comparators (m2, mo, ms, mr and the tail make 1 to 3 % of the variance), and what a device's
mismatch does to its noise. Draws are keyed by (seed, trial, place, decision).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.measured.interpolation import table_at
from chips.noise import SiliconNoise
from chips.noise_draw import Draws, draw, new_draws
from chips.selection.kernel import Selection, decide, decide_plain
from chips.selection.whole_kernel import NOBODY
from chips.shot_noise import current_wander, share_at
from circuits.arrays import F64
from circuits.blocks.selection import winner_take_all as circuit_of
from circuits.compiled import compiled
from circuits.devices.ekv import steepness_of_root
from circuits.errors import ParameterError
from circuits.lowering.on_die import transistor_of
from circuits.silicon.process import BOLTZMANN, ELEMENTARY_CHARGE, Polarity, kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import noise_place

SHORTEST, LONGEST = 1e-6, 10e-3  # s, of a decision between which its noise is worked out; ours
_KNOTS = 9  # over ln t of what flicker makes; ours

_compiled = compiled()


class SelectionNoise(NamedTuple):
    """Noise of a selection of N cells, none if its arrays are empty.

    draws: of 2 N places, cells and then risks; thermal: k T C of a v_in, C^2; knots: ln(time / 1 s),
    float64[k]; excite, own, risk, projected: relative variances of currents by flicker there, float64[k], of
    mx and my together, of m1, of mk, and of an mg of weight 1; moved: working space, float64[2, N].
    """

    draws: Draws
    thermal: float
    knots: F64
    excite: F64
    own: F64
    risk: F64
    projected: F64
    moved: F64


def no_selection_noise() -> SelectionNoise:
    """Return the noise of a selection that has none."""
    none = np.zeros(0)
    return SelectionNoise(new_draws(0, 0, "", 0), 0.0, none, none, none, none, none, np.zeros((2, 0)))


def selection_noise(
    chip: Selection, silicon: Silicon, noise: SiliconNoise | None, area: float = 1.0
) -> SelectionNoise:
    """Return the noise of a selection on a silicon, or none where `noise` is None.

    area: of the drawn devices over the circuit's, for flicker. Raises `ParameterError` for an area that is
    not above 0.
    """
    if not (math.isfinite(area) and area > 0.0):
        raise ParameterError(f"selection.area: {area:g} times the circuit's, must be > 0")
    if noise is None:
        return no_selection_noise()
    circuit = circuit_of.build()
    knots = np.linspace(math.log(SHORTEST), math.log(LONGEST), _KNOTS)
    wander = {
        name: current_wander(
            silicon, noise, polarity, area * transistor_of(circuit, name).gate_area, np.exp(knots)
        )
        for name, polarity in _DEVICES.items()
    }
    cells = chip.excite_beta.size
    path = f"{noise_place(silicon, circuit.name)}, decision"
    return SelectionNoise(
        new_draws(noise.seed, noise.trial, path, 2 * cells),
        BOLTZMANN * kelvin(silicon.temperature_c) * float(chip.input_capacitance.mean()),
        knots,
        wander["cell.mx"] + wander["cell.my"],
        wander["cell.m1"],
        wander["cell.mk"],
        wander[_WIDEST],
        np.zeros((2, cells)),
    )


@_compiled
def noisy_decide(
    s: Selection, n: SelectionNoise, number: int, excite: F64, risk: F64, scratch: F64
) -> tuple[int, float, float]:
    """Return decision `number` as `chips.selection.kernel.decide` does, with noise if there is any."""
    if n.moved.shape[1] > 0:
        winner, time, _ = decide_plain(s, excite, risk, scratch)
        if winner != NOBODY:
            _move(s, n, number, excite, risk, scratch, min(max(time, SHORTEST), LONGEST))
            excite, risk = n.moved[0], n.moved[1]
    return decide(s, excite, risk, scratch)


@_compiled
def _move(
    s: Selection, n: SelectionNoise, number: int, excite: F64, risk: F64, scratch: F64, span: float
) -> None:
    """Draw the currents of decision `number`, of `span` s; scratch: of the decision without noise."""
    cells = n.moved.shape[1]
    draw(n.draws, number, 0)
    at = math.log(span)
    slow = table_at(n.knots, n.risk, at)
    for k in range(cells):
        variance = _variance(risk[k], s.risk_specific, 1.0, slow, span)
        n.moved[1, k] = max(risk[k] + math.sqrt(variance) * n.draws.normal[cells + k], 0.0)
    slow_excite, slow_own = table_at(n.knots, n.excite, at), table_at(n.knots, n.own, at)
    slow_mirror = table_at(n.knots, n.projected, at)
    reach = s.weight.size // 2
    for k in range(cells):
        variance = _variance(excite[k], s.excite_specific, 2.0, slow_excite, span)
        variance += _variance(max(scratch[0, k], 0.0), s.cell_specific, 1.0, slow_own, span)
        for m in range(max(0, reach - k), min(s.weight.size, cells + reach - k)):
            # of the same inversion as mk, and of a current and an area that go with its weight
            weight = s.weight[m]
            found = _variance(risk[k + m - reach], s.risk_specific, 1.0, slow_mirror, span)
            variance += weight * found
        variance += n.thermal / (span * span)
        n.moved[0, k] = max(excite[k] + math.sqrt(variance) * n.draws.normal[k], 0.0)


@_compiled
def _variance(current: float, specific: float, devices: float, wander: float, time: float) -> float:
    """Variance (A^2) of the mean over `time` (s) of a current (A), by as many devices that carry it."""
    root = math.sqrt(current / specific)
    white: float = devices * ELEMENTARY_CHARGE * share_at(root) * current / time
    slow: float = (steepness_of_root(root) * current) ** 2 * wander
    return white + slow


# the mirror of a cell's own risk, of weight 1
_WIDEST = circuit_of.projection_name(0, 0, circuit_of.Params().reach)
_DEVICES: dict[str, Polarity] = {"cell.mx": "p", "cell.my": "p", "cell.m1": "n", "cell.mk": "n", _WIDEST: "n"}
