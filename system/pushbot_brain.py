"""Which network is on the Pushbot's chip, on which die, with which biases."""

from __future__ import annotations

from dataclasses import dataclass

from chips.pushbot_biases import LEVELS, pushbot_biases
from chips.pushbot_network import PushbotLayout, pushbot_network
from chips.rolls_chip import RollsChip
from chips.rolls_network import network_program
from circuits.circuit import BiasKind
from circuits.die import NOMINAL, Die
from circuits.process import ROLLS_180
from circuits.silicon import Silicon
from system.pushbot_loop import Brain

FIELD_SCENES = ("target", "chase", "obstacle-against-target")  # in which the field gets events


@dataclass(frozen=True, slots=True)
class Architecture:
    """Plain or modified; whether the target field gets events; neurons of exc, 8 or 16 by the sources."""

    modified: bool = False
    target: bool = False
    exc: int = 16


def brain_of(
    architecture: Architecture, die: Die = NOMINAL, temperature_c: float = 27.0, kind: BiasKind = "generator"
) -> Brain:
    """A chip with an architecture; biases have one table for all dies, set at 27 degC."""
    network = pushbot_network(PushbotLayout(exc=architecture.exc), LEVELS)
    silicon = Silicon(ROLLS_180, temperature_c, die)
    chip = RollsChip(network_program(network, pushbot_biases()), silicon, kind)
    return Brain(network, chip, target=architecture.target, synapses=LEVELS.dvs_synapses)
