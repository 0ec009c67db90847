"""Noise of the sonar head's level units and LSO neurons, from that of their devices.

Membrane: every current that a transistor lets onto it or takes from it brings shot noise, the inhibitory sum
three times, since its sources, and both sides of the mirror that turns it, make their own; and a reset leaves
k T C. With phi of `chips.shot_noise`, I_in what the mirror's diode carries and taken what its copy does, the
charge's variance since the reset is

    V = q int [phi I_exc + (phi + phi_in) taken^2 / I_in + phi_out taken] dt + k T C

and a spike comes where the membrane passes V_ref + xi sqrt(V) / C. Step: sigma(T) = T sqrt(q phi / Q_t).
Level unit: on a ramp the pair's currents I_1, I_2 part, z = psi kappa S t / U_T (psi: how steep the pair is
beside weak inversion), and its axon's input takes up

    int (1/2) S dt,  S = 2 q [4 phi I_1 I_2 / I + 2 phi_m I_1 + phi_t I tanh^2(z / 2)]

(pair, mirror, tail), which over the current at the spike, I tanh(z / 2), is its jitter. Flicker, drawn anew
for each ping: of the currents' devices over their steps, and of a level unit's pair and mirror as an offset.
The lines of a generator wander (`chips.lines.wander`), and with each the currents that it sets, for a ping.
Left out: comparators of neurons and timers (1 % of the variance) and their line, noise before a ramp's
crossing, how the flicker of one ping goes on in the next, and a membrane that is balanced so well that it
creeps.

Draws are keyed by (seed, trial, quantity, ping).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from chips.lines.wander import Reach, WanderDraws, joined, wander_draws, wander_of
from chips.lso.law import Membrane, Steps, mirrored, moved, rise_time, segments, spike_delay
from chips.lso.measure import circuits, level_kappa
from chips.lso.model import RECORD, SIDES, Head, side_inputs
from chips.lso.place import NAME, Currents, biased
from chips.measured.table_record import all_on_silicon, tables_of
from chips.noise import SiliconNoise, die_name
from chips.noise_draw import Draws, new_draws, normals
from chips.shot_noise import current_wander, gate_wander, shot_share, steepness, steepness_under
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.lowering.on_die import Mirror, transistor_of
from circuits.silicon.process import ELEMENTARY_CHARGE
from circuits.silicon.silicon import Silicon

LEVEL, SPIKES = "level", "spikes"
_COMPARATOR = "generator.comparator"
_DEVICES = ("excite0.me", "excite0.mt")
_LINES = ("i_exc", "i_step", "i_cmp")  # of the neurons, and of the level units
_ROOM = 64  # spikes of a neuron that a draw is for; more take another


class Grain(NamedTuple):
    """Charges (C) that an LSO neuron's currents consist of: exciting and inhibiting, each `q phi`."""

    exciting: float
    inhibiting: float


class LevelGrain(NamedTuple):
    """Shares phi of a level unit's pair, mirror and tail; per_volt: psi kappa / U_T of the pair, 1/V."""

    pair: float
    mirror: float
    tail: float
    per_volt: float


@dataclass(frozen=True, slots=True, eq=False)
class LsoNoise:
    """Noise of a head.

    spread: relative standard deviation of fields of `Head`, in their shapes; offset: standard deviation of
    the level units' thresholds, V; grain: of the neurons' currents; level: of the level units'; draws: random
    numbers of each quantity; lines: those of the chip's generator; reach: what they do to fields of `Head`.
    """

    spread: dict[str, F64]
    offset: F64
    grain: Grain
    level: LevelGrain
    draws: dict[str, Draws]
    lines: WanderDraws
    reach: dict[str, Reach]


def noise_of(
    head: Head, silicon: Silicon, noise: SiliconNoise, area: float = 1.0, kind: BiasKind = "generator",
    currents: Currents = (),
) -> LsoNoise:  # fmt: skip
    """Return the noise of a head with these numbers.

    area: of the drawn devices over the circuits'; kind, currents: of its biases, as of `head_on`. Raises
    `ParameterError` for a ripple on biases that are none of a generator's.
    """
    lso, _ = circuits()
    tables = tables_of(RECORD, circuits, silicon.process)
    (timer,) = all_on_silicon(tables, ("timer",), silicon)
    square = silicon.law("p").square_current
    devices = [transistor_of(lso, name) for name in _DEVICES]
    source, counter = (square * d.square for d in devices)
    areas = [area * d.gate_area for d in devices]
    spread = {}
    for name in ("excite", "inhibit"):
        current, lasts = getattr(head, name), getattr(head, f"{name}_step")
        drawn = float(timer) / lasts
        spread[name] = np.sqrt(
            current_wander(silicon, noise, "p", areas[0], lasts, steepness(current, source))
        )
        slow = current_wander(silicon, noise, "p", areas[1], lasts, steepness(drawn, counter))
        shot = ELEMENTARY_CHARGE * shot_share(drawn, counter) / float(timer)
        spread[f"{name}_step"] = np.sqrt(shot + slow)
    grain = Grain(*(
        ELEMENTARY_CHARGE * float(shot_share(getattr(head, n).mean(), source)) for n in ("excite", "inhibit")
    ))  # fmt: skip
    root = die_name(NAME, silicon.die)
    count = {**{n: s.size for n, s in spread.items()}, "offset": head.offset.size, LEVEL: head.offset.size}
    count |= {f"{SPIKES}{side}": _ROOM for side in range(SIDES)}
    draws = {n: new_draws(noise.seed, noise.trial, f"{root}, {n}", size) for n, size in count.items()}
    own = level_grain(float(head.level_current.mean()), silicon)
    lines = _lines(head, silicon, noise, kind, currents)
    reach = _reach(head, silicon, lines, float(timer))
    return LsoNoise(spread, _offsets(head, silicon, noise, area), grain, own, draws, lines, reach)


