"""A network that a task plays with, window after window: mapped on a die, or the equations that were asked.

    network = a player
    network.begin(3)                            at rest, with the noise of sample 3
    outputs = network(inputs, window)           over a window

A task sees no more, so that it cannot tell a die from the ideal. A die's noise is that of the sample's number
under the run's seed, whatever was run before it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.mapping.certify.ends import Ends


class Player(ABC):
    """A network that goes on by windows.

    Parameters
    ----------
    ends
        Its inputs and outputs.

    Raises
    ------
    ParameterError
        It has no output.
    """

    def __init__(self, ends: Ends) -> None:
        if not ends.outputs:
            raise ParameterError("program: no probe, must have one for each output; add them and map again")
        self.ends, self.lost = ends, 0
        self._number = -1

    @property
    def channels(self) -> int:
        """How many inputs it takes."""
        return self.ends.channels

    @property
    def outputs(self) -> int:
        """How many outputs it has."""
        return self.ends.outputs

    def begin(self, number: int | None = None) -> None:
        """Put the network to rest, where a sample begins.

        Parameters
        ----------
        number
            That of the sample, from 0 on, by which its noise is drawn; the next one unless given.

        Raises
        ------
        ParameterError
            The number is not whole, or below 0.
        """
        number = self._number + 1 if number is None else number
        if number != round(number) or number < 0:
            raise ParameterError(f"task.begin: sample {number}, must be a whole number from 0 on")
        self._number = round(number)
        self._rest(self._number)

    def __call__(self, inputs: ArrayLike, window: float) -> F64:
        """Go on for a window with the same inputs, and return what each output is over it, float64[outputs].

        On ROLLS that is how often its neurons spike, on the NEF chip the mean of its value.

        Parameters
        ----------
        inputs
            Of each channel of outside, float64[channels]: rates (Hz) on ROLLS, values on the NEF chip.
        window
            How long, s, in whole steps of the chip, of 0.4 ms on ROLLS and 1 ms on the NEF chip.

        Raises
        ------
        ParameterError
            There are not as many inputs as channels, one is outside of its limits, or the window is none.
        """
        return self._go_on(self._given(inputs, window), window)

    def answer(self, number: int, inputs: ArrayLike, window: float) -> F64:
        """Return the outputs over a window from rest, as `begin(number)` and a call give them.

        What a network needs of the inputs alone may be kept for the next die. The next window begins at rest.
        Raises as these do.
        """
        self.begin(number)
        return self(inputs, window)

    def _given(self, inputs: ArrayLike, window: float) -> F64:
        """Inputs as an array; raises `ParameterError` as a call does."""
        given, ends = np.asarray(inputs, dtype=np.float64).ravel(), self.ends
        if given.size != ends.channels or not ends.inside(given):
            told = f"{given.size} from {given.min(initial=0.0):g} to {given.max(initial=0.0):g}{ends.unit}"
            raise ParameterError(
                f"task.{ends.noun}s: {told}, must be {ends.channels} {ends.limits}, one each channel"
            )
        ends.check_window(window)
        return given

    @abstractmethod
    def _rest(self, number: int) -> None:
        """Put what runs to rest, with the noise of sample `number`."""

    @abstractmethod
    def _go_on(self, inputs: F64, window: float) -> F64:
        """Go on for a window, and return its outputs."""
