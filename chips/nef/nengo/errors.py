"""Errors of ours that are nengo's of the same place too, so that a script may catch either."""

from __future__ import annotations

import nengo.exceptions

from circuits.errors import ParameterError, TopologyError


class ClosedError(TopologyError, nengo.exceptions.SimulatorClosed):  # type: ignore[misc]  # nengo has no types
    """A simulator that is closed is asked to go on."""


class RefusedError(ParameterError, nengo.exceptions.BuildError):  # type: ignore[misc]  # nengo has no types
    """A network has what cannot be built."""


class CallError(ParameterError, nengo.exceptions.SimulationError):  # type: ignore[misc]  # nengo has no types
    """A function of a network gives in a run what it must not."""


class InvalidError(ParameterError, nengo.exceptions.ValidationError):  # type: ignore[misc]  # nengo has no types
    """An argument breaks a rule."""

    def __init__(self, text: str) -> None:
        super(nengo.exceptions.ValidationError, self).__init__(text)
        self.attr, self.obj = text.partition(":")[0], None

    def __str__(self) -> str:
        """Return the text, a single line."""
        return " ".join(str(self.args[0]).split())
