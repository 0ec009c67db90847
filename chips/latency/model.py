"""Behavioural model of the latency chip: every charge, current and time of its blocks on a die.

A time is a charge over a current, T = Q / I. The current is the law's own for the device on this die,

    I = I_S (1 + beta) ln^2(1 + e^(kappa (v_gate - V_T0 - dV_T) / 2 U_T)),

saturated; under the full law it is that of a drain halfway less what switches leak (`chips.latency.swing`).
The charge is the record's (`chips.latency.measure`) with the offset of the comparator that ends it,
`Q = (Q_0 + V_ref dC) (1 + sum_d g_d x_d)` over the deviations of its seven devices, where its capacitor has
dC more than drawn. All deviations are those that the transistor level draws for the same devices at the same
places of the chip. Left out: mismatch of switches but for what they leak, of inverters and gates, and of what
makes a tap's event. With devices an eighth as large
the errors are those of the record (dies A/500 to A/517, no time more than 1.7 % off); with a 16th INH's
period is up to 51 % off. Under the full law INH's spike may leave its membrane part of its charge, so that
later periods are shorter than the first one, which is the model's: as long as they are shorter than a block,
a unit answers alike.

Places: `tap[16]` (the lead first), `memory[33]` with `neuron` and `unit[15]`, `first[33]`, `second[33]`,
`recurrent[2]`, `emergency`, each as its block has it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from chips.latency.design import (
    NAME,
    REACH,
    REFERENCE,
    Biases,
    Charges,
    Design,
    Lines,
    bias_circuit,
    gate_voltages,
    lines_of,
)
from chips.latency.measure import QUANTITIES, SYNAPSES, circuits
from chips.latency.swing import (
    detector_threshold,
    halfway,
    idle_inhibition,
    swing_current,
    taken_at,
)
from chips.measured.table_record import (
    all_on_silicon,
    check_box,
    check_temperature,
    tables_of,
    temperature_weights,
)
from chips.measured.timer import COMPARATOR
from chips.validity import require_area
from circuits.arrays import F64, I64
from circuits.blocks.latency import neuron, unit
from circuits.blocks.latency.coincidence import INPUTS
from circuits.blocks.latency.layer import RECURRENT_CAPACITANCE, recurrent_inhibition
from circuits.blocks.latency.parts import TIMER, following_cell, lone_cell, racing_cell
from circuits.blocks.latency.tap import delay_tap
from circuits.circuit import BiasKind, Circuit
from circuits.devices import Capacitor
from circuits.errors import ParameterError
from circuits.event import WIDTH
from circuits.lowering.capacitors_on_die import added_capacitance
from circuits.lowering.on_die import device_names, on_die, transistor_names
from circuits.silicon.die import Path
from circuits.silicon.process import AMI_1500_IDEAL, Polarity, Process
from circuits.silicon.silicon import Silicon

LEAST_AREA = 0.125  # of the devices, ours: down to where errors were looked at and are the record's
_ROUNDS = 3  # of lines of the usual biases, each of which leaves a hundredth of the error; ours
_NO_TIMES = {"cd", "comparator"}  # lines whose current fills no capacitor
_LEAST = 1e-6  # of a current, that is left where switches leak more; ours
_SWITCHES = ("mr", "mz", "mx", "mq", "ms")  # devices that leak under the full law
_SOURCES = ("me", "mk", "md", "mp", "mt")  # devices whose current is a bias or a copy of one


class Lumped(NamedTuple):
    """Numbers of a latency chip on a die; currents in A, charges in C, times in s.

    There are n paths, u units of each and k taps, the lead included. tap: from an event to the next,
    float64[k]; synapse, step: current and length of the integrating neurons' inputs, [n, SYNAPSES];
    leak, integrating: what their switches take, A, and the charge of a spike, [n]; seen, window: current and
    length of the detectors' inputs, [n, u, 3]; taken: current that is taken from them, [n, u]; sum: charge of
    their node; hold, tonic, block: [n, u]; passive, race: current less what leaks, and charge of the first
    layer, [n]; goal: current into each cell (row) by each goal neuron, [n, n]; direction, goal_pulse,
    direction_pulse: [n]; inhibit, inhibition: current and length by the memory's place from the cell's left,
    [n, 2 REACH + 1]; second, second_charge: of the second layer, [n]; recurrent: [2]; emergency; group:
    int64[n].
    """

    tap: F64
    synapse: F64
    step: F64
    leak: F64
    integrating: F64
    seen: F64
    window: F64
    taken: F64
    sum: float
    hold: F64
    tonic: F64
    block: F64
    passive: F64
    race: F64
    goal: F64
    direction: F64
    goal_pulse: F64
    direction_pulse: F64
    inhibit: F64
    inhibition: F64
    second: F64
    second_charge: F64
    recurrent: F64
    emergency: float
    group: I64


# fields whose deviations are a block's own
BLOCKS: Mapping[str, tuple[str, ...]] = {
    "delay line": ("tap",),
    "integrating neurons": ("synapse", "step", "leak", "integrating"),
    "detectors": ("seen", "window", "taken", "sum"),
    "inhibition of B": ("hold", "tonic", "block"),
    "first layer": (
        "passive", "race", "goal", "direction", "goal_pulse", "direction_pulse", "inhibit", "inhibition",
    ),
    "second layer": ("second", "second_charge"),
    "recurrent inhibition": ("recurrent", "emergency"),
}  # fmt: skip


def only(die: Lumped, ideal: Lumped, block: str) -> Lumped:
    """Return the numbers of `ideal`, but those of one of `BLOCKS` of the die.

    Raises `ParameterError` for another block.
    """
    if block not in BLOCKS:
        raise ParameterError(f"{NAME}.block: {block}, must be one of {', '.join(BLOCKS)}")
    return ideal._replace(**{name: getattr(die, name) for name in BLOCKS[block]})


def nominal_charges(process: Process = AMI_1500_IDEAL) -> Charges:
    """Return the charges of the nominal die at 27 degC."""
    q = charges_on(Silicon(process))
    return Charges(
        q["timer"], q["tap"], q["tonic"], q["integrating"], q["race"], q["second"], q["recurrent"],
        q["pulse_width"],
    )  # fmt: skip


def usual_biases(design: Design, kind: BiasKind = "gate", process: Process = AMI_1500_IDEAL) -> Biases:
    """Return the biases that give the design's times on the nominal die of a process at 27 degC.

    Under the full law what switches leak, 0.3 % of a cell's current, is not made up for.
    """
    lines = lines_of(design, nominal_charges(process))
    return Biases(lines if process.effects == "ideal" else _at_gates(lines, process), kind)


def _at_gates(lines: Lines, process: Process) -> Lines:
    """Lines of the currents that biases state, with drains at gates, for those that fill capacitors."""
    silicon, found = Silicon(process), dict(lines)
    devices = on_die(bias_circuit(Biases(lines)), silicon)
    for _ in range(_ROUNDS):
        gates = gate_voltages(Biases(found), silicon)
        for name in found.keys() - _NO_TIMES:
            wanted, line = lines[name].current, found[name]
            filling = swing_current(devices, f"m_{name}", gates[name], line.polarity)
            found[name] = replace(line, current=line.current * wanted / filling)
    return found


def require_temperature(silicon: Silicon) -> None:
    """Raise `ParameterError`, as `chips.validity` says, at a temperature outside the record's box."""
    check_temperature(NAME, silicon, tables_of(NAME, circuits, silicon.process))


