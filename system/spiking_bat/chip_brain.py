"""The brain of a bat on the latency chip: maps that send addresses, the chip, and motors that read them.

The maps are boards beside the chip: an echo's spike goes to every memory whose arc its place blocks, after
the delay of equation (7); places that two echoes share spike once, as a map's neuron does. The goal's and the
direction's charges are sent when the network's come. Of the chip's winners the first turns the head to its
group; those of a group that was pinged in within the last 109 ms turn the body, at the first one's spike.
A reset follows where the body turned, or the emergency neuron spiked, as with the network. Temperature may
change from ping to ping, and is that of the ping's begin until the next one, in steps of 0.1 K.

Ours: T_C is longer than the network's by `_EARLIER`, because the chip's units answer that much sooner.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import numpy as np

from chips.codes import Calibration
from chips.latency.calibration import NAME, Sized, calibrate
from chips.latency.chip import LatencyChip, PingResponse, counted
from chips.latency.design import Biases, Design
from chips.latency.kernel import Memory
from chips.latency.model import require_temperature, usual_biases
from circuits.arrays import F64, I64
from circuits.circuit import BiasKind
from circuits.silicon.course import Course, told_when
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.openspace.law import ARCS, DIRECTIONS, Arcs, Bat, arcs_of
from system.spiking_bat.brain import check_timing
from system.spiking_bat.maps import Blocking, blocking, echo_delay, nearest_place, places
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.topology import layer_delays, passive_current

_RECENT = 109e-3  # s, that a ping counts; the network's
_SHARED = (
    "taps", "integration", "race", "goal", "goal_sigma", "direction", "pulse", "suppression",
    "suppression_sigma", "emergency",
)  # fmt: skip  # numbers of the network that the chip has under the same names
EMERGENCY = ARCS  # address of the emergency neuron among the spikes, after the arcs
_EARLIER = 3.3e-3  # s, from the integrating neuron's spike to the memory's in the network; measured


@dataclass(frozen=True, slots=True)
class ChipReply:
    """What the motors do after a ping, as `system.spiking_bat.brain.Reply`, and the response of the chip.

    head : direction of the next ping, None to stay.
    arcs : whose motors turn the body, int64[n].
    turned : when the first of them did, s after the ping, or None.
    emergency : when its neuron spiked, s after the ping, or None.
    """

    head: int | None
    arcs: I64
    turned: float | None
    emergency: float | None
    response: PingResponse = field(repr=False)


@dataclass(slots=True)
class ChipBrain:
    """Maps, chip and motors as a brain; the time, and what was lost, are counted on from ping to ping.

    temperature: its course from the begin on, the chip's own throughout unless given.

    numbers : of the network, for times and rates.
    arcs : of the bat.
    memory : state of the chip.
    at : places of the map's neurons, float64[471, 2], m.
    targets : for each direction and place, the arcs that an obstacle there blocks and their delays, s.
    now : time of the next ping, s.
    pinged : time of the last ping in each direction, float64[DIRECTIONS], s.
    sent : of each ping, times (s) after the first one and addresses of the chip's spikes: the arc that won,
        or `EMERGENCY`.
    """

    chip: LatencyChip
    numbers: Numbers
    arcs: Arcs
    memory: Memory
    at: F64
    targets: tuple[tuple[I64, F64], ...]
    now: float
    pinged: F64
    lost: int = 0
    sent: list[tuple[F64, I64]] = field(default_factory=list, repr=False)
    temperature: Course | None = None

    @property
    def period(self) -> float:
        """Time between pings, s."""
        return self.numbers.ping_period

    def ping(self, head: int, goal: int, seen: F64) -> ChipReply:
        """Send a ping's events, read the motors, and reset where they have spoken."""
        reply = self.answer(head, goal, seen)
        self.end(spoken=reply.turned is not None or reply.emergency is not None)
        return reply

    def answer(self, head: int, goal: int, seen: F64) -> ChipReply:
        """Send a ping's events and read the motors; `end` has to follow."""
        self._follow_temperature()
        self.pinged[head] = self.now
        times, addresses = self._events(head, goal, seen)
        response = self.chip.ping(self.memory, self.now, times, addresses)
        self.lost += response.lost_in + response.lost_out
        self._keep(response)
        groups = np.array(self.chip.design.group)[response.paths]
        recent = self.now + response.times - self.pinged[groups] < _RECENT
        turned = float(response.times[recent][0]) if recent.any() else None
        emergency = response.emergency if math.isfinite(response.emergency) else None
        head_to = int(groups[0]) if groups.size else None
        return ChipReply(head_to, np.sort(response.paths[recent]), turned, emergency, response)

    def end(self, *, spoken: bool) -> None:
        """Go on to the next ping, with a reset where the motors have spoken."""
        if spoken:
            self.chip.reset(self.memory, self.now + self.numbers.reset_at)
        self.now += self.numbers.ping_period

    def _follow_temperature(self) -> None:
        if self.temperature is None:
            return
        time = self.now - self.numbers.ping_period
        wanted = self.temperature.at(time)
        if wanted != self.chip.silicon.temperature_c:
            with told_when(time):
                self.chip = self.chip.moved(self.memory, wanted, self.now)

    def _keep(self, response: PingResponse) -> None:
        """Keep the spikes of a ping; its time counts from the first ping, which comes after a period."""
        alarm = np.array([response.emergency]) if math.isfinite(response.emergency) else np.empty(0)
        paths = np.append(response.paths, np.full(alarm.size, EMERGENCY))
        late = np.append(response.times, alarm)
        self.sent.append((self.now - self.numbers.ping_period + late, paths))

    def spikes(self) -> tuple[F64, I64]:
        """All spikes of the chip: times after the first ping, s, and addresses, `EMERGENCY` the last."""
        none = np.empty(0), np.empty(0, dtype=np.int64)
        times, paths = zip(none, *self.sent, strict=True)
        return np.concatenate(times), np.concatenate(paths)

    def counts(self) -> dict[str, int]:
        """Events lost on the bus or for want of a synapse, and detectors that the model could not decide."""
        return {"lost": self.lost, **counted(self.memory)}

    def _events(self, head: int, goal: int, seen: F64) -> tuple[F64, I64]:
        """Times after the ping (s) and addresses of all events of a ping."""
        a, s = self.chip.addresses, self.numbers
        times = [np.array([0.0, s.goal_delay, s.direction_delay])]
        sent = [np.array([a.onset, a.goal + goal, a.direction + head])]
        if len(seen):
            late = echo_delay(np.hypot(*seen.T))
            order = np.argsort(late, kind="stable")
            place, first = np.unique(nearest_place(seen, self.at)[order], return_index=True)
            for j, echo in zip(place, late[order][first], strict=True):
                arcs, delays = self.targets[head * len(self.at) + j]
                times.append(echo + delays)
                sent.append(arcs)
        return np.concatenate(times), np.concatenate(sent)


