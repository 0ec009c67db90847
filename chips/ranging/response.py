"""What rebound neurons of the behavioural model do: their classes and intervals, and their spikes.

A spike that the margin of the threshold would undo, or bring about, is `undecided`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from chips.ranging.law import Neurons
from chips.ranging.neuron_kernel import COLUMNS, respond_all
from chips.ranging.tuning_kernel import CLASSES, tune_all
from circuits.arrays import F64, I64, Bools
from circuits.errors import ParameterError

STATES = 65  # kept after a call while a neuron is tuned
ROOM = 256  # spikes of a neuron that a response keeps
UNDECIDED = "undecided"


@dataclass(frozen=True, slots=True)
class Tunings:
    """To which delays n neurons are tuned.

    Attributes
    ----------
    outcome : array
        Number of the class of each neuron, int64[n].
    undecided : array
        Whether the class was too near to call, bool[n].
    first, last : array
        First and last facilitating delay, float64[n], s, NaN where not defined.
    t_inh : array
        Time from the call to the release of inhibition, float64[n], s.
    peak : array
        Highest v_mem after a call alone, float64[n], V.
    """

    outcome: I64
    undecided: Bools
    first: F64
    last: F64
    t_inh: F64
    peak: F64

    @property
    def classes(self) -> list[str]:
        """Class of each neuron, or `undecided`."""
        return [UNDECIDED if u else CLASSES[o] for o, u in zip(self.outcome, self.undecided, strict=True)]


class Response(NamedTuple):
    """What neurons answer to calls and echoes.

    Attributes
    ----------
    spikes : tuple of array
        Times of the spikes of each neuron, float64[spikes] each, s.
    undecided : array
        At how many moments a spike was too near to call, int64[n].
    """

    spikes: tuple[F64, ...]
    undecided: I64


def join(parts: Sequence[Neurons]) -> Neurons:
    """Return neurons of several dies of one model as one array of neurons."""
    names = [n for n in Neurons._fields if getattr(parts[0], n) is not None]
    return Neurons(**{n: np.concatenate([getattr(p, n) for p in parts]) for n in names})


def tune(neurons: Neurons) -> Tunings:
    """Return class and facilitating interval of each of `neurons`.

    They are those of `circuits.blocks.sonar.tuning`.
    """
    n = neurons.t_inh.size
    outcome, undecided, out = np.zeros(n, np.int64), np.zeros(n, np.bool_), np.zeros((n, 3))
    tune_all(neurons, np.zeros((STATES, COLUMNS)), np.zeros(COLUMNS), outcome, undecided, out)
    return Tunings(outcome, undecided, out[:, 0], out[:, 1], neurons.t_inh, out[:, 2])


def respond(neurons: Neurons, calls: Sequence[float], echoes: Sequence[float], until: float) -> Response:
    """Return the spikes of neurons that rest before the first of the calls and echoes.

    Parameters
    ----------
    neurons
        The neurons.
    calls, echoes
        Times of calls and of echoes, s.
    until
        Time up to which spikes are returned, s.

    Raises
    ------
    ParameterError
        A neuron spikes more often than `ROOM` times.
    """
    events = sorted([*((t, True) for t in calls), *((t, False) for t in echoes)])
    n = neurons.t_inh.size
    spikes, counts = np.zeros((n, ROOM)), np.zeros((n, 2), np.int64)
    times = np.array([t for t, _ in events])
    is_call = np.array([c for _, c in events], dtype=np.bool_)
    respond_all(neurons, times, is_call, until, np.zeros(COLUMNS), spikes, counts)
    if counts[:, 0].max(initial=0) > ROOM:
        raise ParameterError(f"response: {counts[:, 0].max()} spikes, must be <= {ROOM}; end it earlier")
    kept = tuple(spikes[k, : counts[k, 0]].copy() for k in range(n))
    return Response(kept, counts[:, 1])
