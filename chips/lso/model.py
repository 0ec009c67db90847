"""Behavioural model of the sonar head's ears and LSO neurons on a die, and of their answer to an echo.

Two ears of `LEVELS` level units each (`circuits.blocks.sonar.high_threshold_neuron`, thresholds spaced
logarithmically) and two LSO neurons (`circuits.blocks.lso.lso_neuron`): each is excited by the level units
of its own side and inhibited by those of the other. Behavioural and event-driven, by the laws of
`chips.lso.law`:

    T_k = 10 us + Q_t (1 + g_k x_k) / (I_step,k - I_off)    of a synapse's step, from its event
    I_k                                           of a synapse, of either side
    mirrored(sum I_k)                             of all inhibitory ones
    Q (1 + g x)                                   of a spike

Currents are the transistor law's own for the devices of this die, in saturation; charges, delays and the
mirror's m are the record's (`chips.lso.measure`), with the offsets of the comparators that end them.
Everything deviates as the transistor level's devices do at `sonar_head/ear[side]/level[k]` and
`sonar_head/lso[side]`. A spike comes after the membrane's comparator has turned, which takes the longer the
slower the membrane rises, and a dead time follows; both by the die's own copies of the comparators' current.
Under the full law switches that are off take I_off of this die from timers and membranes. Left out: other
mismatch of switches and of inverters, and the mirror's few microseconds of delay. On a die whose capacitors
deviate each charge has its own capacitor's; that of a level unit is its axon's input, without one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from chips.lso.law import Comparator, Membrane, Steps, lso_spikes, ramp_delay, rest_depth
from chips.lso.measure import (
    LEVEL_COMPARATOR,
    LEVELS,
    MEMBRANE_SWITCHES,
    QUANTITIES,
    THRESHOLD,
    circuits,
    idle,
    pair_kappa,
    spike_kappa,
)
from chips.lso.place import NAME, Currents, line_volts
from chips.measured.table_record import all_on_silicon, check_box, tables_of, temperature_weights
from chips.measured.timer import COMPARATOR
from chips.validity import require_area
from circuits.arrays import F64
from circuits.blocks.latency.synapse import REFERENCE
from circuits.circuit import BiasKind, Circuit
from circuits.devices.channel import early
from circuits.devices.ekv import argument
from circuits.event import WIDTH
from circuits.lowering.capacitors_on_die import added_capacitance
from circuits.lowering.on_die import DieDevices, Mirror, on_die, transistor_of
from circuits.silicon.die import Path
from circuits.silicon.silicon import Silicon

RECORD = "lso_neuron"
SIDES = 2  # left, right
LEAST_AREA = 1.0 / 16.0  # of the circuits' devices, down to which the model was measured
_PART = "generator.comparator"  # of a level unit
_TAIL = "cell.threshold.mc0"  # of an LSO neuron's comparator
_STAGE = "cell.threshold.mc6"  # what its second stage falls by
_STARVED = "cell.mds"  # what a spike's end is slowed by
_LSO = (
    "md", "mk", _STARVED, *(f"cell.threshold.{d}" for d in COMPARATOR),
    *(f"{name}{k}.{d}" for name in ("excite", "inhibit") for k in range(LEVELS)
      for d in ("me", "mt", "mr", *(f"timer.{c}" for c in COMPARATOR))),
    *MEMBRANE_SWITCHES,
)  # fmt: skip
_MEMBRANE = "cell.cm"
_CAPACITORS = (_MEMBRANE, *(f"{name}{k}.ct" for name in ("excite", "inhibit") for k in range(LEVELS)))
_LEVEL = tuple(f"{_PART}.{d}" for d in (*LEVEL_COMPARATOR, "mc3", "mc6", "mc7"))


class Head(NamedTuple):
    """Numbers of a head on a die, for sides s and level units or synapses k; A, C and s.

    excite, inhibit: currents of the LSO neurons' synapses, [s, k]; excite_step, inhibit_step: how long they
    last, [s, k]; charge: of the membrane, [s]; leak: what switches take from it, [s]; onset: delay of an
    event; spike_charge, spike_current [s], spike_kappa, lag [s]: of its comparator, as of `Comparator`; dead:
    time after a spike, [s], in which the membrane is emptied to left, V; turn: charge of the mirror's gate;
    mirror_in, mirror_out, mirror_shift: fields of a `Mirror`, [s]; offset: of a level unit's threshold, V,
    [s, k]; rest: how far below it an input at rest must be, V, [s, k]; level_current: of a level unit's
    comparator, [s, k]; level_charge: of its axon's input; kappa, u_t: of the level units' law.
    """

    excite: F64
    inhibit: F64
    excite_step: F64
    inhibit_step: F64
    charge: F64
    leak: F64
    onset: float
    spike_charge: float
    spike_current: F64
    spike_kappa: float
    lag: F64
    dead: F64
    left: float
    turn: float
    mirror_in: F64
    mirror_out: F64
    mirror_shift: F64
    offset: F64
    rest: F64
    level_current: F64
    level_charge: float
    kappa: float
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
    found[on] = crossed[on] + ramp_delay(
        slope[on], head.level_charge, head.level_current[on], head.kappa, head.u_t
    )
    return found


def side_spikes(head: Head, side: int, level: F64, *, inhibited: bool = True) -> F64:
    """Return the spikes (s) of an LSO neuron on `side`.

    level: spikes of the level units, s, float64[SIDES, LEVELS], inf for none; inhibited: whether the other
    side inhibits it.
    """
    return lso_spikes(*side_inputs(head, side, level, inhibited=inhibited))


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
        head.spike_charge, float(head.spike_current[side]), head.spike_kappa, float(head.lag[side])
    )
    dead = float(head.dead[side])
    leak = float(head.leak[side])
    membrane = Membrane(charge / REFERENCE, REFERENCE, dead, head.u_t, head.turn, comparator, leak, head.left)
    mirror = Mirror(head.mirror_in[side], head.mirror_out[side], head.mirror_shift[side])
    return excitation, inhibition, membrane, mirror


class _Maker:
    """A die's devices and voltages while its numbers are made."""

    def __init__(self, silicon: Silicon, kind: BiasKind, area: float, currents: Currents) -> None:
        self.silicon = silicon.of_area(area)
        self.tables = tables_of(RECORD, circuits, silicon.process)
        found = all_on_silicon(self.tables, QUANTITIES, silicon)
        self.charge = {name: float(value) for name, value in zip(QUANTITIES, found, strict=True)}
        self.lso, self.level = circuits()
        lines = line_volts(self.silicon, kind, currents)
        sides: Path = ((NAME, ()), ("lso", (SIDES,)))
        self.sides = on_die(self.lso, self.silicon, _LSO, sides, lines)
        self.added = added_capacitance(self.lso, self.silicon, _CAPACITORS, sides)
        units: Path = ((NAME, ()), ("ear", (SIDES,)), ("level", (LEVELS,)))
        self.units = on_die(self.level, self.silicon, _LEVEL, units, lines)
        alone = replace(self.silicon, die=silicon.die.without_mismatch())
        self.shared = on_die(self.lso, alone, (_TAIL,), ((NAME, ()),), lines)

    def make(self) -> Head:
        q = self.charge
        comparator = float(self.current(self.shared, self.lso, _TAIL))
        currents = {name: self.synapses(name, "me") for name in ("excite", "inhibit")}
        steps = {name: WIDTH + self.times(name) for name in currents}
        ends = self.sides.offset(*(f"cell.threshold.{d}" for d in COMPARATOR))
        mirror = self.sides.mirror("md", "mk")
        levels = self.units.offset(*(f"{_PART}.{d}" for d in LEVEL_COMPARATOR))
        return Head(
            excite=currents["excite"],
            inhibit=currents["inhibit"],
            excite_step=steps["excite"],
            inhibit_step=steps["inhibit"],
            charge=(q["membrane"] + self.more(_MEMBRANE)) * np.exp(ends @ self.slopes("comparator")),
            leak=np.zeros(SIDES) + idle(self.sides, *MEMBRANE_SWITCHES),
            onset=q["onset"] / comparator,
            spike_charge=q["spike"],
            spike_current=self.current(self.sides, self.lso, _TAIL),
            spike_kappa=spike_kappa(self.silicon),
            lag=q["lag"] / self.current(self.sides, self.lso, _STAGE),
            dead=q["dead"] / self.current(self.sides, self.lso, _STARVED),
            left=max(0.0, q["left"]),
            turn=q["turn"],
            mirror_in=np.asarray(mirror.given),
            mirror_out=np.asarray(q["mirror"] * mirror.taken),
            mirror_shift=self.mirror_shift(currents["inhibit"]),
            offset=q["level_offset"] + levels @ self.slopes("level"),
            rest=self.rest(),
            level_current=self.current(self.units, self.level, f"{_PART}.mc3"),
            level_charge=q["level_charge"],
            kappa=pair_kappa(self.silicon),
            u_t=self.silicon.thermal_voltage,
        )

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
        """Charge over current of each synapse's timer, [SIDES, LEVELS]."""
        ends = [self.sides.offset(*(f"{name}{k}.timer.{d}" for d in COMPARATOR)) for k in range(LEVELS)]
        own = np.stack([self.more(f"{name}{k}.ct") for k in range(LEVELS)], axis=-1)
        drawn = np.exp(np.stack(ends, axis=1) @ self.slopes("comparator"))
        charges = (self.charge["timer"] + own) * drawn
        taken = np.stack(
            [idle(self.sides, f"{name}{k}.mr") + np.zeros(SIDES) for k in range(LEVELS)], axis=-1
        )
        return np.asarray(charges / (self.synapses(name, "mt") - taken))

    def more(self, name: str) -> F64:
        """What a capacitor takes beyond what is drawn until the comparator turns, C, [SIDES]."""
        return REFERENCE * self.added[name]

    def slopes(self, table: str) -> F64:
        """Slopes of the record at the silicon's temperature."""
        return np.asarray(temperature_weights(self.tables, self.silicon.temperature_c) @ self.tables[table])

    def rest(self) -> F64:
        """How far below its threshold each level unit's input must rest to be heard, V, [SIDES, LEVELS]."""
        law = self.silicon.law("p")
        tail, least = (self.current(self.units, self.level, f"{_PART}.{m}") for m in ("mc3", "mc7"))
        pair = law.square_current * transistor_of(self.level, f"{_PART}.mc1").square
        own = self.units.offset(*(f"{_PART}.{d}" for d in LEVEL_COMPARATOR[:2])) @ self.slopes("level")[:4]
        if self.units.full:
            tail, least = self.at_drains(tail, pair)
        mirror = self.units.mirror(f"{_PART}.mc4", f"{_PART}.mc6")
        return rest_depth(tail, least, mirror, pair, pair_kappa(self.silicon), law.u_t) - own

    def at_drains(self, tail: F64, pair: float) -> tuple[F64, F64]:
        """Current of a level unit's tail, and what must be exceeded over the copy's Early effect, A.

        Where the comparator turns: the pair's sources are where the pair shares the tail's current, and the
        output is a threshold above ground. tail: saturated, A; pair: specific current of its devices, A.
        """
        d, v_dd, gate = self.units, self.silicon.process.v_dd, self.units.below("v_bcmp")
        output = self.silicon.law("n").v_t0
        source = d.pinch(f"{_PART}.mc1", v_dd - THRESHOLD) - argument(0.5 * tail / pair)
        whole = d.channel(f"{_PART}.mc3", gate, d.u_t * source)
        least = d.channel(f"{_PART}.mc7", gate, v_dd - output)
        copy = d.fet[f"{_PART}.mc6"]
        return whole, least / early(copy.law, copy.length, output, np.sqrt(least / copy.current))

    def current(self, d: DieDevices, circuit: Circuit, name: str) -> F64:
        """Saturated current of a device whose gate is a line of the chip, A."""
        device = transistor_of(circuit, name)
        return d.saturated(name, d.below(device.gate) if device.polarity == "p" else d.gate[device.gate])
