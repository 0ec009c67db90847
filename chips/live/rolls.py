"""A ROLLS chip that is driven live; it takes whole steps, as `chips.rolls.part` has them.

Inputs are addresses of synapses, `neuron + (column << 8)`: plastic ones first, then non-plastic, then virtual
ones. Outputs are the numbers of neurons. A spike is told once it has left the bus.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from chips.aer import IDLE, send_on
from chips.live.chip import Addresses, Train, within
from chips.noise import SiliconNoise
from chips.rolls.calibration import code_for
from chips.rolls.chip import STEP, ChipState, RollsChip
from chips.rolls.input_check import check_inputs
from chips.rolls.program.address import NEURONS, NONPLASTIC, VIRTUAL_EXCITATORY
from chips.rolls.program.program import Program
from circuits.arrays import F64, I64, Bools
from circuits.circuit import BiasKind
from circuits.errors import ParameterError, unknown_name
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon

_CLOSE = 1e-9  # of a step, by which its end may be missed


def nothing() -> Train:
    """Return a train without events."""
    return np.empty(0), np.empty(0, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class LiveRollsState:
    """State: of the chip after `steps` whole steps; events of the step that runs; spikes on their way.

    into, out : when what is on the buses is delivered, s; lost_in, lost_out, held : as of `Spikes`.
    """

    chip: ChipState
    steps: int = 0
    waiting: Train = field(default_factory=nothing)
    due: Train = field(default_factory=nothing)
    into: F64 = field(default_factory=lambda: IDLE)
    out: F64 = field(default_factory=lambda: IDLE)
    lost_in: int = 0
    lost_out: int = 0
    held: int = 0


@dataclass(frozen=True)
class RollsEngine:
    """A ROLLS chip at its silicon's temperature.

    chip : the chip; own : gives events that reach it besides those that are sent, such as a clock's, from a
    time until another, s; None for none.
    """

    chip: RollsChip
    own: Callable[[float, float], Train] | None = None

    @property
    def inputs(self) -> tuple[Addresses, ...]:
        """Its synapses."""
        program, columns = self.chip.program, self.chip.program.virtual.columns
        excite, inhibit = columns(inhibitory=False), columns(inhibitory=True)
        signs = {each.inhibitory for each in program.inputs}
        return (
            Addresses("plastic", 0, 0 if program.plastic is None else NONPLASTIC * NEURONS),
            Addresses("synapse", NONPLASTIC * NEURONS, (VIRTUAL_EXCITATORY - NONPLASTIC) * NEURONS),
            Addresses("excite", excite.start * NEURONS, len(excite) * NEURONS * (False in signs)),
            Addresses("inhibit", inhibit.start * NEURONS, len(inhibit) * NEURONS * (True in signs)),
        )

    @property
    def outputs(self) -> tuple[Addresses, ...]:
        """Its neurons."""
        return (Addresses("neuron", 0, NEURONS),)

    @property
    def lines(self) -> Mapping[str, int]:
        """It has no analog inputs."""
        return {}

    def takes(self, addresses: I64) -> Bools:
        """Return whether each is an address of its synapses, and latched where it is plastic."""
        known, plastic = within(self.inputs, addresses), self.chip.program.plastic
        if plastic is not None:
            mine = known & (addresses < NONPLASTIC * NEURONS)
            known[mine] = plastic.latches[addresses[mine] & 255, addresses[mine] >> 8]
        return known

    def begin(self) -> LiveRollsState:
        """Return the state at rest."""
        return LiveRollsState(self.chip.at_rest())

    def go_on(
        self, state: LiveRollsState, now: float, until: float, train: Train
    ) -> tuple[LiveRollsState, Train]:
        """Run the whole steps up to `until`, s; what left the bus by then."""
        if self.own is not None:
            train = _in_order(_joined(train, self.own(now, until)))
        check_inputs(train[0], train[1] & 255, train[1] >> 8, now, self.chip.program)
        waiting = _joined(state.waiting, train)
        whole = int(np.floor(until / self.chip.step + _CLOSE)) - state.steps
        state = replace(state, waiting=waiting)
        if whole > 0:
            state = self._stepped(state, whole)
        times, neurons = state.due
        gone = times <= until
        return replace(state, due=(times[~gone], neurons[~gone])), (times[gone], neurons[gone])

    def counts(self, state: LiveRollsState) -> Mapping[str, int]:
        """Return what its buses lost, and how often a filter stayed at the end of its table."""
        return {"lost_in": state.lost_in, "lost_out": state.lost_out, "held": state.held}

    def biases(self) -> Mapping[str, float]:
        """Return its biases by name, A at 27 degC."""
        table = self.chip.program.biases
        return {name: table.current(name) for name in table.codes()}

    def with_bias(self, state: LiveRollsState, name: str, value: float) -> tuple[RollsEngine, LiveRollsState]:
        """Write the code whose current is nearest, A; voltages stay."""
        if not value > 0.0:
            raise ParameterError(f"rolls.{name}: {value:g} A, must be above 0; a bias is a current")
        program = self.chip.program
        other = replace(program, biases=program.biases.with_code(name, *code_for(value)))
        return self._carried(state, other, self.chip.silicon)

    def at(self, state: LiveRollsState, temperature_c: float) -> tuple[RollsEngine, LiveRollsState]:
        """Go on at another temperature, degC; voltages stay from the next step on."""
        silicon = replace(self.chip.silicon, temperature_c=temperature_c)
        other = replace(self, chip=self._with(self.chip.program, silicon))
        other.chip.at_rest()  # refuses what is outside of the box
        return other, state

    def drive(self, state: LiveRollsState, line: str, values: F64) -> LiveRollsState:
        """It has no analog inputs."""
        raise unknown_name("rolls line", line, [])

    def show(self, state: LiveRollsState) -> Mapping[str, F64]:
        """It has no analog outputs."""
        return {}

    def _with(self, program: Program, silicon: Silicon) -> RollsChip:
        c = self.chip
        learning = None if program.plastic is None else c.learning
        return RollsChip(program, silicon, c.kind, c.params, c.step, c.bus, c.noise, learning)

    def _carried(
        self, state: LiveRollsState, program: Program, silicon: Silicon
    ) -> tuple[RollsEngine, LiveRollsState]:
        other = self._with(program, silicon)
        return replace(self, chip=other), replace(state, chip=other.carried(state.chip, self.chip))

    def _stepped(self, state: LiveRollsState, steps: int) -> LiveRollsState:
        """The state after some more steps."""
        chip = self.chip
        end = (state.steps + steps) * chip.step
        times, words = state.waiting
        mine = times < end
        arrived, into = send_on(chip.bus, state.into, times[mine], words[mine])
        begun = replace(state.chip, time=state.steps * chip.step)
        spiked, neurons, after, held = chip.run_steps(begun, steps, arrived)
        left, out = send_on(chip.bus, state.out, spiked, neurons)
        return LiveRollsState(
            after, state.steps + steps, (times[~mine], words[~mine]),
            _joined(state.due, (left.times, left.addresses)), into, out,
            state.lost_in + arrived.dropped, state.lost_out + left.dropped, state.held + held,
        )  # fmt: skip


def open_rolls(
    silicon: Silicon | None, program: Program, bias_kind: BiasKind = "generator", *, step: float = STEP,
    noise: SiliconNoise | None = None, own: Callable[[float, float], Train] | None = None,
) -> RollsEngine:  # fmt: skip
    """Return a ROLLS chip with a program; the parameters are those of `RollsChip` and of `RollsEngine`."""
    chip = RollsChip(program, silicon or Silicon(ROLLS_180), bias_kind, step=step, noise=noise)
    return RollsEngine(chip, own)


def _joined(one: Train, other: Train) -> Train:
    return np.concatenate([one[0], other[0]]), np.concatenate([one[1], other[1]])


def _in_order(train: Train) -> Train:
    order = np.argsort(train[0], kind="stable")
    return train[0][order], train[1][order]
