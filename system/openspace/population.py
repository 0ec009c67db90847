"""What a calibrated ranging chip reads of an echo's delay: by all neurons that answer, and a thermometer.

Windows of neighbours overlap, so that which neurons answer tells 26 edges instead of 13 windows. An echo is
read by the lowest of the neurons that answer and how many do: the mean of the delays that gave the same on
the bench, of the chip at its codes and at the temperature where it was calibrated; by the lowest alone, where
the bench has not met that. Delays of echoes nearer than any that the robot can meet do not count: the first
neuron answers from 0.1 to 0.45 m, and for a bat to which that stood for its mean of 0.27 m, inside of its own
zone of collision, all arcs would be barred.

A chip whose currents are proportional to absolute temperature is slower by as much as it is colder, so that a
reading is multiplied by T_bench / T, T from a thermometer beside the chip. No time since the call or the echo
is used.

With intervals between the first two spikes of bursts too, of the lowest neuron and the highest, readings are
2.7 to 3.5 cm off rms in the place of 5.6 to 6.8 cm at the temperature of the bench (0.3 to 2 m, dies 100 to
102), and 7 to 8 cm three degrees from it, since they do not follow the absolute temperature: left out.

As in `system.openspace.reader` a table is of an echo alone after its call.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from chips.codes import Codes
from chips.noise import SiliconNoise
from chips.ranging.calibration.found import delays_of, off_of, values_of
from chips.ranging.chip import shipped_model
from chips.ranging.law import Neurons
from chips.ranging.model import ReboundModel, check_box, neurons_on, with_biases
from chips.ranging.noise import new_jitter
from circuits.arrays import F64, I64
from circuits.circuit import BiasKind
from circuits.silicon.process import kelvin
from circuits.silicon.silicon import Silicon
from system.openspace.reader import WINDOW, delays, late_spikes
from system.openspace.reader_noise import ANSWERING, Reader, no_reader

KEPT = 64  # chips


@dataclass(frozen=True, slots=True)
class Coded:
    """A ranging chip at its codes.

    silicon : process, temperature and die.
    area : area of its drawn devices over the circuit's.
    bias_kind : kind of its biases.
    biases : values of biases by name, A or V.
    off : neurons that are switched off.
    spare : delay for which each neuron stands where the bench met no answer of it, s.
    calibrated_c : temperature of the bench, degC.
    nearest : delay of the nearest echo that its robot can meet, s.
    """

    silicon: Silicon
    area: float
    bias_kind: BiasKind
    biases: tuple[tuple[str, float | tuple[float, ...]], ...]
    off: tuple[int, ...]
    spare: tuple[float, ...]
    calibrated_c: float
    nearest: float = 0.0

    @property
    def model(self) -> ReboundModel:
        """The model of the chip."""
        return with_biases(shipped_model(self.silicon.process, self.bias_kind), dict(self.biases))

    def at(self, temperature_c: float) -> Coded:
        """Return the chip at another temperature, degC."""
        return replace(self, silicon=replace(self.silicon, temperature_c=temperature_c))

    def neurons(self) -> Neurons:
        """Return its neurons; raises `ParameterError` outside the record's box (`chips.validity`)."""
        model, silicon = self.model, self.silicon.of_area(self.area)
        check_box(model, silicon, "ranging_chip")
        return neurons_on(model, silicon)


def coded(
    silicon: Silicon, codes: Codes, bias_kind: BiasKind = "generator", area: float = 1.0,
    nearest: float = 0.0,
) -> Coded:  # fmt: skip
    """Return the ranging chip on a silicon at codes.

    area: of its drawn devices over the circuit's; nearest: delay of the nearest echo that its robot can meet,
    s.
    """
    values, spare = tuple(sorted(values_of(codes).items())), delays_of(codes)
    return Coded(silicon, area, bias_kind, values, off_of(codes), spare, codes.calibrated_c, nearest)


def population_readings(chip: Coded) -> tuple[F64, int]:
    """Return the reading (s, NaN for none) of each of `delays`, and how many are too near to call.

    Raises `ParameterError` outside the record's box.
    """
    chip.neurons()  # at every call: what follows is worked out once
    late, doubts = _spikes(chip)
    low, answering = _told(late)
    found = population_of(chip)[low, np.minimum(answering, ANSWERING) - 1]
    return np.where(answering == 0, np.nan, found), doubts


def population_reader(chip: Coded, noise: SiliconNoise | None, begun_c: float | None = None) -> Reader:
    """Return a reader before its first ping, of none for None.

    begun_c: temperature (degC) of the run's beginning where it moves, by whose inhibition relaxations are
    told apart. Raises as `population_readings`.
    """
    if noise is None:
        return no_reader()
    neurons = chip.neurons()
    first = neurons if begun_c is None else chip.at(begun_c).neurons()
    shortest, silicon = float(first.t_inh.min()), chip.silicon.of_area(chip.area)
    jitter = new_jitter(chip.model, neurons, silicon, noise, shortest, area=chip.area)
    late, value = _spikes(chip)[0].copy(), np.array(chip.spare)
    return Reader(late, value, jitter, neurons.t_inh.copy(), population_of(chip))


def population_of(chip: Coded) -> F64:
    """Return what each answer stands for at the chip's temperature, s, float64[neurons, ANSWERING]."""
    warmer = kelvin(chip.silicon.temperature_c) / kelvin(chip.calibrated_c)
    return np.asarray(_population(chip.at(chip.calibrated_c)) / warmer)


@lru_cache(maxsize=KEPT)
def _population(chip: Coded) -> F64:
    """Mean delays of each answer on the bench."""
    low, answering = _told(_spikes(chip)[0])
    heard = (answering > 0) & (delays() >= chip.nearest)
    place = (low[heard], np.minimum(answering[heard], ANSWERING) - 1)
    total, count = np.zeros((2, len(chip.spare), ANSWERING))
    np.add.at(total, place, delays()[heard])
    np.add.at(count, place, 1.0)
    spare = np.maximum(chip.spare, chip.nearest)
    lowest = _mean(total.sum(axis=1), count.sum(axis=1), spare)
    return _mean(total, count, lowest[:, None])


def _mean(total: F64, count: F64, spare: F64) -> F64:
    """Total over count, and `spare` where there is none."""
    spares = np.broadcast_to(spare, total.shape).copy()
    return np.asarray(np.divide(total, count, out=spares, where=count > 0.0))


@lru_cache(maxsize=KEPT)
def _spikes(chip: Coded) -> tuple[F64, int]:
    """Late spikes of its neurons, but those that are off, and how many delays are too near to call."""
    late, doubts = late_spikes(chip.neurons())
    late[list(chip.off)] = np.inf
    late.setflags(write=False)
    return late, doubts


def _told(late: F64) -> tuple[I64, I64]:
    """Lowest neuron that answers, and how many do, int64[delays] each."""
    hit = late <= WINDOW
    return hit.argmax(axis=0), hit.sum(axis=0)
