"""Behavioural model of the latency chip: every charge, current and time of its blocks on a die.

A time is a charge over a current, T = Q / I. The current is the law's own for the device on this die,

    I = I_S (1 + beta) ln^2(1 + e^(kappa (v_gate - V_T0 - dV_T) / 2 U_T)),

saturated; the charge is the record's (`chips.latency.measure`) with the offset of the comparator that
ends it, `Q = Q_0 (1 + sum_d g_d x_d)` over the deviations of its seven devices. All deviations are those that
the transistor level draws for the same devices at the same places of the chip. Left out: mismatch of
switches, inverters and gates, and of what makes a tap's event. With devices an eighth as large the errors are
those of the record (dies A/500 to A/517, no time more than 1.7 % off); with a 16th INH's period is up to 51 %
off.

Places: `tap[16]` (the lead first), `memory[33]` with `neuron` and `unit[15]`, `first[33]`, `second[33]`,
`recurrent[2]`, `emergency`, each as its block has it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chips.latency.design import NAME, REACH, Biases, Charges, Design, gate_voltages, lines_of
from chips.latency.measure import QUANTITIES, SYNAPSES, circuits
from chips.measured.table_record import all_on_silicon, check_box, tables_of, temperature_weights
from chips.measured.timer import COMPARATOR
from chips.model_law import check_capacitors, check_law
from chips.validity import require_area
from circuits.arrays import F64, I64
from circuits.blocks.latency import neuron, unit
from circuits.blocks.latency.coincidence import INPUTS
from circuits.blocks.latency.layer import RECURRENT_CAPACITANCE, recurrent_inhibition
from circuits.blocks.latency.parts import TIMER, following_cell, lone_cell, racing_cell
from circuits.blocks.latency.tap import delay_tap
from circuits.circuit import BiasKind, Circuit
from circuits.errors import ParameterError
from circuits.event import WIDTH
from circuits.lowering.on_die import on_die, transistor_names
from circuits.silicon.die import Path
from circuits.silicon.process import AMI_1500, Process
from circuits.silicon.silicon import Silicon

LEAST_AREA = 0.125  # of the devices, ours: down to where errors were looked at and are the record's
_SOURCES = ("me", "mk", "md", "mp", "mt")  # devices whose current is a bias or a copy of one


class Lumped(NamedTuple):
    """Numbers of a latency chip on a die; currents in A, charges in C, times in s.

    There are n paths, u units of each and k taps, the lead included. tap: from an event to the next,
    float64[k]; synapse, step: current and length of the integrating neurons' inputs, [n, SYNAPSES];
    integrating: charge of a spike, [n]; seen, window: current and length of the detectors' inputs, [n, u, 3];
    taken: current that is taken from them, [n, u]; sum: charge of their node; hold, tonic, block: [n, u];
    passive, race: current and charge of the first layer, [n]; goal: current into each cell (row) by each goal
    neuron, [n, n]; direction, goal_pulse, direction_pulse: [n]; inhibit, inhibition: current and length by
    the memory's place from the cell's left, [n, 2 REACH + 1]; second, second_charge: of the second layer,
    [n]; recurrent: [2]; emergency; group: int64[n].
    """

    tap: F64
    synapse: F64
    step: F64
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
    "integrating neurons": ("synapse", "step", "integrating"),
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


def nominal_charges(process: Process = AMI_1500) -> Charges:
    """Return the charges of the nominal die at 27 degC."""
    q = charges_on(Silicon(process))
    return Charges(
        q["timer"], q["tap"], q["tonic"], q["integrating"], q["race"], q["second"], q["recurrent"],
        q["pulse_width"],
    )  # fmt: skip


def usual_biases(design: Design, kind: BiasKind = "gate") -> Biases:
    """Return the biases that give the design's times on the nominal die at 27 degC."""
    return Biases(lines_of(design, nominal_charges()), kind)


