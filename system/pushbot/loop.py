"""The closed loop of the Pushbot: sensor, chip, commands, robot, sensor (Milde et al. 2017, section 2).

    loop = open_loop(brain, drive, readout)
    while loop.drive.touched is None and loop.drive.time < 8.0:
        step(loop)                          one look: events in, spikes out, a command where one is due

Sensor and chip go on in turn for a look. Events reach the chip at the times at which they arrive over the
link, so chip and robot only wait for one another where a command leaves. The chip's time begins _KICK_TIME
before the robot's: it is started by a pulse to exc, while the robot stands.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from chips.rolls.chip import NO_INPUTS, ChipState, Inputs, RollsChip, Spikes
from chips.rolls.program.network import Network
from circuits.arrays import F64, I64
from system.pushbot.drive import Readings, Run, go_on, pull, steer
from system.pushbot.frame import Frame
from system.pushbot.readout import LOOK, OUTPUTS, Counter, Readout, read
from system.pushbot.wiring import COLUMNS, HALF_ROWS, Wiring, kick, merged, obstacle_inputs, target_inputs
from system.worlds.camera.event import Events, joined

Command = tuple[float, float]
Temperature = Callable[[float], float] | float | None

Turning = Callable[[Readings, float, float], Inputs]

_KICK_TIME = 0.1  # s, that the chip runs before the robot; ours
BESIDE, LEAST = 4.0, 15  # columns beside a bump, and events of a look in these that show a target; ours


@dataclass(frozen=True, slots=True, eq=False)
class Brain:
    """A chip with the network on it, and how the sensor is wired to it.

    Attributes
    ----------
    network : Network
        Populations of neurons, and what connects them and reaches them.
    chip : RollsChip
        The chip with the network on it.
    target : bool
        Whether the upper half of the sensor reaches the target field.
    synapses : int
        How many virtual synapses an event of the target reaches.
    turning : callable or None
        Makes further inputs of the readings between two times (s): those of the gyro, in the modified
        architecture. None for none.
    strong : RollsChip or None
        The chip with raised lateral weights in its field, which runs while the target is lost from
        view.
    frame : callable or None
        Makes a second chip, which hears the field and drives.
    wiring : Wiring
        Which virtual synapses an event of the sensor stimulates.
    """

    network: Network
    chip: RollsChip
    wiring: Wiring = "plain"
    target: bool = False
    synapses: int = 4
    turning: Callable[[], Turning] | None = None
    strong: RollsChip | None = None
    frame: Callable[[], Frame] | None = None


@dataclass(slots=True, eq=False)
class Record:
    """What a loop keeps: spikes (s of the robot's time, neurons), events, commands, counts of loss.

    held: filters times steps in which a filter of the chip stayed at the end of its table; raised: s with
    raised lateral weights; frame_spikes: of a second chip.

    inputs : events that the chip was given.
    lost_in : events that its bus lost.
    lost_out : spikes that its bus lost.
    """

    times: list[F64] = field(default_factory=list)
    neurons: list[I64] = field(default_factory=list)
    events: list[Events] = field(default_factory=list)
    commands: list[tuple[float, float, float]] = field(default_factory=list)
    inputs: int = 0
    lost_in: int = 0
    lost_out: int = 0
    held: int = 0
    raised: float = 0.0
    frame_spikes: int = 0


@dataclass(slots=True, eq=False)
class Loop:
    """State of a closed loop; `temperature` of the chip (degC), or a function of the robot's time.

    brain : chip and network.
    drive : robot and sensor.
    readout : how spikes become commands.
    state : of the chip.
    groups : of each neuron, its number in `OUTPUTS`, -1 for none, int64[256].
    sizes : neurons of each of `OUTPUTS`, float64[3].
    turning : makes inputs of the gyro's readings; None for none.
    frame : the second chip; None without one.
    heard : inputs by the second chip that wait for the next look.
    lost : whether the target is lost from view.
    counter : of spikes in the window so far.
    record : of what has happened.
    """

    brain: Brain
    drive: Run
    readout: Readout
    state: ChipState
    groups: I64
    sizes: F64
    temperature: Temperature = None
    turning: Turning | None = None
    frame: Frame | None = None
    heard: Inputs = NO_INPUTS
    lost: bool = False
    counter: Counter = field(default_factory=Counter)
    record: Record = field(default_factory=Record)


def open_loop(brain: Brain, drive: Run, readout: Readout, temperature: Temperature = None) -> Loop:
    """Return a loop with the robot at its start, and exc running.

    Parameters
    ----------
    brain
        Chip and network.
    drive
        Robot and sensor at their start (`begin_run`).
    readout
        How spikes become commands.
    temperature
        Temperature of the chip, degC, or a function of the robot's time (s); the chip's own unless given.
    """
    groups = np.full(256, -1, dtype=np.int64)
    for k, name in enumerate(OUTPUTS):
        groups[list(brain.network[name].neurons)] = k
    sizes = np.array([len(brain.network[name]) for name in OUTPUTS], dtype=np.float64)
    turning = None if brain.turning is None else brain.turning()
    loop = Loop(brain, drive, readout, brain.chip.at_rest(), groups, sizes, temperature, turning)
    _, loop.state = brain.chip.run(
        loop.state, _KICK_TIME, kick(brain.network, brain.synapses), _at(loop, 0.0)
    )
    if brain.frame is not None:
        loop.frame = brain.frame()
        _, loop.frame.state = loop.frame.chip.run(loop.frame.state, _KICK_TIME, temperature=_at(loop, 0.0))
    return loop


def step(loop: Loop) -> None:
    """Go on with `loop` by one look, or by less where the robot touches something."""
    before = loop.drive.time
    command = think(loop, go_on(loop.drive, loop.readout.look), before)
    if command is not None and loop.drive.touched is None:
        command_with(loop, command)


def command_with(loop: Loop, command: Command) -> None:
    """Send what the chip commands, v (cm/s) and w of the robot's code, as the loop's readout does."""
    (pull if loop.readout.kind == "spikes" else steer)(loop.drive, *command)
    loop.record.commands.append((loop.drive.time, *command))


def think(loop: Loop, readings: Readings, before: float) -> Command | None:
    """Let the chip go on by one look with what was read from `before` (s) on.

    Returns its command, v (cm/s) and w of the robot's code, or None where none is due.
    """
    look = loop.readout.look
    inputs = _inputs(loop, readings, before)
    strong = loop.brain.strong if loop.lost else None
    chip = loop.brain.chip if strong is None else strong
    loop.record.raised += 0.0 if strong is None else look
    spikes, loop.state = chip.run(loop.state, look, inputs, _at(loop, before))
    _keep(loop, readings, inputs, spikes)
    loop.lost = loop.brain.strong is not None and is_lost(loop.brain.network, readings.events, spikes)
    if loop.frame is not None:
        loop.frame.follow(readings, before, loop.drive.time)
        found = loop.frame.look(spikes, look, _at(loop, before))
        loop.record.frame_spikes = loop.frame.spikes
        loop.heard = replace(found, times=found.times + look)
    chosen = loop.groups[spikes.neurons]
    counts = np.bincount(chosen[chosen >= 0], minlength=len(OUTPUTS)) / loop.sizes
    return read(loop.readout, loop.counter, counts)


def _inputs(loop: Loop, readings: Readings, before: float) -> Inputs:
    """Inputs of the chip from a stretch of readings, in the chip's time."""
    brain = loop.brain
    parts = [obstacle_inputs(brain.network, readings.events, brain.wiring, brain.synapses)]
    if brain.target:
        parts.append(target_inputs(brain.network, readings.events, brain.synapses))
    if loop.turning is not None:
        parts.append(loop.turning(readings, before, loop.drive.time))
    # in the chip's time, which is _KICK_TIME later
    parts.append(replace(loop.heard, times=loop.heard.times - _KICK_TIME))
    found = merged(parts)
    # an event of the very end of the last look may be a rounding before the chip's time
    return replace(found, times=np.maximum(found.times + _KICK_TIME, loop.state.time))


def is_lost(network: Network, events: Events, spikes: Spikes) -> bool:
    """Whether few events come from where the target field has its bump, or it has none."""
    neurons = np.array(network["target"].neurons)
    mine = spikes.neurons[np.isin(spikes.neurons, neurons)]
    if mine.size == 0:
        return True
    column = (np.median(mine) - neurons[0] + 0.5) * COLUMNS / neurons.size
    upper = events.where(events.y >= HALF_ROWS)
    return int((np.abs(upper.x + 0.5 - column) <= BESIDE).sum()) < LEAST


def _at(loop: Loop, time: float) -> float | None:
    """Temperature of the chip from `time` of the robot on, degC."""
    return loop.temperature(time) if callable(loop.temperature) else loop.temperature


def _keep(loop: Loop, readings: Readings, inputs: Inputs, spikes: Spikes) -> None:
    record = loop.record
    record.times.append(spikes.times - _KICK_TIME)
    record.neurons.append(spikes.neurons)
    record.events.append(readings.events)
    record.inputs += inputs.times.size
    record.lost_in += spikes.lost_in
    record.lost_out += spikes.lost_out
    record.held += spikes.held


def all_spikes(record: Record) -> tuple[F64, I64]:
    """Return times (s) and neurons of all spikes."""
    if not record.times:
        return np.empty(0), np.empty(0, dtype=np.int64)
    return np.concatenate(record.times), np.concatenate(record.neurons)


def all_events(record: Record) -> Events:
    """Return all events that reached the chip's side of the link."""
    return joined(record.events)


def rates(network: Network, record: Record, stop: float, bins: float = LOOK) -> tuple[F64, dict[str, F64]]:
    """Mean rate of every population over time.

    It returns the ends of the bins, float64[bins], s, and the rates by population, float64[bins], Hz.

    Parameters
    ----------
    network
        Network of the chip.
    record
        What the loop has kept.
    stop
        Time up to which rates are taken, s.
    bins
        Length of a bin, s.
    """
    edges = bins * np.arange(round(stop / bins) + 1)
    times, neurons = all_spikes(record)
    found = {}
    for population in network.populations:
        mine = times[np.isin(neurons, population.neurons)]
        found[population.name] = np.histogram(mine, edges)[0] / (bins * len(population))
    return np.asarray(edges[1:], dtype=np.float64), found
