"""What every scenario that runs on silicon is asked for: seed, die, temperature, law, and its way with boxes.

A robot's scenario has these fields by deriving from `OnSilicon`. They stand behind its own options in help.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from chips.validity import Answer
from circuits.circuit import BiasKind
from circuits.generator.ripple import Ripple
from circuits.silicon.course import Points, beginning_of
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500, EFFECTS, Effects, Process
from circuits.silicon.silicon import Silicon
from system.option import (
    Checked,
    bias_kind_option,
    course_option,
    die_option,
    option,
    seed_option,
    temperature_option,
)
from system.options.noise import ripple_option
from system.options.outside import outside_option

ROOM_TEMPERATURE = 27.0
"""Temperature of a run that is asked for none, degC."""
IDEAL_CHIP: Mapping[str, Any] = MappingProxyType(
    {"die": NOMINAL, "law": "ideal", "bias_kind": "ideal", "silicon_noise": "off"}
)
"""Options under which a chip without a program of its own is what its paper's equations say."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OnSilicon(Checked):
    """The part of a scenario that says on which silicon it runs.

    Attributes
    ----------
    seed : int
        Seed of noise, worlds and whatever else is drawn, but of no die.
    die : Die
        The die of its chips; the nominal one unless given.
    temperature_c : float
        Temperature of the chips, degC.
    course : tuple of (float, float)
        Times, s, and temperatures, degC, that it follows instead; none unless given.
    law : str
        `full` for transistors with the second-order effects that their process states, `ideal` without.
    bias_kind : str
        What stands behind the bias currents of its chips: `gate`, fixed gate voltages, `ideal`, a current
        proportional to absolute temperature, or `generator`, the bias generator's circuit on the die.
    ripple : Ripple or None
        Sine on the supply of its chips' bias generators; it stands unless given.
    outside : str
        Whether to refuse where a chip's model was not measured, or to warn.
    """

    seed: int = seed_option()
    die: Die = die_option(NOMINAL)
    temperature_c: float = temperature_option(ROOM_TEMPERATURE)
    course: Points = course_option()
    law: Effects = option(
        "full", "Transistors without second-order effects, or with all that the process states",
        choices=EFFECTS, silicon=True, study=True,
    )  # fmt: skip
    bias_kind: BiasKind = bias_kind_option("generator")
    ripple: Ripple | None = ripple_option()
    outside: Answer = outside_option()

    @property
    def beginning_c(self) -> float:
        """Temperature at the beginning, degC."""
        return beginning_of(self.temperature_c, self.course)

    def silicon_at(self, temperature_c: float, process: Process = AMI_1500) -> Silicon:
        """Return the run's silicon at a temperature: a process under the scenario's law, on its die.

        Parameters
        ----------
        temperature_c
            Temperature, degC.
        process
            The process with all its second-order effects.
        """
        return Silicon(process.under(self.law), temperature_c, self.die)
