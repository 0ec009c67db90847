"""Ears and LSO neurons of the sonar head on a die: what they are made of, and what they answer to an echo.

Two ears of `LEVELS` level units each (`circuits.blocks.sonar.high_threshold_neuron`, thresholds spaced
logarithmically) and two LSO neurons (`circuits.blocks.lso.lso_neuron`): each is excited by the level units
of its own side and inhibited by those of the other. Behavioural and event-driven, by the laws of
`chips.lso.law`:

    T_k = 10 us + Q_t (1 + g_k x_k) / I_step,k    of a synapse's step, from its event
    I_k                                           of a synapse, of either side
    mirrored(sum I_k)                             of all inhibitory ones
    Q (1 + g x)                                   of a spike

Currents are the transistor law's own for the devices of this die, in saturation; charges, delays and the
mirror's m are the record's (`chips.lso.measure`), with the offsets of the comparators that end them.
Everything deviates as the transistor level's devices do at `sonar_head/ear[side]/level[k]` and
`sonar_head/lso[side]`. Left out: mismatch of switches, inverters and of what makes a spike's dead time, and
the mirror's few microseconds of delay.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.lso.law import Membrane, Mirror, Steps, lso_spikes, ramp_delay, rest_depth
from chips.lso.measure import COMPARATOR, LEVEL_COMPARATOR, LEVELS, QUANTITIES, circuits
from chips.lso.place import NAME, area_of, line_volts, of_area, square_of, transistor_of
from chips.model_law import check_law
from chips.table_record import all_on_silicon, check_box, matching_tables, temperature_weights
from circuits.arrays import F64
from circuits.blocks.latency.synapse import WIDTH
from circuits.blocks.lso.lso_neuron import REFERENCE
from circuits.circuit import BiasKind, Circuit
from circuits.errors import ParameterError
from circuits.silicon.die import Path
from circuits.silicon.process import Polarity
from circuits.silicon.silicon import Silicon

RECORD = "lso_neuron"
SIDES = 2  # left, right
LEAST_AREA = 1.0 / 16.0  # of the circuits' devices, down to which the model was measured


class Head(NamedTuple):
    """Numbers of a die; s sides, k level units or synapses. Currents in A, charges in C, times in s.

    excite, inhibit: [s, k], currents of the LSO neurons' synapses; excite_step, inhibit_step: [s, k], how
    long; charge: [s], of a spike; onset, dead: of an event and after a spike; turn: of the mirror's gate;
    mirror_in, mirror_out, mirror_shift: [s], as of `chips.lso.law.Mirror`; offset: [s, k], V, of a level
    unit's threshold; rest: [s, k], V, how far below it an input at rest must be; level_current: [s, k];
    level_charge; kappa, u_t: of the level units' law.
    """

    excite: F64
    inhibit: F64
    excite_step: F64
    inhibit_step: F64
    charge: F64
    onset: float
    dead: float
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


def head_on(silicon: Silicon, kind: BiasKind = "gate", area: float = 1.0) -> Head:
    """Numbers of the head on the silicon; area: of the drawn devices over the circuits'.

    Raises `ParameterError` for an area and for silicon outside the record's box, `DataError` where
    the record is of other circuits.
    """
    if not LEAST_AREA <= area < math.inf:
        raise ParameterError(
            f"{NAME}.area: {area:g} times the circuits', must be finite and at least {LEAST_AREA:g}, where"
            " the behavioural model was measured"
        )
    check_law(silicon.process)
    check_box(NAME, silicon)
    return _Maker(silicon, kind, area).make()


def level_times(head: Head, crossed: F64, slope: F64) -> F64:
    """Spikes (s) of level units whose thresholds are passed at `crossed` (s, inf for none) at `slope` (V/s).

    float64[SIDES, LEVELS] each.
    """
    on = np.isfinite(crossed)
    found = np.full(crossed.shape, np.inf)
    found[on] = crossed[on] + ramp_delay(
        slope[on], head.level_charge, head.level_current[on], head.kappa, head.u_t
    )
    return found


def side_spikes(head: Head, side: int, level: F64, *, inhibited: bool = True) -> F64:
    """Spikes (s) of an LSO neuron after level units' spikes, float64[SIDES, LEVELS], inf for none."""
    return lso_spikes(*side_inputs(head, side, level, inhibited=inhibited))


