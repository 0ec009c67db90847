"""What a circuit is made of in a run: a process, a temperature, a die, and a place on it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from circuits.arrays import F64
from circuits.checks import require_type
from circuits.silicon.die import NOMINAL, Die, Path, Place, mismatch, shared
from circuits.silicon.process import (
    AMI_1500,
    Polarity,
    Process,
    TransistorAtTemperature,
    at_temperature,
    check_temperature,
    thermal_voltage,
)


class Deviation(NamedTuple):
    """Local deviations of transistors.

    Attributes
    ----------
    v_t0 : float or array
        Added to the magnitude of the threshold voltage, V: float64[count], or 0 for none.
    beta : float or array
        Relative change of the current factor, dimensionless: float64[count], or 0 for none.
    """

    v_t0: F64 | float
    beta: F64 | float


NO_DEVIATION = Deviation(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Silicon:
    """A process at a temperature, on a die.

    Attributes
    ----------
    process : Process
        Process in which the circuit is made.
    temperature_c : float
        Temperature, degC.
    die : Die
        The die, which decides how every device deviates; the nominal one unless given.
    place : tuple or None
        Where a circuit that is simulated by itself stands on its chip, ((chip, ()), (instance, index), ...),
        so that it has the chip's devices. A circuit without a place stands by itself under its own name.

    Raises
    ------
    ParameterError
        The temperature is outside of what the laws hold for, or a part is of the wrong type.
    """

    process: Process = AMI_1500
    temperature_c: float = 27.0
    die: Die = NOMINAL
    place: Place | None = None

    def __post_init__(self) -> None:
        require_type("silicon.process", self.process, Process, "a process, as AMI_1500")
        require_type("silicon.die", self.die, Die, "a die, as Die('A', 1003)")
        check_temperature(self.temperature_c)

    @property
    def thermal_voltage(self) -> float:
        """U_T at the silicon's temperature, V."""
        return thermal_voltage(self.temperature_c)

    def law(self, polarity: Polarity) -> TransistorAtTemperature:
        """Parameters that all transistors of a polarity share on this die at this temperature."""
        law = at_temperature(self.process.model(polarity), self.process, self.temperature_c)
        shift = shared(self.die, self.process, polarity)
        return replace(
            law, v_t0=law.v_t0 + shift.v_t0, square_current=law.square_current * (1.0 + shift.beta)
        )

    def of_area(self, area: float) -> Silicon:
        """The silicon of devices `area` times as large, whose mismatch is `1 / sqrt(area)` of theirs."""
        process, root = self.process, math.sqrt(area)
        wider = replace(process, pair_a_vt=process.pair_a_vt / root, pair_a_beta=process.pair_a_beta / root)
        return replace(self, process=wider)

    def deviation(self, circuit: str, path: Path, area: F64 | float) -> Deviation:
        """Local deviations of the transistors at `path` in a circuit called `circuit`.

        Parameters
        ----------
        circuit
            Name of the circuit.
        path
            Path of the transistors, ((instance name, shape), ..., (device name, ())).
        area
            Area m W L of each transistor, float64[count], or of all, m^2.
        """
        return self.deviations(circuit, (path,), area)

    def deviations(self, circuit: str, paths: Sequence[Path], area: F64 | float) -> Deviation:
        """Local deviations of the transistors at several paths in a circuit, one after the other.

        Parameters
        ----------
        circuit
            Name of the circuit.
        paths
            Paths, each as of `deviation`.
        area
            Area m W L of each transistor, float64[count], or of all, m^2.
        """
        place = ((circuit, ()),) if self.place is None else self.place
        return Deviation(*mismatch(self.die, self.process, place, paths, area))
