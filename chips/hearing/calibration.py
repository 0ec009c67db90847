"""Calibration of the hearing: the level by which the onset neuron hears a sound that comes after silence.

A refractory of the onset neuron ends only where its comparator lets it, and on one die of fifty mismatch
keeps it from that: the neuron is deaf until a loud sound comes. On the bench a soft sound is played after
half a second of silence, again and again, while the trimmer of `v_level` is lowered, until the neuron no
longer hears it. It is set above that by as much as the nominal neuron has, which brings thresholds of dies
together as well.
"""

from __future__ import annotations

from dataclasses import replace

from chips.codes import Calibration, Codes, Measured, codes_begun
from chips.hearing.mismatch import LEVEL
from chips.hearing.model import check_hearing, rest_margin_on
from chips.measured.search import narrowed
from circuits.circuit import BiasKind
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

NAME = "hearing"  # of the calibration
RESERVE = 27e-3  # V, of the level above where the neuron is deaf; the nominal one's at 27 degC
LEVELS = 2.4, 2.75  # V, between which the trimmer goes; ours
WITHIN = 1e-3  # V
TRIAL = 0.6  # s, of silence and a sound; ours


def calibrate(silicon: Silicon, kind: BiasKind, setup: None = None) -> Codes:
    """Calibrate the hearing on a silicon, at its temperature.

    Raises `ParameterError` outside the box of its model (`chips.validity`).

    Parameters
    ----------
    silicon
        Process, temperature of the bench, and die.
    kind
        Kind of the biases of the chip beside it; those of the hearing are voltages.
    setup
        Nothing: the hearing is always the same.
    """
    check_hearing(silicon)
    codes, trials = codes_begun(NAME, silicon, kind), 0

    def hears(level: float) -> bool:
        nonlocal trials
        trials += 1
        return rest_margin_on(silicon, level) >= 0.0

    if not hears(LEVELS[1]):
        return replace(codes, bench_s=TRIAL, failed="its onset neuron hears at no level")
    _, edge = narrowed(hears, *LEVELS, WITHIN)
    before = Measured("rest_margin", "V", RESERVE, LEVEL - edge, RESERVE)
    bench = TRIAL * trials
    return replace(codes, trims={"v_level": (edge + RESERVE,)}, measured=(before,), bench_s=bench)


def level_of(codes: Codes | None) -> float:
    """Return the level of the onset neuron, V; the board's own without codes."""
    return LEVEL if codes is None else codes.trims["v_level"][0]


CALIBRATION = Calibration(
    NAME, "level by which the hearing's onset neuron hears after silence", AMI_1500, calibrate
)