def lumped(design: Design, biases: Biases, silicon: Silicon, area: float = 1.0) -> Lumped:
    """Return the numbers of a design with its biases on a silicon.

    area: of the drawn devices over the circuits'. Raises `ParameterError` for an area that is not above 0 and
    for silicon outside the record's box, and `DataError` where the record is of other circuits.
    """
    require_area(NAME, area, LEAST_AREA)
    check_box(NAME, silicon, tables_of(NAME, circuits, silicon.process))
    return _Maker(design, biases, silicon, area).make()


def charges_on(silicon: Silicon) -> dict[str, float]:
    """Return the charges of the record on a silicon without mismatch, C, by `QUANTITIES`."""
    tables = tables_of(NAME, circuits, silicon.process)
    found = all_on_silicon(tables, QUANTITIES, silicon)
    return {name: float(value) for name, value in zip(QUANTITIES, found, strict=True)}


class _Maker:
    """A die's devices and voltages while its numbers are made."""

    def __init__(self, design: Design, biases: Biases, silicon: Silicon, area: float) -> None:
        self.design = design
        self.gate = gate_voltages(biases, silicon)
        self.charge = charges_on(silicon)
        tables = tables_of(NAME, circuits, silicon.process)
        # of V_T0 and ln beta of each device in turn, as of `DieDevices.offset`
        self.gradient = temperature_weights(tables, silicon.temperature_c) @ tables["comparator"]
        self.silicon = silicon
        n, u = design.paths, design.taps
        places: Mapping[str, Path] = {
            "tap": (("tap", (u + 1,)),),
            "neuron": (("memory", (n,)), ("neuron", ())),
            "unit": (("memory", (n,)), ("unit", (u,))),
            "first": (("first", (n,)),),
            "second": (("second", (n,)),),
            "recurrent": (("recurrent", (2,)),),
            "emergency": (("emergency", ()),),
        }
        self.capacitor = {
            name: added_capacitance(circuit, silicon, _capacitors(circuit), ((NAME, ()), *places[name]))
            for name, circuit in _parts(n).items()
        }
        self.part = {
            name: on_die(circuit, silicon.of_area(area), _used(circuit, silicon), ((NAME, ()), *places[name]))
            for name, circuit in _parts(n).items()
        }

    def make(self) -> Lumped:
        d, q = self.design, self.charge
        n, u = d.paths, d.taps
        ends = np.full(u + 1, q["pulse_width"])
        ends[0] = WIDTH
        spans = 2 * REACH + 1
        apart = np.abs(np.arange(spans) - REACH)
        offsets = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
        goal = swing_current(self.part["first"], "excite0.me", self.gate["goal"][offsets].T).T
        off = np.zeros((n, spans)) + self.each(
            spans,
            lambda k: np.asarray(
                idle_inhibition(self.part["first"], f"inhibit{k}.", self.gate["inhibit"][apart[k]])
            ),
        )
        return Lumped(
            tap=ends + self.time("tap", "mt", "tap", self.held("tap", "tap", "timer", "ct"), "mr"),
            synapse=self.each(SYNAPSES, lambda k: self.current(
                "neuron", f"synapse{k}.me", self.gate["integrating"])),
            step=WIDTH + self.each(SYNAPSES, lambda k: self.step("neuron", f"synapse{k}.", "step")),
            leak=np.ascontiguousarray(np.zeros(n) + self.idle("neuron", "mz")),
            integrating=self.held("neuron", "integrating", "threshold", "cm"),
            seen=self.each(len(INPUTS), lambda k: self.seen(f"cd.input{k}.me")),
            window=q["pulse_width"] + self.each(
                len(INPUTS), lambda k: self.step("unit", f"cd.input{k}.", "window")),
            taken=self.taken(),
            sum=q["sum"],
            hold=self.step("unit", "inh.hold.", "hold"),
            tonic=self.time(
                "unit", "inh.cell.mp", "tonic",
                self.held("unit", "tonic", "inh.cell.threshold", "inh.cell.cm"),
                *(f"inh.cell.{name}" for name in ("mz", "mx", "mq"))),
            block=self.step("unit", "gate.", "block"),
            passive=self.current("first", "mp", self.gate["passive"]) - (
                self.idle("first", "mz", "mx") + off.sum(axis=-1)),
            race=self.held("first", "race", "threshold", "cm"),
            goal=np.ascontiguousarray(goal),
            direction=self.current("first", "excite1.me", self.gate["direction"]),
            goal_pulse=WIDTH + self.step("first", "excite0.", "pulse"),
            direction_pulse=WIDTH + self.step("first", "excite1.", "pulse"),
            inhibit=self.each(spans, lambda k: self.current(
                "first", f"inhibit{k}.mk", self.gate["inhibit"][apart[k]], "n")) - off,
            inhibition=self.each(spans, lambda k: self.step("first", f"inhibit{k}.", "inhibition")),
            second=self.current("second", "excite0.me", self.gate["second"][np.array(d.group)])
            - self.idle("second", "mz", "mx"),
            second_charge=self.held("second", "second", "threshold", "cm"),
            recurrent=self.time(
                "recurrent", "mt", "recurrent", self.held("recurrent", "recurrent", "timer", "cr"), "mz"),
            emergency=float(self.time(
                "emergency", "mp", "emergency", self.held("emergency", "race", "threshold", "cm"),
                "mz", "mx")),
            group=np.array(d.group, dtype=np.int64),
        )  # fmt: skip

    def each(self, count: int, make: Callable[[int], F64]) -> F64:
        """Arrays of a device of each of `count` parts, stacked last."""
        return np.ascontiguousarray(np.stack([make(k) for k in range(count)], axis=-1))

    def step(self, part: str, inside: str, line: str) -> F64:
        """Length of a step: of the timer inside a part, s."""
        held = self.held(part, "timer", f"{inside}timer", f"{inside}ct")
        return self.time(part, f"{inside}mt", line, held, f"{inside}mr")

    def held(self, part: str, charge: str, comparator: str, capacitor: str) -> F64:
        """A charge of the record that a comparator ends, with what the capacitor has on the die, C."""
        more = self.capacitor[part][capacitor]
        return (self.charge[charge] + REFERENCE * more) * self.offset(part, comparator)

    def time(self, part: str, device: str, line: str, charge: F64, *idle: str) -> F64:
        """A charge (C) over what flows of the current of a part's device, s.

        idle: devices that are off and take some of the current. Where they take all but `_LEAST` of it, so
        much is left: the step is beyond any run.
        """
        current = self.current(part, device, self.gate[line])
        left = np.maximum(current - self.idle(part, *idle), _LEAST * current)
        return np.asarray(charge / left)

    def idle(self, part: str, *devices: str) -> F64 | float:
        """What devices of a part that are off take, A."""
        return self.part[part].idle(*devices, drain=halfway("n", self.part[part].v_dd))

    def offset(self, part: str, comparator: str) -> F64:
        """Factor of a charge by the offset of the comparator that ends it."""
        each = self.part[part].offset(*(f"{comparator}.{name}" for name in COMPARATOR))
        return np.asarray(1.0 + each @ self.gradient)

    def current(self, part: str, device: str, gate: F64, polarity: Polarity = "p") -> F64:
        """Current by which a device fills a capacitor, A; gate: V from its bulk, of an array or of all."""
        d = self.part[part]
        missing = d.fet[device].threshold.ndim - gate.ndim
        return swing_current(d, device, gate.reshape(gate.shape + (1,) * missing), polarity)

    @cached_property
    def detector(self) -> float:
        """Voltage of a detector's node at which its currents are compared under the full law, V."""
        return detector_threshold(self.silicon)

    def seen(self, device: str) -> F64:
        """What an input of a coincidence detector gives, A."""
        d, gate = self.part["unit"], self.gate["cd"]
        return d.current(device, gate, d.v_dd - self.detector) if d.full else d.saturated(device, gate)

    def taken(self) -> F64:
        """What the mirror of a coincidence detector takes, A: a copy of what `cd.me` gives."""
        d, gate = self.part["unit"], self.gate["cd"]
        if d.full:
            return taken_at(d, gate, self.detector, "cd.")
        return d.mirror("cd.md", "cd.mk").copied(d.saturated("cd.me", gate))


@lru_cache(maxsize=4)
def _parts(paths: int) -> Mapping[str, Circuit]:
    """Circuits that stand at the places of the chip, by the chip's word for them."""
    return {
        "tap": delay_tap(TIMER),
        "neuron": neuron.build(neuron.Params(synapses=SYNAPSES)),
        "unit": unit.build(),
        "first": racing_cell(REACH),
        "second": following_cell(),
        "recurrent": recurrent_inhibition(RECURRENT_CAPACITANCE, paths + 1),
        "emergency": lone_cell(),
    }


def _capacitors(circuit: Circuit) -> tuple[str, ...]:
    """Capacitors that a current fills up to the reference."""
    return tuple(n for n in device_names(circuit, Capacitor) if n.rpartition(".")[2] in ("ct", "cm", "cr"))


def _used(circuit: Circuit, silicon: Silicon) -> tuple[str, ...]:
    """Transistors whose deviations count: of comparators, and those whose current is meant, or leaks."""
    counted = (*_SOURCES, *COMPARATOR, *(_SWITCHES if silicon.process.effects == "full" else ()))
    return tuple(n for n in transistor_names(circuit) if n.rpartition(".")[2] in counted)