def _lines(
    head: Head, silicon: Silicon, noise: SiliconNoise, kind: BiasKind, currents: Currents
) -> WanderDraws:
    """The lines of `_LINES` in their order."""
    lso, level = biased(kind, currents)
    parts = [wander_of(lso, _LINES[:2], silicon, noise), wander_of(level, _LINES[2:], silicon, noise)]
    shortest = float((head.level_charge / head.level_current).min())
    return wander_draws(joined(parts), silicon, noise, die_name(NAME, silicon.die), shortest)


def _reach(head: Head, silicon: Silicon, lines: WanderDraws, timer: float) -> dict[str, Reach]:
    """What the lines do to currents, steps and level units' tails; timer: charge of a step, C."""
    lso, level = circuits()
    law = silicon.law("p")
    found = {}
    for line, name, current, time, sign in (
        (0, "excite", head.excite, head.excite_step, 1.0),
        (0, "inhibit", head.inhibit, head.inhibit_step, 1.0),
        (1, "excite_step", timer / head.excite_step, head.excite_step, -1.0),
        (1, "inhibit_step", timer / head.inhibit_step, head.inhibit_step, -1.0),
        (2, "level_current", head.level_current, head.level_charge / head.level_current, 1.0),
    ):
        device = (
            transistor_of(level, f"{_COMPARATOR}.mc3") if line == 2 else transistor_of(lso, _DEVICES[line])
        )
        steep = steepness_under(law, current, law.square_current * device.square)
        found[name] = lines.reach(np.array(line), time, sign * steep * law.kappa / law.u_t)
    return found


def head_of_ping(head: Head, noise: LsoNoise, number: int, begin: float = 0.0) -> Head:
    """Return the numbers of a head in ping `number`, which begins at `begin` s."""
    drawn = noise.lines.drawn(number)
    changes = {name: noise.lines.changes(reach, drawn, begin) for name, reach in noise.reach.items()}
    found = {
        name: getattr(head, name)
        * (1.0 + spread * normals(noise.draws[name], number, spread) + changes[name])
        for name, spread in noise.spread.items()
    }
    found["level_current"] = head.level_current * (1.0 + changes["level_current"])
    offset = head.offset + noise.offset * normals(noise.draws["offset"], number, noise.offset)
    return head._replace(offset=offset, **found)


def level_jitter(head: Head, noise: LsoNoise, number: int, delay: F64, slope: F64) -> F64:
    """Return what is added to level units' spikes in ping `number`, s, float64[SIDES, LEVELS].

    delay: from a ramp's crossing to the spike, s, inf for none; slope: of the ramp, V/s; both of that shape.
    """
    spread = np.zeros(delay.shape)
    on = np.isfinite(delay)
    spread[on] = level_spread(noise.level, delay[on], slope[on], head.level_current[on])
    return spread * normals(noise.draws[LEVEL], number, spread)


def level_spread(grain: LevelGrain, delay: F64, slope: F64, current: ArrayLike) -> F64:
    """Return the standard deviation of a level unit's spike, s, arrays of one shape.

    delay: from when a ramp of `slope` V/s passed the threshold, s; current: of the tail, A.
    """
    steep = grain.per_volt * slope
    z = steep * delay
    pair = 0.5 - 1.0 / (1.0 + np.exp(z))
    mirror = z - np.logaddexp(z, 0.0) + math.log(2.0)
    tail = z - 2.0 * np.tanh(0.5 * z)
    whole = np.asarray(current, dtype=np.float64)
    taken = 4.0 * grain.pair * pair + 2.0 * grain.mirror * mirror + grain.tail * tail
    return np.asarray(np.sqrt(ELEMENTARY_CHARGE / whole / steep * taken) / np.tanh(0.5 * z))


