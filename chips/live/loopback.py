"""No chip but a wire: each event that goes in comes out at its time, so that a program can be tried on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from chips.live.chip import Addresses, Engine, Train, within
from circuits.arrays import F64, I64, Bools
from circuits.circuit import BiasKind
from circuits.errors import unknown_name
from circuits.silicon.silicon import Silicon

_EVENTS = (Addresses("event", 0, 2**31),)
_NAME = "loopback"


@dataclass(frozen=True)
class LoopbackEngine:
    """The wire; its state is how many events went through."""

    inputs: tuple[Addresses, ...] = _EVENTS
    outputs: tuple[Addresses, ...] = _EVENTS

    @property
    def lines(self) -> Mapping[str, int]:
        """It has no analog inputs."""
        return {}

    def takes(self, addresses: I64) -> Bools:
        """Return whether it takes events of these addresses."""
        return within(self.inputs, addresses)

    def begin(self) -> int:
        """Return the state before the first event."""
        return 0

    def go_on(self, state: int, now: float, until: float, train: Train) -> tuple[int, Train]:
        """Give back the train."""
        return state + train[0].size, train

    def counts(self, state: int) -> Mapping[str, int]:
        """Return how many events went through."""
        return {"events": state}

    def biases(self) -> Mapping[str, float]:
        """It has no biases."""
        return {}

    def with_bias(self, state: int, name: str, value: float) -> tuple[Engine, int]:
        """It has no biases."""
        raise unknown_name(f"{_NAME} bias", name, [])

    def at(self, state: int, temperature_c: float) -> tuple[Engine, int]:
        """It is the same at every temperature."""
        return self, state

    def drive(self, state: int, line: str, values: F64) -> int:
        """It has no analog inputs."""
        raise unknown_name(f"{_NAME} line", line, [])

    def show(self, state: int) -> Mapping[str, F64]:
        """It has no analog outputs."""
        return {}


def open_loopback(silicon: Silicon | None, bias_kind: BiasKind = "generator") -> LoopbackEngine:
    """Return the wire, which has no silicon."""
    return LoopbackEngine()