def design_of(arcs: Arcs, numbers: Numbers) -> Design:
    """The chip for a bat's arcs, with the network's numbers."""
    share = passive_current(arcs, numbers) * numbers.race
    return Design(
        group=tuple(int(g) for g in arcs.group),
        share=tuple(float(x) for x in share),
        second=tuple(float(x) for x in layer_delays(numbers)),
        hop=numbers.tap_delay,
        step=numbers.step_current,
        **{name: getattr(numbers, name) for name in _SHARED},
    )


def chip_brain(
    arcs: Arcs,
    numbers: Numbers,
    silicon: Silicon | None = None,
    biases: Biases | None = None,
    *,
    kind: BiasKind = "gate",
    area: float = 1.0,
) -> ChipBrain:
    """A chip with its maps and motors, settled for a period; raises as `check_timing` and the chip."""
    check_timing(arcs, numbers)
    design = design_of(arcs, numbers)
    made = silicon or Silicon()
    chip = LatencyChip(design, biases or usual_biases(design, kind, made.process), made, area=area)
    return brain_with(chip, arcs, numbers)


def brain_with(
    chip: LatencyChip, arcs: Arcs, numbers: Numbers, temperature: Course | None = None
) -> ChipBrain:
    """A chip with its maps and motors, after a reset and a period without a ping."""
    at = places()
    found = blocking(arcs, at, numbers.constant_delay + _EARLIER)
    return ChipBrain(
        chip, numbers, arcs, chip.new_memory(), at, _targets(found, len(at)), numbers.ping_period,
        np.full(DIRECTIONS, -math.inf), temperature=temperature,
    )  # fmt: skip


def _targets(found: Blocking, count: int) -> tuple[tuple[I64, F64], ...]:
    """Memories and delays (s) of each place of each body map, map after map."""
    key = found.direction * count + found.place
    order = np.argsort(key, kind="stable")
    edges = np.searchsorted(key[order], np.arange(DIRECTIONS * count + 1))
    return tuple((found.arc[order[a:b]], found.delay[order[a:b]]) for a, b in itertools.pairwise(edges))


CALIBRATION = Calibration(
    name=NAME,
    summary="times of taps, integrating neurons, cells and pulses of the latency chip",
    process=AMI_1500,
    calibrate=calibrate,
    setup=Sized(design_of(arcs_of(Bat()), Numbers())),
    require_temperature=require_temperature,
)
