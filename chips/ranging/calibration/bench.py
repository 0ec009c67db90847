"""A ranging chip on the bench: calls and echoes go in, spikes come out with their addresses.

The chip is the behavioural model at the temperature of the bench, with the noise of its devices, which goes
on from one measurement to the next. All neurons get the same call and the same echo, so that one series of
trials measures them all.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chips.noise import SiliconNoise
from chips.ranging.calibration.kernel import BOTH, CALL, ECHO, trials
from chips.ranging.kernel import new_chip
from chips.ranging.law import Neurons
from chips.ranging.model import ReboundModel, neurons_on, with_biases
from chips.ranging.noise import Jitter, new_jitter
from chips.ranging.temperature import conditions_of
from circuits.arrays import F64, I64, Bools
from circuits.silicon.silicon import Silicon

PERIOD = 80e-3  # s, of a trial: twice the longest window's end; ours
REPEATS = 2  # of a call or an echo alone; ours
NOISE = SiliconNoise(trial=1)  # another one than that of a run, whose trial is 0

Values = Mapping[str, float | tuple[float, ...]]


class Bench:
    """A bench with a chip on a silicon.

    Parameters
    ----------
    model
        Model of the chip, whose biases are moved.
    silicon
        Process, temperature of the bench, and die.

    Attributes
    ----------
    seconds : float
        Time for which the chip was run, s.
    """

    def __init__(self, model: ReboundModel, silicon: Silicon) -> None:
        """Put the chip on the bench."""
        self.model, self.silicon = model, silicon
        self.seconds = 0.0
        self._jitter: Jitter | None = None
        self._inhibition: object = None
        self._shortest = 0.0  # s, an inhibition, by which relaxations are told apart

    def spikes(self, values: Values, sent: int, delays: F64) -> I64:
        """Return the spikes of each neuron in trials, int64[trials, n].

        Parameters
        ----------
        values
            Of biases by name, A or V; the others are those of the model.
        sent
            What a trial sends, as in `chips.ranging.calibration.kernel`.
        delays
            Of the echo in each trial, s.
        """
        model = with_biases(self.model, values)
        neurons = neurons_on(model, self.silicon)
        on = conditions_of(neurons, self._jitter_of(model, neurons))
        chip = new_chip(on.neurons, on.plan, self.seconds, on.jitter)
        counts = np.zeros((1 + delays.size, neurons.t_inh.size), np.int64)
        trials(on.neurons, on.plan, chip, self.seconds + PERIOD, PERIOD, sent, delays, counts)
        self.seconds += PERIOD * (1 + delays.size)
        return counts[1:]

    def _jitter_of(self, model: ReboundModel, neurons: Neurons) -> Jitter:
        """Jitter of the inhibition, which nothing moves but its own current; flicker goes on."""
        inhibition, before = model.circuit.bias("i_inh_tau").value, self._jitter
        if before is not None and inhibition == self._inhibition:
            return before
        if before is None:
            self._shortest = float(neurons.t_inh.min())
        made = new_jitter(model, neurons, self.silicon, NOISE, self._shortest)
        if before is not None:
            made = made._replace(relaxation=before.relaxation, last=before.last, calls=before.calls)
        self._jitter, self._inhibition = made, inhibition
        return made

    def answers(self, values: Values, delays: F64) -> I64:
        """Return the spikes after a call and an echo at each of `delays`, s, int64[trials, n]."""
        return self.spikes(values, BOTH, delays)

    def alone(self, values: Values, sent: int, repeats: int = REPEATS) -> Bools:
        """Return which neurons spike after a call alone, or an echo alone, at least once, bool[n]."""
        return np.asarray(self.spikes(values, sent, np.zeros(repeats)).any(axis=0))

    def call_alone(self, values: Values, repeats: int = REPEATS) -> Bools:
        """Return which neurons spike after a call alone, bool[n]."""
        return self.alone(values, CALL, repeats)

    def echo_alone(self, values: Values, repeats: int = REPEATS) -> Bools:
        """Return which neurons spike after an echo alone, bool[n]."""
        return self.alone(values, ECHO, repeats)
