"""Voltage-controlled current source: `I = g (v_cp - v_cn)`, flowing from `positive` through to `negative`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from circuits.devices.device import Device, require_finite


@dataclass(frozen=True, slots=True)
class ControlledSource(Device):
    """A linear transconductance, which is SPICE's G element.

    The current `g (v_control_positive - v_control_negative)` leaves the node `positive`, passes the source
    and enters the node `negative`.

    Attributes
    ----------
    positive, negative : str
        Nodes that the current leaves and enters.
    control_positive, control_negative : str
        Nodes whose voltage controls the current.
    transconductance : float
        Current for each volt of control, S; it may have either sign.

    Raises
    ------
    ParameterError
        The transconductance is not finite.
    """

    name: str
    positive: str
    negative: str
    control_positive: str
    control_negative: str
    transconductance: float

    def terminals(self) -> tuple[str, ...]:
        """The nodes positive, negative, control_positive and control_negative."""
        return self.positive, self.negative, self.control_positive, self.control_negative

    def parameters(self) -> Mapping[str, float]:
        """The transconductance, S."""
        return {"transconductance": self.transconductance}

    def check(self) -> None:
        """Raise `ParameterError` unless the transconductance is finite; it may have either sign."""
        require_finite(self, "transconductance", "S")

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """No pairs: an ideal current source fixes no voltage, and is no path to ground by itself."""
        return ()
