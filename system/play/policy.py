"""A chip as a controller: what is sensed goes in as events, what it sends becomes an action.

It is the controller of a run step by step, and of any environment: `action = policy(observation)`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from chips.live.chip import LiveChip
from circuits.errors import ParameterError
from system.play.decoder import Decoder
from system.play.encoder import Encoder


class ChipPolicy:
    """A chip that chooses actions.

    Parameters
    ----------
    chip
        A chip that is driven live, with its network, at its start.
    encoder
        Makes events of what is sensed.
    decoder
        Makes an action of what the chip sends.
    window
        How long the chip goes on for an action, s; a robot's own time between two actions, unless it is to
        think faster or slower.
    features
        Makes the numbers that are coded, float64[n], of an observation; all of it unless given.

    Raises
    ------
    ParameterError
        The window is not above 0.
    """

    def __init__(
        self, chip: LiveChip, encoder: Encoder, decoder: Decoder, window: float,
        features: Callable[[Any], ArrayLike] | None = None,
    ) -> None:  # fmt: skip
        if not window > 0.0:
            raise ParameterError(f"policy.window: {window:g} s, must be above 0")
        self.chip, self.encoder, self.decoder, self.window = chip, encoder, decoder, window
        self._features, self._rest = features, chip.state
        self.begin()

    def begin(self) -> None:
        """Put the chip back to where it was when the policy was made, as for another run."""
        self.chip.state = self._rest
        self.encoder.begin()
        self.decoder.begin()

    def __call__(self, observation: Any) -> ArrayLike:
        """Return the action for an `observation`; the chip goes on by a window."""
        seen = observation if self._features is None else self._features(observation)
        start = self.chip.time
        times, addresses = self.encoder.events(np.asarray(seen, dtype=np.float64), start, self.window)
        self.chip.send(times, addresses)
        return self.decoder.action(self.chip.advance(self.window), start, self.window)