def side_inputs(
    head: Head, side: int, level: F64, *, inhibited: bool = True
) -> tuple[Steps, Steps, Membrane, Mirror]:
    """Steps of excitation and inhibition, membrane and mirror of an LSO neuron, as of `side_spikes`."""
    far = level[1 - side] if inhibited else np.full(level.shape[1], np.inf)
    excitation = Steps(level[side] + head.onset, head.excite_step[side], head.excite[side])
    inhibition = Steps(far + head.onset, head.inhibit_step[side], head.inhibit[side])
    charge = float(head.charge[side])
    membrane = Membrane(charge / REFERENCE, REFERENCE, head.dead, head.u_t, head.turn)
    mirror = Mirror(float(head.mirror_in[side]), float(head.mirror_out[side]), float(head.mirror_shift[side]))
    return excitation, inhibition, membrane, mirror


class _Maker:
    """A die's draws and voltages while its numbers are made."""

    def __init__(self, silicon: Silicon, kind: BiasKind, area: float) -> None:
        self.silicon = of_area(silicon, area)
        self.volts = line_volts(self.silicon, kind)
        self.tables = matching_tables(RECORD, circuits, silicon.process).values
        found = all_on_silicon(self.tables, QUANTITIES, silicon)
        self.charge = {name: float(value) for name, value in zip(QUANTITIES, found, strict=True)}
        self.lso, self.level = circuits()

    def make(self) -> Head:
        q, lso = self.charge, self.lso
        side: Path = (("lso", (SIDES,)),)
        ear: Path = (("ear", (SIDES,)), ("level", (LEVELS,)))
        comparator = self.current(lso, "cell.threshold.mc0", None)
        level_path = (*ear, ("generator", ()), ("comparator", ()))
        currents = {name: self.synapses(side, name, "me") for name in ("excite", "inhibit")}
        steps = {name: WIDTH + self.times(side, name) for name in currents}
        ends = self.offsets((*side, ("cell", ()), ("threshold", ())), lso, "cell.threshold", COMPARATOR)
        given, taken, shift = self.mirror(lso, side, ("md", "mk"))
        law = self.silicon.law("p")
        return Head(
            excite=currents["excite"],
            inhibit=currents["inhibit"],
            excite_step=steps["excite"],
            inhibit_step=steps["inhibit"],
            charge=q["membrane"] * np.exp(ends @ self.slopes("comparator")),
            onset=q["onset"] / float(comparator),
            dead=q["dead"] / float(comparator),
            turn=q["turn"],
            mirror_in=given,
            mirror_out=q["mirror"] * taken,
            mirror_shift=shift,
            offset=q["level_offset"]
            + self.offsets(level_path, self.level, "generator.comparator", LEVEL_COMPARATOR)
            @ self.slopes("level"),
            rest=self.rest(level_path),
            level_current=self.current(self.level, "generator.comparator.mc3", level_path),
            level_charge=q["level_charge"],
            kappa=law.kappa,
            u_t=law.u_t,
        )

    def synapses(self, side: Path, name: str, device: str) -> F64:
        """Currents of a device of each synapse of an input, [SIDES, LEVELS]."""
        each = [
            self.current(self.lso, f"{name}{k}.{device}", (*side, (f"{name}{k}", ()))) for k in range(LEVELS)
        ]
        return np.stack(each, axis=-1)

    def times(self, side: Path, name: str) -> F64:
        """Charge over current of each synapse's timer, [SIDES, LEVELS]."""
        ends = [
            self.offsets((*side, (f"{name}{k}", ()), ("timer", ())), self.lso, f"{name}{k}.timer", COMPARATOR)
            for k in range(LEVELS)
        ]
        charges = self.charge["timer"] * np.exp(np.stack(ends, axis=1) @ self.slopes("comparator"))
        return np.asarray(charges / self.synapses(side, name, "mt"))

    def slopes(self, table: str) -> F64:
        """Slopes of the record at the silicon's temperature."""
        return np.asarray(temperature_weights(self.silicon.temperature_c) @ self.tables[table])

    def offsets(self, path: Path, circuit: Circuit, part: str, devices: tuple[str, ...]) -> F64:
        """V_T0 (V) and ln beta of devices of a part at a path, [shape of the path, 2 devices]."""
        shape = tuple(n for _, dims in path for n in dims)
        areas = np.array([area_of(circuit, f"{part}.{d}") for d in devices])
        paths = [(*path, (d, ())) for d in devices]
        v_t0, beta = self.silicon.deviations(NAME, paths, np.repeat(areas, math.prod(shape)))
        count = len(devices) * math.prod(shape)
        moved = np.stack([np.broadcast_to(v_t0, count), np.log1p(np.broadcast_to(beta, count))])
        each = moved.reshape(2, len(devices), *shape)
        return np.moveaxis(each, (1, 0), (-2, -1)).reshape(*shape, 2 * len(devices))

    def rest(self, path: Path) -> F64:
        """How far below its threshold each level unit's input must rest to be heard, V, [SIDES, LEVELS]."""
        part, law = "generator.comparator", self.silicon.law("p")
        tail, least = (self.current(self.level, f"{part}.{m}", path) for m in ("mc3", "mc7"))
        pair = law.square_current * square_of(self.level, f"{part}.mc1")
        own = self.offsets(path, self.level, part, LEVEL_COMPARATOR[:2]) @ self.slopes("level")[:4]
        mirror = self.mirror(self.level, path, (f"{part}.mc4", f"{part}.mc6"))
        return rest_depth(tail, least, mirror, pair, law.kappa, law.u_t) - own

    def mirror(self, circuit: Circuit, path: Path, devices: tuple[str, str]) -> tuple[F64, F64, F64]:
        """Specific currents of nFET mirrors, in and out (A), and their shifts, [shape of the path] each."""
        law, found = self.silicon.law("n"), []
        shape = tuple(n for _, dims in path for n in dims)
        for name in devices:
            area = area_of(circuit, name)
            v_t0, beta = self.silicon.deviation(NAME, (*path, (name.rpartition(".")[2], ())), area)
            specific = law.square_current * square_of(circuit, name) * (1.0 + np.asarray(beta))
            count = max(1, math.prod(shape))
            found.append([np.broadcast_to(x, count).reshape(shape) for x in (v_t0, specific)])
        (v_in, given), (v_out, taken) = found
        return given, taken, np.asarray(0.5 * law.kappa * (v_in - v_out) / law.u_t)

    def current(self, circuit: Circuit, device: str, path: Path | None) -> F64:
        """Saturated currents of a device of the circuit at a path, A, [its shape]; nominal without one."""
        found = transistor_of(circuit, device)
        shape: tuple[int, ...] = ()
        v_t0: F64 | float = 0.0
        beta: F64 | float = 0.0
        if path is not None:
            shape = tuple(n for _, dims in path for n in dims)
            where = (*path, (found.name, ()))
            v_t0, beta = self.silicon.deviation(NAME, where, area_of(circuit, device))
        law = self.silicon.law(found.polarity)
        half = (
            0.5 * law.kappa * (self._gate(found.gate, found.polarity) - law.v_t0 - np.asarray(v_t0)) / law.u_t
        )
        specific = law.square_current * (1.0 + np.asarray(beta)) * square_of(circuit, device)
        flat = specific * np.logaddexp(0.0, half) ** 2
        return np.asarray(np.broadcast_to(flat, max(1, math.prod(shape))).reshape(shape))

    def _gate(self, port: str, polarity: Polarity) -> float:
        """A line's voltage from the bulk of the devices that it biases, V."""
        return self.silicon.process.v_dd - self.volts[port] if polarity == "p" else self.volts[port]