def lumped(design: Design, biases: Biases, silicon: Silicon, area: float = 1.0) -> Lumped:
    """Return the numbers of a design with its biases on a silicon.

    area: of the drawn devices over the circuits'. Raises `ParameterError` for an area that is not above 0 and
    for silicon outside the record's box, and `DataError` where the record is of other circuits.
    """
    require_area(NAME, area, LEAST_AREA)
    check_law(silicon.process)
    check_capacitors(NAME, silicon.die)
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
        self.part = {
            name: on_die(circuit, silicon.of_area(area), _used(circuit), ((NAME, ()), *places[name]))
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
        goal = self.part["first"].saturated("excite0.me", self.gate["goal"][offsets].T).T
        return Lumped(
            tap=ends + self.time("tap", "mt", "tap", "tap", "timer"),
            synapse=self.each(SYNAPSES, lambda k: self.current(
                "neuron", f"synapse{k}.me", self.gate["integrating"])),
            step=WIDTH + self.each(SYNAPSES, lambda k: self.step("neuron", f"synapse{k}.", "step")),
            integrating=q["integrating"] * self.offset("neuron", "threshold"),
            seen=self.each(len(INPUTS), lambda k: self.current("unit", f"cd.input{k}.me", self.gate["cd"])),
            window=q["pulse_width"] + self.each(
                len(INPUTS), lambda k: self.step("unit", f"cd.input{k}.", "window")),
            taken=self.taken(),
            sum=q["sum"],
            hold=self.step("unit", "inh.hold.", "hold"),
            tonic=self.time("unit", "inh.cell.mp", "tonic", "tonic", "inh.cell.threshold"),
            block=self.step("unit", "gate.", "block"),
            passive=self.current("first", "mp", self.gate["passive"]),
            race=q["race"] * self.offset("first", "threshold"),
            goal=np.ascontiguousarray(goal),
            direction=self.current("first", "excite1.me", self.gate["direction"]),
            goal_pulse=WIDTH + self.step("first", "excite0.", "pulse"),
            direction_pulse=WIDTH + self.step("first", "excite1.", "pulse"),
            inhibit=self.each(spans, lambda k: self.current(
                "first", f"inhibit{k}.mk", self.gate["inhibit"][apart[k]])),
            inhibition=self.each(spans, lambda k: self.step("first", f"inhibit{k}.", "inhibition")),
            second=self.current("second", "excite0.me", self.gate["second"][np.array(d.group)]),
            second_charge=q["second"] * self.offset("second", "threshold"),
            recurrent=self.time("recurrent", "mt", "recurrent", "recurrent", "timer"),
            emergency=float(self.time("emergency", "mp", "emergency", "race", "threshold")),
            group=np.array(d.group, dtype=np.int64),
        )  # fmt: skip

    def each(self, count: int, make: Callable[[int], F64]) -> F64:
        """Arrays of a device of each of `count` parts, stacked last."""
        return np.ascontiguousarray(np.stack([make(k) for k in range(count)], axis=-1))

    def step(self, part: str, inside: str, line: str) -> F64:
        """Length of a step: of the timer inside a part, s."""
        return self.time(part, f"{inside}mt", line, "timer", f"{inside}timer")

    def time(self, part: str, device: str, line: str, charge: str, comparator: str) -> F64:
        """Charge over current of a part's device, the charge ended by a comparator, s."""
        current = self.current(part, device, self.gate[line])
        return np.asarray(self.charge[charge] * self.offset(part, comparator) / current)

    def offset(self, part: str, comparator: str) -> F64:
        """Factor of a charge by the offset of the comparator that ends it."""
        each = self.part[part].offset(*(f"{comparator}.{name}" for name in COMPARATOR))
        return np.asarray(1.0 + each @ self.gradient)

    def current(self, part: str, device: str, gate: F64) -> F64:
        """Saturated current of a device, A; gate: V from its bulk, of the first of its arrays or of all."""
        d = self.part[part]
        missing = d.fet[device].threshold.ndim - gate.ndim
        return d.saturated(device, gate.reshape(gate.shape + (1,) * missing))

    def taken(self) -> F64:
        """What the mirror of a coincidence detector takes, A: a copy of what `cd.me` gives."""
        return (
            self.part["unit"].mirror("cd.md", "cd.mk").copied(self.current("unit", "cd.me", self.gate["cd"]))
        )


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


def _used(circuit: Circuit) -> tuple[str, ...]:
    """Transistors whose deviations count: those of comparators, and those whose current is meant."""
    return tuple(n for n in transistor_names(circuit) if n.rpartition(".")[2] in (*_SOURCES, *COMPARATOR))
