"""Biases of ROLLS' plastic array: which code is which current of its circuits, and codes to learn with.

Names are the control software's; that a name is this current is ours
(`circuits.blocks.rolls.plastic_synapse`, `circuits.blocks.rolls.calcium_gate`). Its default file has learning
switched off: PA_DELTAUP and PA_DELTADN have fine code 0, so every code of `LEARNING_CODES` is ours. SL_MEMTHR
is the current that an nFET of the membrane's comparator carries at the threshold, so that it follows a die's
membranes. PA_WTHR is no code here but the volts of `chips.rolls.plastic.circuit.Learning`; SL_BUF, PDPI_BUF
and PDPI_VMONPU have no circuit.
"""

from __future__ import annotations

from collections.abc import Mapping

from chips.rolls.program.bias_file import BiasTable
from circuits.blocks.rolls.bias import Code

# Bias of a block: bias of the chip
CELL_BIASES: Mapping[str, str] = {
    "i_up": "PA_DELTAUP_P", "i_dn": "PA_DELTADN_N", "i_driftup": "PA_WDRIFTUP_P",
    "i_driftdn": "PA_WDRIFTDN_N", "i_cmp": "PA_WDRIFT_P", "i_weight": "PA_WHIDN_N",
}  # fmt: skip
GATE_BIASES: Mapping[str, str] = {
    "i_caw": "SL_CAW_N", "i_catau": "SL_CATAU_P", "i_cathr": "SL_CATHR_P", "i_thmin": "SL_THMIN_N",
    "i_thdn": "SL_THDN_P", "i_thup": "SL_THUP_P", "i_mcmp": "SL_WTA_P",
}  # fmt: skip
PULSE = "PA_PWLK_P"  # of the columns' extenders and of the neurons' own
MEMBRANE = "SL_MEMTHR_N"
MOVES = ("PA_DELTAUP_P", "PA_DELTADN_N")

# All ours. An event moves a weight by 0.18 V up or 0.12 V down, it drifts at 3.4 and 4 V/s; calcium of 0.1 s
# with thresholds that a neuron passes at about 12, 48 and 170 Hz, the membrane's at 4 nA or 0.31 V; a high
# weight draws 12 nA, and its filter has 11 ms
LEARNING_CODES: Mapping[str, Code] = {
    "PA_PWLK_P": (3, 53),
    "PA_DELTAUP_P": (4, 34),
    "PA_DELTADN_N": (4, 22),
    "PA_WDRIFTUP_P": (7, 7),
    "PA_WDRIFTDN_N": (7, 8),
    "PA_WDRIFT_P": (6, 99),
    "PA_WHIDN_N": (3, 60),
    "PDPI_TAU_P": (7, 60),
    "PDPI_THR_P": (7, 60),
    "SL_CAW_N": (3, 100),
    "SL_CATAU_P": (7, 10),
    "SL_CATHR_P": (7, 20),
    "SL_THMIN_N": (6, 24),
    "SL_THDN_P": (6, 80),
    "SL_THUP_P": (6, 240),
    "SL_WTA_P": (4, 40),
    "SL_MEMTHR_N": (4, 160),
}


def with_learning(table: BiasTable, codes: Mapping[str, Code] = LEARNING_CODES) -> BiasTable:
    """Return `table` with the codes of the plastic array.

    Raises `UnknownNameError` for a bias that the table does not have.
    """
    for name, code in codes.items():
        table = table.with_code(name, *code)
    return table
