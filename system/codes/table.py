"""The table of all calibrations by name: of chips, and of the networks that robots have on theirs.

Users add theirs under the entry point `noctule.calibrations`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from circuits.catalogue import Catalogue

if TYPE_CHECKING:
    from chips.codes import Calibration

CALIBRATIONS: dict[str, str] = {
    "nef-chip": "chips.nef.calibration:CALIBRATION",
    "latency-chip": "system.spiking_bat.chip_brain:CALIBRATION",
    "lso-chip": "system.head.scenario:CALIBRATION",
    "hearing": "chips.hearing.calibration:CALIBRATION",
    "ranging-chip": "chips.ranging.calibration.calibrate:CALIBRATION",
    "pushbot": "system.pushbot.network.codes:CALIBRATION",
    "pushbot-modified": "system.pushbot.network.codes:MODIFIED_CALIBRATION",
    "rolls": "system.rolls.codes:CALIBRATION",
    "selection-chip": "system.openspace.selecting:CALIBRATION",
    "wavefront-chip": "chips.wavefront.calibration:CALIBRATION",
}

# What each is, as its own summary says: `noctule list` and a shell's completion load none of them.
CALIBRATION_LINES: dict[str, str] = {
    "nef-chip": "rates of neurons, time constants and outputs of filters, the reference",
    "pushbot": "rates of the Pushbot's populations on ROLLS, plain network",
    "pushbot-modified": "rates of obstacle and drive populations of the modified network",
    "latency-chip": "times of taps, integrating neurons, cells and pulses of the latency chip",
    "lso-chip": "spikes a decibel of the sonar head's two neurons, and where left and right agree",
    "hearing": "level by which the hearing's onset neuron hears after silence",
    "ranging-chip": "windows of the ranging chip's neurons: their width, and where they stand",
    "rolls": "mean rate of a ROLLS die's neurons, and those that cannot be used",
    "selection-chip": "tail of the selection, and what the board gives its cells so that equals tie",
    "wavefront-chip": "unit of delay of the wavefront chip, and the codes of its cells",
}

_calibrations: Catalogue[Calibration] = Catalogue(
    "calibration", CALIBRATIONS, "noctule.calibrations", ("chips.codes:Calibration",), CALIBRATION_LINES
)

calibration_names, load_calibration = _calibrations.names, _calibrations.load
calibration_line = _calibrations.line
