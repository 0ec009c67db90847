"""The ROLLS chip with a program on a die: 256 neurons and their synapses, with events over a bus.

    chip = RollsChip(program, Silicon(ROLLS_180, 27.0, Die(number=3)))
    state = chip.at_rest()
    spikes, state = chip.run(state, 0.1, events)

Every neuron, filter, synapse, extender and bias has the deviations of its own transistors
(`chips.rolls.circuit`); what a step does with them is in `chips.rolls.kernel`. An event reaches its
filter at the beginning of a step, a spike of a neuron those of the next step.

A program with a plastic array (`chips.rolls.plastic.program`) has 256 x 256 synapses more that learn:
columns 0 to 255, weights that are read and set between runs, and the learning circuits' own part of the
kernel (`chips.rolls.plastic.kernel`). In one with short-term depression (`chips.rolls.depression.program`)
excitatory weights fall with every event and come back (`chips.rolls.depression.kernel`). Without the one or
the other nothing of it is built, compiled or run.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from chips.aer import Bus, Events, send
from chips.noise import SiliconNoise
from chips.rolls.brief.encoded import Encoded, Summed, firsts_of
from chips.rolls.brief.narrow import fewest, narrowed, stands_alone
from chips.rolls.circuit import Params
from chips.rolls.depression.layout import Depressing
from chips.rolls.depression.state import (
    DepressionState,
    converted_depression,
    depressing_of,
    depression_cautions,
    rest_of_depression,
)
from chips.rolls.depression.state import state_of as depression_state
from chips.rolls.depression.tables import with_depression
from chips.rolls.input_check import check_inputs
from chips.rolls.kernel import run_chip
from chips.rolls.layout import (
    COUNTS,
    DONE,
    HELD,
    LAST,
    NEVER,
    READ,
    SHUT,
    STATE_ROWS,
    V_AHP,
    WRITTEN,
    ZETA,
    ChipRun,
    Traffic,
    new_scratch,
)
from chips.rolls.lumped.filter import rest_filters
from chips.rolls.neuron.kernel import rest_of
from chips.rolls.noise.model import with_noise
from chips.rolls.noise.trial import drawn_anew
from chips.rolls.plastic.circuit import Learning
from chips.rolls.plastic.layout import Plastic, PlasticEvents
from chips.rolls.plastic.state import (
    PlasticState,
    arrays_of,
    bits_of,
    convert,
    plastic_cautions,
    rest_of_plastic,
    scratch_of,
    state_of,
    voltages,
)
from chips.rolls.plastic.tables import BuiltPlastic, build_plastic
from chips.rolls.program.address import NEURONS, NONPLASTIC, VIRTUAL_EXCITATORY, VIRTUAL_LINES
from chips.rolls.program.program import Program
from chips.rolls.state import converted, zeta_of
from chips.rolls.tables import Built, build_tables, spikes_a_step
from chips.rolls.validity import cautions_of, check_box, check_supply, check_temperature_of, restless_cautions
from circuits.arrays import F32, F64, I64, Bools
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.course import told_when
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon

Temperature = float | Callable[[float], float]

STEP = 0.4e-3  # s, ours
ROOM = 1 << 16  # spikes that one call of the kernel writes
LOOK = 10e-3  # s, ours: how often a temperature that changes is looked at
WHOLE = 1e-3  # of a step: by how much a run's duration may miss whole steps
KEPT = 4  # temperatures whose tables are kept, 15 MiB each
TEMPERATURE_STEP = 0.25  # K, ours: in which a temperature that changes is followed; tables take 0.8 s each


@dataclass(frozen=True, slots=True)
class Inputs:
    """Events for the chip.

    Attributes
    ----------
    times : array
        Times, float64[m], s, rising.
    neurons : array
        Neuron of each event, int64[m].
    columns : array
        Column of its synapse, int64[m]: 256 to 511 for non-plastic synapses, 512 to 519 for virtual ones, 0
        to 255 for plastic ones.
    """

    times: F64
    neurons: I64
    columns: I64


_KERNEL_COLUMN: I64 = np.concatenate(  # as the kernel counts them: 0 to 7 virtual ones, then non-plastic ones
    (np.arange(VIRTUAL_EXCITATORY) - NONPLASTIC + 2 * VIRTUAL_LINES, np.arange(2 * VIRTUAL_LINES))
)
NO_INPUTS = Inputs(np.empty(0), np.empty(0, np.int64), np.empty(0, np.int64))


@dataclass(frozen=True, slots=True)
class ChipState:
    """State of a chip between runs.

    time: s; values: rows of `chips.rolls.layout` for each neuron, float64[16, 256]; senders: neurons that
    spiked in the last step; temperature_c: degC; waiting: inputs that have not been taken yet; plastic,
    depression: state of the parts that a program may add.
    """

    time: float
    values: F64
    senders: I64
    temperature_c: float
    waiting: Inputs = NO_INPUTS
    plastic: PlasticState | None = None
    depression: DepressionState | None = None


@dataclass(frozen=True, slots=True)
class Spikes:
    """What a chip has sent.

    times: times at which spikes left the bus, float64[m], s. neurons: neuron of each spike, int64[m].
    lost_in, lost_out: how many events the bus dropped on the way in and out. held: filters times steps in
    which so much charge came that a filter stayed at the end of its table.
    """

    times: F64
    neurons: I64
    lost_in: int = 0
    lost_out: int = 0
    held: int = 0


class RollsChip:
    """A ROLLS chip with a program, on a silicon.

    A run's temperature is followed in steps of 0.25 K.

    Parameters
    ----------
    program
        What is written to the chip.
    silicon
        Process, temperature and die; the nominal die of its process unless given.
    kind
        Kind of all biases.
    params
        Sizes of its circuits; the usual ones unless given.
    step
        Step of time, s; neurons that are faster take it in parts.
    bus
        Bus of events out and in, which is idle as a run begins.
    noise
        Noise of its devices; none unless given (`chips.rolls.noise.model`).
    learning
        Sizes of the plastic array; the usual ones unless given.

    Raises
    ------
    ParameterError
        The step is not above 0, or `learning` is given without a plastic array.
    """

    def __init__(
        self, program: Program, silicon: Silicon | None = None, kind: BiasKind = "generator",
        params: Params | None = None, step: float = STEP, bus: Bus | None = None,
        noise: SiliconNoise | None = None, learning: Learning | None = None,
    ) -> None:  # fmt: skip
        """Raise `ParameterError` for a step not above 0, and for `learning` without a plastic array."""
        if not step > 0.0:
            raise ParameterError(f"chip.step: {step:g} s, must be > 0; give 0.2 or 0.4 ms")
        self.program, self.kind, self.step, self.noise = program, kind, step, noise
        self.silicon = Silicon(ROLLS_180) if silicon is None else silicon
        self.params = Params(virtual=program.virtual) if params is None else params
        self.bus = Bus() if bus is None else bus
        if learning is not None and program.plastic is None:
            raise ParameterError("chip.learning: given, must have a plastic array; give the program one")
        self.learning = Learning() if learning is None else learning
        self._built: dict[float, Built] = {}
        self._size = NEURONS
        self._firsts: F32 | None = None
        self._new_scratch()

    def _new_scratch(self) -> None:
        n = self._size
        self._scratch, self._plastic_scratch = new_scratch(n), scratch_of(new_scratch(n))
        self._part_scratch, self._part_state_scratch = new_scratch(n), np.zeros((STATE_ROWS, n))

    def __getstate__(self) -> dict[str, Any]:
        # working space has views of itself, which a pickle would take apart
        return {name: value for name, value in vars(self).items() if "scratch" not in name}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._new_scratch()

    def built(self, temperature_c: float | None = None) -> Built:
        """Return the chip's tables at `temperature_c` (degC), its silicon's unless given; a few are kept.

        Raises `ParameterError` for a chip of its first neurons at another temperature than its silicon's.
        """
        at = self.silicon.temperature_c if temperature_c is None else temperature_c
        if at not in self._built:
            if self._size < NEURONS:
                raise ParameterError(
                    f"chip: its first {self._size} neurons at {at:g} degC, must be whole there"
                )
            on = replace(self.silicon, temperature_c=at)
            while len(self._built) >= KEPT:
                self._built.pop(next(iter(self._built)))
            built = build_tables(self.params, self.program, self.kind, on, self.step)
            if self.program.plastic is not None:
                found = build_plastic(
                    self.params, self.learning, self.program, self.kind, on, self.step, built.tables.membranes
                )
                built = replace(built, plastic=found)
            built = with_noise(built, self.params, self.program, self.kind, on, self.noise)
            self._built[at] = with_depression(built, self.params, self.program, self.kind, on, self.noise)
        return self._built[at]

    def with_tables(self, built: Built) -> RollsChip:
        """Return the chip with the tables `built` at its silicon's temperature.

        They may be those of a group of its devices alone.
        """
        other = RollsChip(
            self.program, self.silicon, self.kind, self.params, self.step, self.bus, self.noise,
            None if self.program.plastic is None else self.learning,
        )  # fmt: skip
        other._built[self.silicon.temperature_c] = built
        return other

    def in_trial(self, trial: int) -> RollsChip:
        """Return the chip with the noise of `trial`, and the same tables; itself where it has none.

        Raises `ParameterError` for a trial below 0.
        """
        if self.noise is None:
            return self
        noise = replace(self.noise, trial=trial)
        drawn = {at: drawn_anew(built, self.silicon, noise) for at, built in self._built.items()}
        return self._altered(noise=noise, _built=drawn)

    def _altered(self, **given: Any) -> RollsChip:
        other = object.__new__(RollsChip)
        other.__setstate__({**self.__getstate__(), **given})
        return other

    def of_first(self, neurons: int, state: ChipState) -> tuple[RollsChip, ChipState]:
        """Return the chip and its state without what is behind its first neurons, where that changes nothing.

        Parameters
        ----------
        neurons
            Of how many the spikes are asked for, and events come to; some more stay.
        state
            At rest, at the silicon's temperature, at which alone what is returned runs. Where others excite
            or inhibit these neurons, or the bus might lose spikes, chip and state are returned as they are.
        """
        size, at = fewest(neurons), self.silicon.temperature_c
        if size >= self._size or not stands_alone(self.built(), size, self.bus):
            return self, state
        own = self._altered(_size=size, _firsts=None, _built={at: narrowed(self.built(), size)})
        return own, replace(state, values=state.values[:, :size].copy())

    def run_encoded(self, state: ChipState, encoded: Encoded) -> Spikes | None:
        """Return the spikes from rest on, None where what runs has to know each event's own time.

        state: at rest; encoded: events after the bus, for so many steps as are run.
        """
        if self.program.plastic is not None or self.program.depression is not None:
            return None
        none = np.empty(0), np.empty(0, np.int64), np.empty(0, np.int64)
        steps, values = encoded.many.shape[0], state.values.copy()
        built = self.built()
        if self._firsts is None:
            self._firsts = firsts_of(built.tables.virtual)
        summed = Summed(encoded.tokens, encoded.many, self._firsts)
        t = self._call(built, values, state.senders, steps, 0.0, none, (None, None, summed))
        if t.counts[DONE] < steps:
            self._new_scratch()  # charges are left in it
            return None
        written = t.counts[WRITTEN]
        out = send(self.bus, t.sent[:written], t.senders[:written])
        return Spikes(out.times, out.addresses, encoded.dropped, out.dropped, int(t.counts[HELD]))

    def cautions(self) -> tuple[str, ...]:
        """Return, in sentences, where the chip does not rest, or its step was not measured."""
        found, plastic = cautions_of(self.built(), self.step), self.built().plastic
        found = restless_cautions(self.restless()) + found
        found += depression_cautions(self.program, self.built().depression, self.built().levels, self.step)
        return found if plastic is None else found + plastic_cautions(self.program.biases, plastic)

    def at_rest(self) -> ChipState:
        """Return the state without input; a neuron that has no rest begins at 0 V.

        Raises `ParameterError` outside the box of its model (`chips.rolls.validity`), and for a chip of its
        first neurons.
        """
        if self._size < NEURONS:
            raise ParameterError(
                f"chip.at_rest: its first {self._size} neurons, must be whole; of_first has it"
            )
        check_supply(self.silicon.process)
        check_temperature_of(self.program, self.silicon.temperature_c)  # before tables are built in vain
        built = self.built()
        check_box(built)
        values = np.zeros((STATE_ROWS, NEURONS))
        rest_filters(values, built, built.tables.banks, self.step)
        resting = np.zeros((NEURONS, 3))
        rest_of(built.neurons, resting)
        values[V_AHP] = resting[:, 1]
        values[SHUT] = NEVER
        restless = resting[:, 0] >= built.neurons.top
        values[ZETA] = zeta_of(built, np.where(restless, 0.0, resting[:, 0]))
        spent = None if built.depression is None else rest_of_depression(built.depression)
        state = ChipState(0.0, values, np.empty(0, np.int64), self.silicon.temperature_c, depression=spent)
        if self.program.plastic is None or built.plastic is None:
            return state
        return replace(state, plastic=rest_of_plastic(built.plastic, self.program.plastic.start(), self.step))

    def carried(self, state: ChipState, before: RollsChip) -> ChipState:
        """Return `state` of the chip `before` as it goes on with this one's biases: all voltages stay.

        Raises `ParameterError` outside the box of its model.
        """
        at = state.temperature_c
        check_temperature_of(self.program, at)
        old, new = before.built(at), self.built(at)
        check_box(new)
        spent = depressing_of(old.depression, state.depression)
        spent = converted_depression(old.depression, new.depression, spent, round(state.time / self.step))
        plastic, kept = before._array(state, np.empty(0), np.empty(0, np.int64)), state.plastic
        if plastic is not None and old.plastic is not None and new.plastic is not None:
            kept = state_of(convert(old.plastic, new.plastic, plastic).arrays)
        values = converted(state.values, old, new)
        return replace(state, values=values, plastic=kept, depression=depression_state(spent))

    def weights(self, state: ChipState) -> Bools:
        """Return whether each plastic weight is high in `state`, bool[post, pre].

        Raises `ParameterError` for a chip without a plastic array.
        """
        return bits_of(*self._plastic(state))

    def weight_voltages(self, state: ChipState) -> F32:
        """Return the voltages of the plastic weights in `state`, V, float32[post, pre].

        Raises `ParameterError` for a chip without a plastic array.
        """
        return voltages(*self._plastic(state))

    def _plastic(self, state: ChipState) -> tuple[BuiltPlastic, PlasticState]:
        built = self.built(state.temperature_c).plastic
        if built is None or state.plastic is None:
            raise ParameterError("chip.weights: none, must have a plastic array; give the program one")
        return built, state.plastic

    def restless(self) -> Bools:
        """Return which neurons fire without input, bool[256]."""
        resting = np.zeros((NEURONS, 3))
        rest_of(self.built().neurons, resting)
        return np.asarray(resting[:, 0] >= self.built().neurons.top)

    def run(
        self,
        state: ChipState,
        duration: float,
        inputs: Inputs = NO_INPUTS,
        temperature: Temperature | None = None,
    ) -> tuple[Spikes, ChipState]:
        """Run for `duration` s, and return the spikes and the state.

        Raises `ParameterError` for a duration that is not of whole steps, and for inputs that the chip
        does not have or from before the state.

        Parameters
        ----------
        inputs
            Events, in absolute time.
        temperature
            Temperature of the chip, degC, or a function of time (s); the silicon's unless given.
        """
        if (state.plastic is None) != (self.program.plastic is None):
            raise ParameterError(
                "chip.run.state: of a chip with another array, must be of this one; use at_rest"
            )
        check_inputs(inputs.times, inputs.neurons, inputs.columns, state.time, self.program)
        if self._size < NEURONS and inputs.neurons.max(initial=0) >= self._size:
            raise ParameterError(
                f"chip.inputs: neuron {inputs.neurons.max()}, must be of the first {self._size}"
            )
        arrived = send(self.bus, inputs.times, inputs.neurons + (inputs.columns << 8))
        steps = round(duration / self.step)
        if not abs(duration - steps * self.step) < WHOLE * self.step:
            raise ParameterError(
                f"chip.run.duration: {duration:g} s, must be whole steps of {self.step:g} s; round it, or"
                " give the chip another step"
            )
        times, neurons, state, held = self.run_steps(state, steps, arrived, temperature)
        out = send(self.bus, times, neurons)
        return Spikes(out.times, out.addresses, arrived.dropped, out.dropped, held), state

    def synaptic_currents(self) -> tuple[F64, F64]:
        """Return what flowed into i_in and was drawn from v_mem in the last step, A, float64[256] each."""
        return self._scratch.excite.astype(np.float64), self._scratch.inhibit.astype(np.float64)

    def run_steps(
        self, state: ChipState, steps: int, arrived: Events, temperature: Temperature | None = None
    ) -> tuple[F64, I64, ChipState, int]:
        """Run a number of steps with events that have come in over the bus.

        Parameters
        ----------
        state
            State of the chip.
        steps
            How many steps are run.
        arrived
            Events, addressed as `neuron + (column << 8)`.
        temperature
            Temperature of the chip, degC, or a function of time (s), as a course's `at`; the silicon's
            unless given.

        Returns
        -------
        Times (s, float64[m]) and neurons (int64[m]) of the spikes before they go out over the bus, the new
        state, and `Spikes.held`.
        """
        times, words = _in_turn(state.waiting, arrived)
        found: list[tuple[F64, I64]] = []
        values, senders, now = state.values.copy(), state.senders, state.time
        at, done, cursor, held = state.temperature_c, 0, 0, 0
        mine, learns = _by_array(words)
        events = times[mine], _KERNEL_COLUMN[words[mine] >> 8], words[mine] & 255
        plastic = self._array(state, times[learns], words[learns])
        depressing = depressing_of(self.built(at).depression, state.depression)
        while done < steps:
            wanted = self._temperature(temperature, now)
            if wanted != at:
                with told_when(now) if callable(temperature) else nullcontext():
                    check_temperature_of(self.program, wanted)
                    old, new = self.built(at), self.built(wanted)
                    check_box(new)
                values, at = converted(values, old, new), wanted
                depressing = converted_depression(
                    old.depression, new.depression, depressing, round(now / self.step)
                )
                if plastic is not None and old.plastic is not None and new.plastic is not None:
                    plastic = convert(old.plastic, new.plastic, plastic)
            length = steps - done
            if callable(temperature):
                length = min(length, max(round(LOOK / self.step), 1))
            built = self.built(at)
            left = events[0][cursor:], events[1][cursor:], events[2][cursor:]
            out = self._call(built, values, senders, length, now, left, (plastic, depressing, None))
            written = out.counts[WRITTEN]
            found.append((out.sent[:written], out.senders[:written]))
            senders = out.last[: out.counts[LAST]]
            cursor += int(out.counts[READ])
            done += int(out.counts[DONE])
            held += int(out.counts[HELD])
            now = state.time + done * self.step
        late, kept = _numbers(mine, times.size, cursor), None
        if plastic is not None:
            read = int(plastic.arrays.read[0])
            late = np.sort(np.concatenate((late, _numbers(learns, times.size, read))))
            kept, held = state_of(plastic.arrays), held + int(plastic.arrays.held[0])
        waiting = Inputs(times[late], words[late] & 255, words[late] >> 8)
        after = ChipState(now, values, senders, at, waiting, kept, depression_state(depressing))
        if not found:
            return np.empty(0), np.empty(0, np.int64), after, held
        times = np.concatenate([t for t, _ in found])
        return times, np.concatenate([a for _, a in found]), after, held

    def _array(self, state: ChipState, times: F64, words: I64) -> Plastic | None:
        """The plastic array for the kernel, and its events."""
        built = self.built(state.temperature_c).plastic
        if built is None or state.plastic is None:
            return None
        events = PlasticEvents(times, words >> 8, words & 255)
        return Plastic(built.tables, arrays_of(state.plastic), events, self._plastic_scratch)

    def _temperature(self, temperature: Temperature | None, now: float) -> float:
        if temperature is None:
            return self.silicon.temperature_c
        if callable(temperature):
            return TEMPERATURE_STEP * round(temperature(now) / TEMPERATURE_STEP)
        return temperature

    def _call(
        self, built: Built, values: F64, senders: I64, steps: int, now: float,
        events: tuple[F64, I64, I64],
        beside: tuple[Plastic | None, Depressing | None, Summed | None],
    ) -> Traffic:  # fmt: skip
        tables = built.tables
        most = spikes_a_step(tables)
        room = max(ROOM, 2 * max(most * NEURONS, senders.size))
        # those of a step at another temperature may be more than a step has at this one
        last = np.zeros(max(most * NEURONS, senders.size), np.int64)
        counts = np.zeros(COUNTS, np.int64)
        last[: senders.size], counts[LAST] = senders, senders.size
        traffic = Traffic(*events, np.empty(room), np.empty(room, np.int64), last, counts)
        run = ChipRun(
            tables, values, values[ZETA].view(np.int64), traffic, self._scratch, self._part_state_scratch,
            self._part_scratch,
        )  # fmt: skip
        plastic, depressing, encoded = beside
        run_chip(run, steps, now, plastic, built.noise, depressing, encoded)
        return traffic


def _by_array(words: I64) -> tuple[Bools | slice, Bools | slice]:
    """Which events are not of plastic synapses, and which are; slices, which make views, where none is."""
    if words.min(initial=NEURONS << 8) >= NEURONS << 8:
        return slice(None), slice(0)
    learns = words >> 8 < NEURONS
    return ~learns, learns


def _numbers(which: Bools | slice, size: int, begin: int) -> I64:
    """Numbers of some of `size` events, without the first ones of them."""
    if isinstance(which, slice):
        return np.arange(begin, which.indices(size)[1])
    return np.flatnonzero(which)[begin:]


def _in_turn(waiting: Inputs, arrived: Events) -> tuple[F64, I64]:
    """Times and words of events that wait and of those that have arrived, both in order."""
    if not waiting.times.size:
        return arrived.times, arrived.addresses
    times = np.concatenate((waiting.times, arrived.times))
    words = np.concatenate((waiting.neurons + (waiting.columns << 8), arrived.addresses))
    order = np.argsort(times, kind="stable")
    return times[order], words[order]
