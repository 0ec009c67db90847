"""Cells and synapses of PyNN that ROLLS has: its neuron, two sources of events, and synapses of a level."""

from __future__ import annotations

from typing import Any, ClassVar

from pyNN.models import BaseCellType
from pyNN.standardmodels import build_translations, cells, synapses

from chips.rolls.pynn.simulator import state


class RollsNeuron(BaseCellType):  # type: ignore[misc]  # PyNN has no types
    """A neuron of the chip, whose biases all neurons share.

    Its parameter `slow_leak` says whether its leak is IF_TAU1 instead of IF_TAU2, both of the chip's biases.
    """

    default_parameters: ClassVar[dict[str, Any]] = {"slow_leak": False}
    default_initial_values: ClassVar[dict[str, Any]] = {}
    recordable: ClassVar[list[str]] = ["spikes"]
    receptor_types: ClassVar[tuple[str, ...]] = ("excitatory", "inhibitory")
    units: ClassVar[dict[str, str]] = {"slow_leak": "dimensionless"}
    conductance_based = True
    injectable = False


class SpikeSourceArray(cells.SpikeSourceArray):  # type: ignore[misc]  # PyNN has no types
    """Events at times that are given, ms."""

    translations = build_translations(("spike_times", "spike_times"))


class SpikeSourcePoisson(cells.SpikeSourcePoisson):  # type: ignore[misc]  # PyNN has no types
    """Events at random times: rate (Hz), start and duration (ms)."""

    translations = build_translations(("rate", "rate"), ("start", "start"), ("duration", "duration"))


class StaticSynapse(synapses.StaticSynapse):  # type: ignore[misc]  # PyNN has no types
    """A synapse with one of the chip's levels, 1 to 4, as its weight, and without a delay."""

    translations = build_translations(("weight", "weight"), ("delay", "delay"))
    default_parameters: ClassVar[dict[str, Any]] = {"weight": 1.0, "delay": None}

    def _get_minimum_delay(self) -> float:
        return float(state.dt)
