"""Behavioural model of the sonar head's ears and LSO neurons on a die, and of their answer to an echo.

Two ears of `LEVELS` level units each (`circuits.blocks.sonar.high_threshold_neuron`, thresholds spaced
logarithmically) and two LSO neurons (`circuits.blocks.lso.lso_neuron`): each is excited by the level units
of its own side and inhibited by those of the other. Behavioural and event-driven, by the laws of
`chips.lso.law`:

    T_k = 10 us + Q_t e^(g x_k) / (I_step,k - I_off) + t_turn    of a synapse's step, from its event
    I_k                                           of a synapse, of either side
    mirrored(carried(sum I_k))                    of all inhibitory ones
    Q e^(g x)                                     of a spike

Currents are the transistor law's own for the devices of this die, in saturation; charges, delays and the
mirror's m are the record's (`chips.lso.measure`), with the offsets of the comparators that end them.
Everything deviates as the transistor level's devices do at `sonar_head/ear[side]/level[k]` and
`sonar_head/lso[side]`. A step ends and a spike comes after the comparator has turned (t_turn), which takes
the longer the slower its input rises, and a dead time follows a spike; all by the die's own copies of the
comparators' current. Under the full law switches that are off take I_off of this die from timers and
membranes. The gate of the inhibitory mirror is charged as one inhibition charges it, with a capacitance that
does not deviate. Left out: other mismatch of switches and of inverters. On a die whose capacitors deviate
each charge has its own capacitor's; that of a level unit is its axon's input, without one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from chips.lso.law import Comparator, Gate, Membrane, Steps, lso_spikes, ramp_delay
from chips.lso.measure import (
    LEVEL_AXON,
    LEVEL_COMPARATOR,
    LEVELS,
    MEMBRANE_SWITCHES,
    QUANTITIES,
    WEAK,
    circuits,
    idle,
    level_kappa,
    own_current,
    spike_kappa,
)
from chips.lso.place import NAME, Currents, line_volts
from chips.lso.rest import PART as _PART
from chips.lso.rest import law_depth
from chips.measured.table_record import all_on_silicon, check_box, tables_of, temperature_weights
from chips.measured.timer import COMPARATOR
from chips.validity import require_area
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.latency.synapse import REFERENCE
from circuits.circuit import BiasKind, Circuit
from circuits.event import WIDTH
from circuits.lowering.capacitors_on_die import added_capacitance
from circuits.lowering.on_die import DieDevices, Mirror, on_die, transistor_of
from circuits.silicon.die import Path
from circuits.silicon.silicon import Silicon

RECORD = "lso_neuron"
SIDES = 2  # left, right
REST_ERROR = 5e-4  # V, within which of the limit the model does not know whether a unit hears; ours
SPIKE_ERROR = 1e-3  # of a neuron's charge, by which the model may be off as to its count of spikes; ours
LEAST_AREA = 1.0 / 16.0  # of the circuits' devices, down to which the model was measured
_TAIL = "cell.threshold.mc0"  # of an LSO neuron's comparator
_STARVED = {"cell.mds": 0.5, "cell.mos": 0.3}  # what slows a spike's end, and shares of it; ours
_STAGE = 0.6  # of a comparator's lag, what its own second stage makes, ours; the rest by what the die shares
_LSO = (
    "md", "mk", *_STARVED, *(f"cell.threshold.{d}" for d in COMPARATOR),
    *(f"{name}{k}.{d}" for name in ("excite", "inhibit") for k in range(LEVELS)
      for d in ("me", "mt", "mr", *(f"timer.{c}" for c in COMPARATOR))),
    *MEMBRANE_SWITCHES,
)  # fmt: skip
_MEMBRANE = "cell.cm"
_CAPACITORS = (_MEMBRANE, *(f"{name}{k}.ct" for name in ("excite", "inhibit") for k in range(LEVELS)))
_LEVEL = (
    *(f"{_PART}.{d}" for d in (*LEVEL_COMPARATOR, "mc3", "mc6", "mc7")),
    *(f"generator.axon.{d}" for d in LEVEL_AXON),
)


class Head(NamedTuple):
    """Numbers of a head on a die, for sides s and level units or synapses k; A, C and s.

    excite, inhibit: currents of the LSO neurons' synapses, [s, k]; excite_step, inhibit_step: how long they
    last, [s, k]; charge: of the membrane, [s]; leak: what switches take from it, [s]; onset: delay of an
    event; spike_charge, spike_current, spike_kappa, lag [s]: of its comparator, as of `Comparator`; dead:
    time after a spike, [s], in which the membrane is emptied; gate_charge, gate_current, gate_fold: fields of
    a `Gate` of the mirror, [s]; mirror_in, mirror_out, mirror_shift: fields of a `Mirror`, [s]; offset: of a
    level unit's threshold, V, [s, k]; rest: how far below it an input at rest must be, V, [s, k];
    level_current: of a level unit's comparator, [s, k]; level_charge, level_lag: of its axon's input, and how
    much later it spikes on any ramp, [s, k]; kappa [s, k], u_t: of the level units' law.
    """

    excite: F64
    inhibit: F64
    excite_step: F64
    inhibit_step: F64
    charge: F64
    leak: F64
    onset: float
    spike_charge: F64
    spike_current: F64
    spike_kappa: F64
    lag: F64
    dead: F64
    gate_charge: F64
    gate_current: F64
    gate_fold: F64
    mirror_in: F64
    mirror_out: F64
    mirror_shift: F64
    offset: F64
    rest: F64
    level_current: F64
    level_charge: F64
    level_lag: F64
    kappa: F64
    u_t: float


def head_on(
    silicon: Silicon, kind: BiasKind = "generator", area: float = 1.0, currents: Currents = ()
) -> Head:
    """Return the numbers of the head on a silicon.

    kind: of its biases; area: of the drawn devices over the circuits'; currents: of biases by name, A, in the
    place of the circuits' own. Raises `ParameterError` for an area or a silicon outside the record's box, and
    `DataError` where the record is of other circuits.
    """
    require_area(NAME, area, LEAST_AREA)
    check_box(NAME, silicon, tables_of(RECORD, circuits, silicon.process))
    return _Maker(silicon, kind, area, currents).make()


def level_times(head: Head, crossed: F64, slope: F64) -> F64:
    """Return the spikes (s) of level units, float64[SIDES, LEVELS], inf for none.

    crossed: when the thresholds are passed, s, inf for never; slope: of the envelope then, V/s; both of that
    shape.
    """
    on = np.isfinite(crossed)
    found = np.full(crossed.shape, np.inf)
    found[on] = crossed[on] + level_delays(head, np.where(on, slope, 1.0))[on]
    return found


def level_delays(head: Head, slope: F64) -> F64:
    """Return how long after their thresholds are passed level units spike, s, float64[SIDES, LEVELS].

    slope: of the envelope, V/s, above 0, of that shape.
    """
    own = ramp_delay(slope, head.level_charge, head.level_current, head.kappa, head.u_t)
    return np.asarray(own + head.level_lag)


def side_spikes(head: Head, side: int, level: F64, *, inhibited: bool = True) -> F64:
    """Return the spikes (s) of an LSO neuron on `side`.

    level: spikes of the level units, s, float64[SIDES, LEVELS], inf for none; inhibited: whether the other
    side inhibits it.
    """
    return lso_spikes(*side_inputs(head, side, level, inhibited=inhibited))


def is_count_certain(head: Head, side: int, level: F64) -> bool:
    """Whether an LSO neuron makes as many spikes with a charge of the membrane that is `SPIKE_ERROR` off.

    Where a spike comes just before its steps end, or just does not, the model does not know which.
    """
    counts = {
        side_spikes(head._replace(charge=head.charge * part), side, level).size
        for part in (1.0 - SPIKE_ERROR, 1.0, 1.0 + SPIKE_ERROR)
    }
    return len(counts) == 1


def side_inputs(
    head: Head, side: int, level: F64, *, inhibited: bool = True
) -> tuple[Steps, Steps, Membrane, Mirror]:
    """Return the steps of excitation and of inhibition, the membrane and the mirror of an LSO neuron.

    The arguments are those of `side_spikes`.
    """
    far = level[1 - side] if inhibited else np.full(level.shape[1], np.inf)
    excitation = Steps(level[side] + head.onset, head.excite_step[side], head.excite[side])
    inhibition = Steps(far + head.onset, head.inhibit_step[side], head.inhibit[side])
    charge = float(head.charge[side])
    comparator = Comparator(
        *(float(x[side]) for x in (head.spike_charge, head.spike_current, head.spike_kappa, head.lag))
    )
    dead = float(head.dead[side])
    leak = float(head.leak[side])
    gate = Gate(*(float(x[side]) for x in (head.gate_charge, head.gate_current, head.gate_fold)))
    membrane = Membrane(charge / REFERENCE, REFERENCE, dead, head.u_t, comparator, leak, gate)
    mirror = Mirror(head.mirror_in[side], head.mirror_out[side], head.mirror_shift[side])
    return excitation, inhibition, membrane, mirror


def _together(currents: Sequence[tuple[float, F64]]) -> F64:
    """The current (A) of a time of which each current sets a share; shares add up to 1."""
    return np.asarray(1.0 / sum(share / current for share, current in currents))


class _Comparators(NamedTuple):
    """Comparators as of `Comparator`, arrays of one shape."""

    charge: F64
    current: F64
    kappa: F64
    lag: F64


class _Maker:
    """A die's devices and voltages while its numbers are made."""

    def __init__(self, silicon: Silicon, kind: BiasKind, area: float, currents: Currents) -> None:
        self.silicon = silicon.of_area(area)
        self.tables = tables_of(RECORD, circuits, silicon.process)
        found = all_on_silicon(self.tables, QUANTITIES, silicon)
        self.charge = {name: float(value) for name, value in zip(QUANTITIES, found, strict=True)}
        self.lso, self.level = circuits()
        self.lines = lines = line_volts(self.silicon, kind, currents)
        sides: Path = ((NAME, ()), ("lso", (SIDES,)))
        self.sides = on_die(self.lso, self.silicon, _LSO, sides, lines)
        self.added = added_capacitance(self.lso, self.silicon, _CAPACITORS, sides)
        units: Path = ((NAME, ()), ("ear", (SIDES,)), ("level", (LEVELS,)))
        self.units = on_die(self.level, self.silicon, _LEVEL, units, lines)
        self.alone = replace(self.silicon, die=silicon.die.without_mismatch())
        self.shared = on_die(self.lso, self.alone, (_TAIL,), ((NAME, ()),), lines)
        self.common = self.current(self.shared, self.lso, _TAIL)
        self.ideal = rebias(self.level, {}, "ideal")

    def make(self) -> Head:
        q = self.charge
        currents = {name: self.synapses(name, "me") for name in ("excite", "inhibit")}
        steps = {name: WIDTH + self.times(name) for name in currents}
        ends = self.sides.offset(*(f"cell.threshold.{d}" for d in COMPARATOR))
        tail, stage = (self.current(self.sides, self.lso, f"cell.threshold.{d}") for d in ("mc0", "mc6"))
        comparator = self.comparators(tail, stage)
        own = [(share, self.current(self.sides, self.lso, d)) for d, share in _STARVED.items()]
        starved = _together([*own, (1.0 - sum(_STARVED.values()), self.common)])
        mirror = self.sides.mirror("md", "mk")
        levels = self.units.offset(*(f"{_PART}.{d}" for d in LEVEL_COMPARATOR))
        axons = self.units.offset(*(f"generator.axon.{d}" for d in LEVEL_AXON))
        level_current = self.current(self.units, self.level, f"{_PART}.mc3")
        gate_charge, gate_current, gate_fold = self.gate(currents["inhibit"])
        return Head(
            excite=currents["excite"],
            inhibit=currents["inhibit"],
            excite_step=steps["excite"],
            inhibit_step=steps["inhibit"],
            charge=(q["membrane"] + self.more(_MEMBRANE)) * np.exp(ends @ self.slopes("comparator")),
            leak=np.zeros(SIDES) + idle(self.sides, *MEMBRANE_SWITCHES),
            onset=float(self.at("onset", self.common) / self.common),
            spike_charge=comparator.charge,
            spike_current=comparator.current,
            spike_kappa=comparator.kappa,
            lag=comparator.lag,
            dead=self.at("dead", starved) / starved,
            gate_charge=gate_charge,
            gate_current=gate_current,
            gate_fold=gate_fold,
            mirror_in=np.asarray(mirror.given),
            mirror_out=np.asarray(q["mirror"] * mirror.taken),
            mirror_shift=self.mirror_shift(currents["inhibit"]),
            offset=self.at("level_offset", level_current) + levels @ self.slopes("level"),
            rest=self.rest(),
            level_current=level_current,
            level_charge=self.at("level_charge", level_current)
            * np.exp(axons @ self.slopes("axon") + self.limited()),
            level_lag=q["level_lag"] / level_current,
            kappa=level_kappa(self.level, self.silicon, level_current),
            u_t=self.silicon.thermal_voltage,
        )

    def limited(self) -> float:
        """How far ln of what level units' axons take is from the record's by their limit's current.

        That differs from the record's ideal one with fixed gates, and moves the axon as a beta of its device.
        """
        name = f"generator.axon.{LEVEL_AXON[0]}"
        alone = on_die(self.level, self.alone, (name,), ((NAME, ()),), self.lines)
        ratio = self.current(alone, self.level, name) / own_current(self.ideal, "i_lim", self.alone)
        return float(self.slopes("axon")[1] * np.log(ratio))

    def at(self, name: str, current: F64) -> F64:
        """A quantity of `FOLLOWING` at currents (A) of the comparators: straight in their logarithms."""
        usual = self.charge["level_compared" if name.startswith("level") else "compared"]
        part = np.log(current / usual) / np.log(WEAK)
        return np.asarray(self.charge[name] + part * (self.charge[f"{name}_weak"] - self.charge[name]))

    def comparators(self, tail: F64, stage: F64) -> _Comparators:
        """Comparators whose tails and second stages carry these currents, A, of one shape."""
        kappa = spike_kappa(self.lso, self.silicon, tail)
        lag = self.at("lag", tail) / _together([(_STAGE, stage), (1.0 - _STAGE, self.common)])
        return _Comparators(self.at("spike", tail), tail, kappa, lag)

    def gate(self, current: F64) -> tuple[F64, F64, F64]:
        """What charges the mirror's gate, as of `Gate`, [SIDES] each, for one inhibition.

        current: of the synapses, A, [SIDES, LEVELS].
        """
        one = current.mean(axis=-1)
        volts, twice = (self.sides.gate_for("md", times * one) for times in (1.0, 2.0))
        charge = self.charge["gate"] * np.maximum(volts - self.charge["gate_rest"], 0.0)
        return np.asarray(charge), one, np.asarray(self.charge["gate"] * (twice - volts) / np.log(2.0))

    def mirror_shift(self, current: F64) -> F64:
        """`(v_p,out - v_p,in) / 2 U_T` of the mirror, [SIDES], at the gate that one inhibition gives it.

        current: of the synapses, A, [SIDES, LEVELS].
        """
        gate = self.sides.gate_for("md", current.mean(axis=-1))
        return np.asarray(0.5 * (self.sides.pinch("mk", gate) - self.sides.pinch("md", gate)))

    def synapses(self, name: str, device: str) -> F64:
        """Currents of a device of each synapse of an input, [SIDES, LEVELS]."""
        each = [self.current(self.sides, self.lso, f"{name}{k}.{device}") for k in range(LEVELS)]
        return np.stack(each, axis=-1)

    def times(self, name: str) -> F64:
        """How long after its event each synapse's timer has charged and its comparator has turned, s."""
        each = [f"{name}{k}" for k in range(LEVELS)]
        ends = np.stack([self.sides.offset(*(f"{s}.timer.{d}" for d in COMPARATOR)) for s in each], axis=1)
        more = np.stack([self.more(f"{s}.ct") for s in each], axis=-1)
        taken = np.stack([idle(self.sides, f"{s}.mr") + np.zeros(SIDES) for s in each], axis=-1)
        charge = (self.charge["timer"] + more) * np.exp(ends @ self.slopes("comparator"))
        net = self.synapses(name, "mt") - taken
        c = self.comparators(self.synapses(name, "timer.mc0"), self.synapses(name, "timer.mc6"))
        ramp = net * REFERENCE / charge
        late = c.lag + ramp_delay(ramp, c.charge, c.current, c.kappa, self.silicon.thermal_voltage)
        return np.asarray(charge / net + late)

    def more(self, name: str) -> F64:
        """What a capacitor takes beyond what is drawn until the comparator turns, C, [SIDES]."""
        return REFERENCE * self.added[name]

    def slopes(self, table: str) -> F64:
        """Slopes of the record at the silicon's temperature."""
        return np.asarray(temperature_weights(self.tables, self.silicon.temperature_c) @ self.tables[table])

    def rest(self) -> F64:
        """How far below its threshold each level unit's input must rest to be heard, V, [SIDES, LEVELS]."""
        own = self.units.offset(*(f"{_PART}.{d}" for d in LEVEL_COMPARATOR[:2])) @ self.slopes("level")[:4]
        return np.asarray(self.charge["level_rest"] * law_depth(self.units, self.level, self.silicon) - own)

    def current(self, d: DieDevices, circuit: Circuit, name: str) -> F64:
        """Saturated current of a device whose gate is a line of the chip, A."""
        device = transistor_of(circuit, name)
        return d.saturated(name, d.below(device.gate) if device.polarity == "p" else d.gate[device.gate])
