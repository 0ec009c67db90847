"""A sonar that goes on by 10 ms (`system.live.robot`).

An action is the proximity voltage, which steers rate and amplitude of the calls in the place of the centroid
board. What it senses are the spikes of the range-tuned neurons and of the hearing in the last 10 ms. The
reward is less by the error (m) of the range that the action's voltage stands for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chips.part import Analog, Event, Output, Part, Unforeseen
from chips.ranging import circuit as ranging_chip
from chips.ranging.calibration.found import off_of
from circuits.arrays import F64, I64
from circuits.devices.source import Polyline
from circuits.silicon.process import AMI_1500
from system.approach.log import GRID, Log, counts_of, note, trace_of
from system.approach.scenario import LONGEST, Scenario
from system.approach.trace import account, estimated_range
from system.live.signals import Channel, Signals, gathered
from system.loop import AnalogWire, Loop
from system.plot import COLOURS, PALE
from system.worlds.sound.targets import range_at

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HAND = "hand"  # part between the centroid board and the vocalization board
COUNTED = 10_000.0  # events in 10 ms, more than any neuron makes; ours
SENSES = Signals(
    (
        Channel("spikes of range-tuned neurons, nearest first", "", 0.0, COUNTED, (ranging_chip.NEURONS,)),
        Channel("calls that the chip heard", "", 0.0, COUNTED),
        Channel("echoes that the chip heard", "", 0.0, COUNTED),
        Channel("time since the last call", "s", 0.0, LONGEST),
        Channel("proximity voltage of the centroid board", "V", -AMI_1500.v_dd, 2.0 * AMI_1500.v_dd),
    )
)  # fmt: skip
ACTIONS = Signals((Channel("proximity voltage", "V", 0.0, AMI_1500.v_dd),))


@dataclass(frozen=True, slots=True)
class HandState:
    """State of a hand: time, s; line that comes in; voltage that is held instead, V, None for none."""

    time: float
    line: Polyline | None = None
    held: float | None = None


class Hand(Unforeseen):
    """A wire of a voltage that another can hold: a part between two others."""

    analog: tuple[str, ...] = ("proximity",)

    def begin(self, time: float = 0.0) -> HandState:
        """Return the state in which what comes in goes out."""
        return HandState(time)

    def advance(
        self, state: HandState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[HandState, float, Output]:
        """Advance to `until`, s, as `chips.part.Part` says."""
        line = (analog or {}).get("proximity", state.line)
        time, volts = np.array([state.time, until]), np.zeros(2)
        if state.held is not None:
            volts[:] = state.held
        elif line is not None:
            inner = line[0][(line[0] > state.time) & (line[0] < until)]
            time = np.concatenate([[state.time], inner, [until]])
            volts = np.interp(time, *line)
        return replace(state, time=until, line=line), until, Output((), time, volts[:, None])


def in_hand(loop: Loop) -> Loop:
    """Return a loop at rest whose proximity voltage goes through a hand."""
    parts: dict[str, Part[Any]] = {**loop.parts, HAND: Hand()}
    wires = [_through(wire) for wire in loop.analog]
    into = AnalogWire("centroid", "proximity", HAND, "proximity")
    made = Loop(parts, loop.events, [into, *wires], loop.horizon)
    made.states |= loop.states
    return made


def _through(wire: AnalogWire) -> AnalogWire:
    """A wire of the proximity voltage from the hand; others as they are."""
    if (wire.source, wire.target) != ("centroid", "vocalization"):
        return wire
    return replace(wire, source=HAND, tolerance=0.0)


@dataclass(frozen=True, slots=True)
class Heard:
    """What came in a step.

    spikes : time (s) and neuron; calls, echoes : that the chip heard, s.
    """

    spikes: tuple[tuple[float, int], ...]
    calls: tuple[float, ...]
    echoes: tuple[float, ...]


class LiveApproach:
    """A sonar that closes in on its target; `System.open` of the approach.

    scenario : what is asked for; loop : its parts at rest, with a hand.
    """

    senses, actions = SENSES, ACTIONS

    def __init__(self, scenario: Scenario, loop: Loop) -> None:
        self.scenario, self.loop, self.log = scenario, loop, Log()
        self._off = off_of(scenario.ranging_codes)
        self.reward, self.ended, self._steps = 0.0, "", 0
        self._seen = Heard((), (), ())
        self._wanted: float | None = None

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self.loop.time

    @property
    def place(self) -> tuple[float, float]:
        """Range of the target that is to be held, m, and 0."""
        return float(range_at(self.scenario.targets[0].trajectory, np.array([self.time]))[0]), 0.0

    @property
    def late(self) -> str:
        """Whether its time is over."""
        over = self.time >= self.scenario.duration
        return f"time of {self.scenario.duration:g} s over" if over else ""

    @property
    def succeeded(self) -> bool:
        """Whether it has held its target."""
        if not self.log.boards:
            return False
        trace = trace_of(self.scenario, self.log, np.array(self.log.boards), counts_of(self.loop))
        return account(trace).succeeded

    def readings(self) -> Heard:
        """Return spikes, calls and echoes of the last step, at their times."""
        return self._seen

    def sense(self) -> F64:
        """Return the observation, as `SENSES`."""
        seen, log = self._seen, self.log
        spikes: I64 = np.bincount(
            np.array([k for _, k in seen.spikes], dtype=np.int64), minlength=ranging_chip.NEURONS
        )
        since = self.time - (log.pulses[-1] if log.pulses else 0.0)
        return gathered(spikes, len(seen.calls), len(seen.echoes), since, self._proximity())

    def own(self) -> F64:
        """Return the voltage of the centroid board, within the bounds."""
        self._wanted = min(max(self._proximity(), 0.0), AMI_1500.v_dd)
        return np.array([self._wanted])

    def act(self, action: F64) -> None:
        """Hold the proximity voltage for 10 ms; at that of the centroid board it follows the board."""
        volts, wanted, self._wanted = float(action[0]), self._wanted, None
        held = None if volts == wanted else volts
        self.loop.states[HAND] = replace(self.loop.states[HAND], held=held)
        self._steps += 1
        began = len(self.log.spikes), len(self.log.pulses), len(self.log.echoes)
        end = min(self._steps * GRID, self.scenario.duration)
        while self.loop.time < end:
            note(self.log, self.loop.step(end), self._off)
        log = self.log
        spikes, pulses, echoes = log.spikes[began[0] :], log.pulses[began[1] :], log.echoes[began[2] :]
        self._seen = Heard(tuple(spikes), tuple(pulses), tuple(echoes))
        told = self._proximity() if held is None else held
        self.reward = -abs(float(estimated_range(np.array([told]), self.scenario)[0]) - self.place[0])

    def draw(self, ax: Axes) -> None:
        """Draw the range of the target, what the board's voltage stands for, and the calls."""
        boards = np.array([(0.0, self._proximity(), 0.0), *self.log.boards])
        ax.plot(boards[:, 0], range_at(self.scenario.targets[0].trajectory, boards[:, 0]), color=PALE, lw=3)
        ax.plot(boards[1:, 0], estimated_range(boards[1:, 1], self.scenario), color=COLOURS[0])
        ax.plot([time for time, _ in self.log.calls], np.zeros(len(self.log.calls)), "|", color=COLOURS[1])
        ax.set(xlabel="time (s)", ylabel="range (m)", xlim=(0.0, self.scenario.duration))

    def _proximity(self) -> float:
        return self.log.boards[-1][1] if self.log.boards else 0.0
