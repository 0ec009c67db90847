"""The NEF chip of closed forms: fixed gates, and no second-order effects."""

from __future__ import annotations

from typing import Any

from chips.nef.chip import NefChip
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import ROLLS_180_IDEAL


def paper_chip(die: Die = NOMINAL, **fields: Any) -> NefChip:
    """The chip on a die; fields: others of `NefChip`, by name."""
    return NefChip(die, **{"bias_kind": "gate", "process": ROLLS_180_IDEAL, **fields})
