"""Biases of the Pushbot's network: codes that differ from the control software's defaults, and why.

All are ours. The table of the paper's experiments (Appendix A) is not public, and with the lab's default
weights (inhibition of up to 44 uA) one spike silences a neuron of our circuits for long. They were found by
hand on dies below 1000 with the generator's currents, one table for all dies:

* an obstacle population is silent at the 110 events a second that the empty arena makes in its half of the
  sensor at 0.35 m/s, and fires tens of Hz where a block fills part of the view;
* exc holds itself up once started, at what the refractory period lets through, and sp fires as it does, at
  the 266 Hz that are 0.35 m/s at speed factor 0.5 (equation (2), the robot's wheels);
* obstacle populations slow sp down; the stronger of two drives silences the other, and a drive lowers both
  obstacle populations.

Levels of the networks follow the currents: of the exciting levels 3 is weaker than 2.
"""

from __future__ import annotations

from collections.abc import Mapping

from chips.pushbot_network import PushbotLevels
from chips.rolls_bias_file import COARSE_NAMES, BiasTable, default_biases

LEVELS = PushbotLevels(
    obstacle_to_drive=3, obstacle_to_speed=-2, drive_to_drive=-4, drive_to_obstacle=-1, exc_to_exc=4,
    exc_to_speed=4, target_to_drive=4, field_near=(2, 3, 3), field_far=-1,
)  # fmt: skip

# coarse current and fine code; nominal current at 27 degC behind it
CODES: Mapping[str, tuple[str, int]] = {
    # neuron: no direct current, so that it rests; leak of 1 ms and a threshold that leaves the rate a nearly
    # straight line of the input; refractory period such that sp stands for 0.7 m/s at speed factor 1
    "IF_DC_P": ("15p", 0),
    "IF_TAU2_N": ("820p", 62),  # 0.20 nA
    "IF_TAU1_N": ("105p", 73),  # 30 pA, for what owns columns of the sensor and hears few events
    "IF_THR_N": ("6.5n", 236),  # 6.0 nA
    "IF_RFR2_N": ("820p", 76),  # 0.24 nA
    # events: a pulse of 13 us; the virtual filter counts over about 15 ms
    "NPA_PWLK_P": ("50n", 51),  # 10 nA
    "VDPIE_TAU_P": ("15p", 68),  # 4.0 pA
    "VDPIE_THR_P": ("15p", 68),
    "VA_EXC_N": ("0.4u", 42),  # 66 nA
    # between neurons: filters of about 6 ms
    "NPDPIE_TAU_P": ("15p", 171),  # 10 pA
    "NPDPIE_THR_P": ("15p", 171),
    "NPDPII_TAU_P": ("15p", 171),
    "NPDPII_THR_P": ("15p", 171),
    # levels 1 to 4: 10, 69, 40, 99 nA excite, 8, 22, 67, 82 nA inhibit
    "NPA_WEIGHT_EXC_P": ("50n", 51),
    "NPA_WEIGHT_EXC0_P": ("0.4u", 38),
    "NPA_WEIGHT_EXC1_P": ("50n", 154),
    "NPA_WEIGHT_INH_N": ("50n", 41),
    "NPA_WEIGHT_INH0_N": ("50n", 72),
    "NPA_WEIGHT_INH1_N": ("0.4u", 38),
}


def pushbot_biases(changes: Mapping[str, tuple[str, int]] | None = None) -> BiasTable:
    """The table, with other codes for what `changes` names, as `{"VA_EXC_N": ("50n", 100)}`."""
    table = default_biases()
    for name, (coarse, fine) in {**CODES, **(changes or {})}.items():
        table = table.with_code(name, COARSE_NAMES.index(coarse), fine)
    return table
