"""What a circuit is made of in a run: a process, a temperature, a die, and a place on it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.checks import require_type
from circuits.errors import ParameterError
from circuits.silicon.die import (
    NOMINAL,
    PARAMETERS,
    SLOPE,
    Die,
    Path,
    Place,
    components_of,
    mismatch,
    note,
    shared,
    unnoted,
)
from circuits.silicon.edit import edited
from circuits.silicon.gradient import gradient
from circuits.silicon.passive import Kind, passive
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


class Change(NamedTuple):
    """Change of capacitors, resistors or diodes on a die, by their places and by what they share.

    Attributes
    ----------
    value : float or array
        Relative change of the capacitance, resistance or saturation current, dimensionless: float64[count],
        or 0 for none.
    """

    value: F64 | float


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
        The temperature is outside of what the laws hold for, a part is of the wrong type, or the die has
        components of variation that the process does not state.
    """

    process: Process = AMI_1500
    temperature_c: float = 27.0
    die: Die = NOMINAL
    place: Place | None = None

    def __post_init__(self) -> None:
        require_type("silicon.process", self.process, Process, "a process, as AMI_1500")
        require_type("silicon.die", self.die, Die, "a die, as Die('A', 1003)")
        check_temperature(self.temperature_c)
        if self.die.components:
            components_of(self.process)

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

    def seen_by(self, *names: str) -> Silicon:
        """The silicon without those edits of its die that are of other circuits.

        So what depends on some circuits alone is known again after edits elsewhere.

        Parameters
        ----------
        names
            Names at which the paths of the circuits' devices begin.
        """
        return replace(self, die=self.die.seen_by(*names)) if self.die.edits else self

    def of_area(self, area: float) -> Silicon:
        """The silicon of devices `area` times as large, whose mismatch is `1 / sqrt(area)` of theirs."""
        process, root = self.process, math.sqrt(area)
        wider = replace(process, pair_a_vt=process.pair_a_vt / root, pair_a_beta=process.pair_a_beta / root)
        if process.diodes is not None:
            apart = process.diodes.pair_a_saturation / root
            wider = replace(wider, diodes=replace(process.diodes, pair_a_saturation=apart))
        return replace(self, process=wider)

    def deviation(
        self, circuit: str, path: Path, area: F64 | float, polarity: Polarity | None = None
    ) -> Deviation:
        """Local deviations of the transistors at `path` in a circuit called `circuit`.

        Parameters
        ----------
        circuit
            Name of the circuit.
        path
            Path of the transistors, ((instance name, shape), ..., (device name, ())).
        area
            Area m W L of each transistor, float64[count], or of all, m^2.
        polarity
            Their polarity, which a die with components of variation has to know.

        Raises
        ------
        ParameterError
            The die has components of variation, and no polarity is given.
        """
        return self.deviations(circuit, (path,), area, None if polarity is None else (polarity,))

    def deviations(
        self,
        circuit: str,
        paths: Sequence[Path],
        area: F64 | float,
        polarities: Sequence[Polarity] | None = None,
    ) -> Deviation:
        """Local deviations of the transistors at several paths in a circuit, one after the other.

        Parameters
        ----------
        circuit
            Name of the circuit.
        paths
            Paths, each as of `deviation`.
        area
            Area m W L of each transistor, float64[count], or of all, m^2.
        polarities
            Polarity of the transistors at each path, which a die with components of variation has to know.

        Raises
        ------
        ParameterError
            The die has components of variation, and no polarities are given.
        """
        place = self._place_of(circuit)
        v_t0, beta = mismatch(self.die, self.process, place, paths, area)
        if not (self.die.components and self.die.mismatch):
            return Deviation(v_t0, beta)
        if polarities is None:
            raise ParameterError(
                f"{circuit}: no polarities of its transistors, a die with gradients needs them; give them"
            )
        slopes = _slopes(self.die, self.process, place, paths, polarities)
        if (own := unnoted(self.die)) is not self.die:
            before = _slopes(own, self.process, place, paths, polarities)
            for name, slope in zip(PARAMETERS, before, strict=True):
                note(self.die, (place, tuple(paths), SLOPE + name), slope, self.process)
        return Deviation(v_t0 + slopes[0], beta + slopes[1])

    def change(self, circuit: str, paths: Sequence[Path], kind: Kind, value: F64) -> Change:
        """Change of the capacitors, resistors or diodes at several paths in a circuit, one after the other.

        Parameters
        ----------
        circuit
            Name of the circuit.
        paths
            Paths of the devices, each as of `deviation`.
        kind
            Whether they are capacitors, resistors or diodes.
        value
            Their capacitance (F) or resistance (Ohm) as drawn, or a diode's area, float64[count].
        """
        place = self._place_of(circuit)
        return Change(passive(self.die, self.process, place, paths, kind, value))

    def _place_of(self, circuit: str) -> Place:
        return ((circuit, ()),) if self.place is None else self.place


def _slopes(
    die: Die, process: Process, place: Place, paths: Sequence[Path], polarities: Sequence[Polarity]
) -> tuple[F64, F64]:
    """What gradients add to devices that edits neither heal nor set; what alone deviates is of planes."""
    slopes = gradient(die, process, place, paths, polarities)
    edits = [edit for edit in die.edits if edit.kind != "only"]
    if not edits:
        return slopes
    found = []
    for name, slope in zip(PARAMETERS, slopes, strict=True):
        changed = edited(edits, place, tuple(paths), name)
        found.append(slope if changed is None else slope * changed.kept * np.isnan(changed.value))
    return found[0], found[1]
