"""Voltage-controlled current source: `I = g (v_cp - v_cn)`, flowing from `positive` through to `negative`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from circuits.devices.device import Device, require_finite


@dataclass(frozen=True, slots=True)
class ControlledSource(Device):
    """A linear transconductance of `transconductance` siemens.

    The current leaves node `positive`, passes the source and enters node `negative` (SPICE's G element).
    """

    name: str
    positive: str
    negative: str
    control_positive: str
    control_negative: str
    transconductance: float

    def terminals(self) -> tuple[str, ...]:
        """Return (positive, negative, control_positive, control_negative)."""
        return self.positive, self.negative, self.control_positive, self.control_negative

    def parameters(self) -> Mapping[str, float]:
        """Return the transconductance, S."""
        return {"transconductance": self.transconductance}

    def check(self) -> None:
        """Require a finite transconductance; either sign is allowed."""
        require_finite(self, "transconductance", "S")

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """An ideal current source fixes no voltage, so that it is no path to ground by itself."""
        return ()