def noisy_side_spikes(
    head: Head, noise: LsoNoise, number: int, side: int, level: F64, *, inhibited: bool = True
) -> F64:
    """Return the spikes (s) of an LSO neuron in ping `number`, as `chips.lso.model.side_spikes` does."""
    excitation, inhibition, membrane, mirror = side_inputs(head, side, level, inhibited=inhibited)
    return noisy_spikes(excitation, inhibition, membrane, mirror, noise.grain, _Normals(noise, side, number))


class _Normals:
    """Draws of a neuron's spikes in a ping, by their number."""

    def __init__(self, noise: LsoNoise, side: int, number: int) -> None:
        self.fixed, self.number = noise.draws[f"{SPIKES}{side}"], number
        self.block = np.zeros(0)

    def __call__(self, spike: int) -> float:
        """Of spike `spike`, asked for in their order."""
        if spike % _ROOM == 0:
            self.block = normals(self.fixed, self.number, np.zeros(_ROOM), spike // _ROOM)
        return float(self.block[spike % _ROOM])


def noisy_spikes(
    excitation: Steps, inhibition: Steps, membrane: Membrane, mirror: Mirror, grain: Grain, drawn: _Normals
) -> F64:
    """Return the spikes (s) of an LSO neuron with noise, as `chips.lso.law.lso_spikes` does without.

    drawn: gives the random number of each spike.
    """
    edges, given, sums = segments(excitation, inhibition, membrane)
    emptied = ELEMENTARY_CHARGE * membrane.u_t * membrane.capacitance  # k T C
    takes = mirrored(mirror, sums)
    rates = shot_rates(grain, mirror, np.array(given), np.array(sums), takes).tolist()
    spikes: list[float] = []
    volts, free, variance, normal = 0.0, -math.inf, emptied, drawn(0)
    for begin, end, exc, taken, rate in zip(edges[:-1], edges[1:], given, takes.tolist(), rates, strict=True):
        now = max(begin, free)
        while now < end:
            # noise may have held it back beyond the reference
            reached = now if volts >= membrane.reference else now + rise_time(membrane, volts, exc, taken)
            if reached == math.inf:  # it rests, and forgets
                volts, variance = moved(membrane, volts, exc, taken, end - now), emptied
                break
            moved_by = normal * math.sqrt(variance + rate * (reached - now)) / membrane.capacitance
            other = membrane._replace(reference=membrane.reference + moved_by)
            reached = now if volts >= other.reference else now + rise_time(other, volts, exc, taken)
            if reached > end:
                volts, variance = moved(membrane, volts, exc, taken, end - now), variance + rate * (end - now)
                break
            spike = reached + spike_delay(membrane, exc, taken)
            spikes.append(spike)
            volts, free, variance, normal = 0.0, spike + membrane.dead, emptied, drawn(len(spikes))
            now = free
    return np.array(spikes)


def shot_rates(grain: Grain, mirror: Mirror, given: F64, inhibition: F64, taken: F64) -> F64:
    """Return the variance of the membrane's charge a second, C^2/s, arrays of one shape.

    given: exciting current, A; inhibition: what the mirror's diode carries, A; taken: what its copy does, A.
    """
    rate = grain.exciting * given
    on = inhibition > 0.0
    into, out = inhibition[on], taken[on]
    within = shot_share(into, mirror.given) * out**2 / into + shot_share(out, mirror.taken) * out
    rate[on] += grain.inhibiting * out**2 / into + ELEMENTARY_CHARGE * within
    return rate


def _offsets(head: Head, silicon: Silicon, noise: SiliconNoise, area: float) -> F64:
    """Deviation (V) of each level unit's threshold by flicker of pair and mirror while it charges."""
    _, level = circuits()
    time = head.level_charge / head.level_current
    pair, mirror = (area * transistor_of(level, f"{_COMPARATOR}.{d}").gate_area for d in ("mc1", "mc4"))
    law = silicon.law("n")
    specific = law.square_current * transistor_of(level, f"{_COMPARATOR}.mc4").square
    beside = law.kappa * steepness(0.5 * head.level_current, specific) / head.kappa
    own, turned = gate_wander(silicon, noise, "p", pair, time), gate_wander(silicon, noise, "n", mirror, time)
    return np.asarray(np.sqrt(2.0 * own + 2.0 * turned * beside**2))


def level_grain(whole: float, silicon: Silicon) -> LevelGrain:
    """Return the noise of a level unit whose tail carries `whole` (A).

    Pair and mirror carry half of it each.
    """
    _, level = circuits()
    half = 0.5 * whole
    specific = {
        name: silicon.law("n" if name == "mc4" else "p").square_current
        * transistor_of(level, f"{_COMPARATOR}.{name}").square
        for name in ("mc1", "mc3", "mc4")
    }
    pair, mirror, tail = (
        float(shot_share(i, specific[name])) for name, i in (("mc1", half), ("mc4", half), ("mc3", whole))
    )
    steep = float(level_kappa(level, silicon, whole)) / silicon.thermal_voltage
    return LevelGrain(pair, mirror, tail, steep)
