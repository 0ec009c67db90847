"""The selection's chip of a bat: its circuit at a kind of bias or at codes, its noise, and its board."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chips.codes import Calibration, Codes
from chips.noise import SiliconNoise
from chips.selection.calibration import NAME, Design, biased, calibrate, circuit_at
from chips.selection.kernel import Selection
from chips.selection.model import selection
from chips.selection.noise import SelectionNoise, selection_noise
from circuits.arrays import F64
from circuits.blocks.selection.winner_take_all import Params
from circuits.circuit import BiasKind
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.openspace.law import ARCS, Bat

REACH = 1.5  # of the selection's projection, in its sigma: mirrors below a tenth of the widest are left out


@dataclass(frozen=True, slots=True)
class Selecting:
    """What the selection's chip is biased with.

    kind : of its bias; fixed gate voltages, as on the paper's chip, unless given.
    codes : of its calibration; None for those of the design.
    """

    kind: BiasKind = "gate"
    codes: Codes | None = None


FIXED = Selecting()


def projection(bat: Bat) -> Params:
    """The selection's circuit for a bat: sigma_m is the width of its projection."""
    sigma = bat.suppression_sigma
    return Params(cells=ARCS, sigma=sigma, reach=max(1, int(REACH * sigma)))


def chosen_by(
    bat: Bat, silicon: Silicon, area: float, selecting: Selecting, noise: SiliconNoise | None
) -> tuple[Selection, SelectionNoise, F64]:
    """Return a bat's selection, its noise, and what the board multiplies excitations by, float64[ARCS].

    area: of its devices over the circuit's. Raises `ParameterError` for silicon outside of its model.
    """
    params, codes = projection(bat), selecting.codes
    circuit = biased(params, selecting.kind) if codes is None else circuit_at(codes, params)
    chip = selection(silicon, params, circuit, area=area)
    board = np.ones(ARCS) if codes is None else np.array(codes.trims["excite"])
    return chip, selection_noise(chip, silicon, noise, area), board


CALIBRATION = Calibration(
    name=NAME,
    summary="tail of the selection, and what the board gives its cells so that equals tie",
    process=AMI_1500,
    calibrate=calibrate,
    setup=Design(projection(Bat())),
)
