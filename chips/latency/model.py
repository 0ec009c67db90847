"""Lumped latency chip: every charge, current and time of its blocks on a die, at a temperature.

A time is a charge over a current, T = Q / I. The current is the law's own for the device on this die,

    I = I_S (1 + beta) ln^2(1 + e^(kappa (v_gate - V_T0 - dV_T) / 2 U_T)),

saturated; the charge is the record's (`chips.latency.measure`) with the offset of the comparator that
ends it, `Q = Q_0 (1 + sum_d g_d x_d)` over the deviations of its seven devices. All deviations are those that
the transistor level draws for the same devices at the same places of the chip. Left out: mismatch of
switches, inverters and gates, and of what makes a tap's event.

Places: `tap[16]` (the lead first), `memory[33]` with `neuron` and `unit[15]`, `first[33]`, `second[33]`,
`recurrent[2]`, `emergency`, each as its block has it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from chips.latency.design import NAME, REACH, Biases, Charges, Design, gate_voltages, lines_of
from chips.latency.measure import COMPARATOR, QUANTITIES, SYNAPSES, circuits
from chips.model_law import check_law
from chips.table_record import all_on_silicon, check_box, matching_tables, temperature_weights
from circuits.arrays import F64, I64
from circuits.blocks.latency.coincidence import INPUTS, SHARE
from circuits.blocks.latency.synapse import WIDTH, comparator
from circuits.circuit import BiasKind
from circuits.devices import Transistor
from circuits.errors import ParameterError
from circuits.silicon.die import Path
from circuits.silicon.process import AMI_1500, Process
from circuits.silicon.silicon import Silicon

SIZE = (6.0, 24.0)  # um, of all devices whose current is a bias
_UM2 = 1e-12


class Lumped(NamedTuple):
    """Numbers of a die. Currents in A, charges in C, times in s; n paths, u units, k taps with the lead.

    tap: float64[k], from an event to the next; synapse, step: [n, SYNAPSES], of the integrating neurons;
    integrating: [n], charge; seen, window: [n, u, 3], of the coincidence detectors' inputs; taken: [n, u];
    sum: charge of their node; hold, tonic, block: [n, u]; passive, race: [n], current and charge of the
    first layer; goal: [n, n], current into each cell (row) by each goal neuron; direction, goal_pulse,
    direction_pulse: [n]; inhibit, inhibition: [n, 2 REACH + 1], current and length, by the memory's place
    from the cell's left; second, second_charge: [n]; recurrent: [2]; emergency; group: int64[n].
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
    """Numbers of `ideal`, but those of one of `BLOCKS` of the die."""
    if block not in BLOCKS:
        raise ParameterError(f"{NAME}.block: {block}, must be one of {', '.join(BLOCKS)}")
    return ideal._replace(**{name: getattr(die, name) for name in BLOCKS[block]})


def nominal_charges(process: Process = AMI_1500) -> Charges:
    """Charges of the nominal die at 27 degC."""
    q = charges_on(Silicon(process))
    return Charges(
        q["timer"], q["tap"], q["tonic"], q["integrating"], q["race"], q["second"], q["recurrent"],
        q["pulse_width"],
    )  # fmt: skip


def usual_biases(design: Design, kind: BiasKind = "gate") -> Biases:
    """Biases that give the design's times on the nominal die at 27 degC."""
    return Biases(lines_of(design, nominal_charges()), kind)


def lumped(design: Design, biases: Biases, silicon: Silicon, area: float = 1.0) -> Lumped:
    """Numbers of a design with its biases on the silicon; area: of the drawn devices over the circuits'.

    Raises `ParameterError` for an area that is none and silicon outside the record's box, `DataError` where
    the record is of other circuits.
    """
    if not (math.isfinite(area) and area > 0.0):
        raise ParameterError(f"{NAME}.area: {area:g} times the circuits', must be > 0")
    check_law(silicon.process)
    check_box(NAME, silicon)
    return _Maker(design, biases, silicon, area).make()


def charges_on(silicon: Silicon) -> dict[str, float]:
    """Charges of the record on the silicon without mismatch, C, by `QUANTITIES`."""
    tables = matching_tables(NAME, circuits, silicon.process).values
    found = all_on_silicon(tables, QUANTITIES, silicon)
    return {name: float(value) for name, value in zip(QUANTITIES, found, strict=True)}


class _Maker:
    """A die's draws and voltages while its numbers are made."""

    def __init__(self, design: Design, biases: Biases, silicon: Silicon, area: float) -> None:
        self.design, self.silicon, self.area = design, silicon, area
        self.gate = gate_voltages(biases, silicon)
        self.charge = charges_on(silicon)
        tables = matching_tables(NAME, circuits, silicon.process).values
        weights = temperature_weights(silicon.temperature_c)
        self.gradient = (weights @ tables["comparator"]).reshape(len(COMPARATOR), 2)
        part = comparator()
        devices = (part.device(name) for name in COMPARATOR)
        self.comparator_area = np.array(
            [d.width * d.length for d in devices if isinstance(d, Transistor)], dtype=np.float64
        )

    def make(self) -> Lumped:
        d, q = self.design, self.charge
        n, u = d.paths, d.taps
        memory: Path = (("memory", (n,)),)
        unit: Path = (*memory, ("unit", (u,)))
        first: Path = (("first", (n,)),)
        second: Path = (("second", (n,)),)
        line: Path = (("tap", (u + 1,)),)
        ends = np.full(u + 1, q["pulse_width"])
        ends[0] = WIDTH
        spans = 2 * REACH + 1
        apart = np.abs(np.arange(spans) - REACH)
        offsets = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
        return Lumped(
            tap=ends + self.time(line, "mt", "tap", "tap", ("timer",)),
            synapse=self.each(SYNAPSES, lambda k: self.current(
                (*memory, ("neuron", ()), (f"synapse{k}", ())), "me", "p", self.gate["integrating"])),
            step=WIDTH + self.each(SYNAPSES, lambda k: self.time(
                (*memory, ("neuron", ()), (f"synapse{k}", ())), "mt", "step", "timer", ("timer",))),
            integrating=q["integrating"] * self.offset((*memory, ("neuron", ()), ("threshold", ()))),
            seen=self.each(len(INPUTS), lambda k: self.current(
                (*unit, ("cd", ()), (f"input{k}", ())), "me", "p", self.gate["cd"])),
            window=q["pulse_width"] + self.each(len(INPUTS), lambda k: self.time(
                (*unit, ("cd", ()), (f"input{k}", ())), "mt", "window", "timer", ("timer",))),
            taken=self.taken((*unit, ("cd", ()))),
            sum=q["sum"],
            hold=self.time((*unit, ("inh", ()), ("hold", ())), "mt", "hold", "timer", ("timer",)),
            tonic=self.time((*unit, ("inh", ()), ("cell", ())), "mp", "tonic", "tonic", ("threshold",)),
            block=self.time((*unit, ("gate", ())), "mt", "block", "timer", ("timer",)),
            passive=self.current(first, "mp", "p", self.gate["passive"]),
            race=q["race"] * self.offset((*first, ("threshold", ()))),
            goal=self.current((*first, ("excite0", ())), "me", "p", self.gate["goal"][offsets]),
            direction=self.current((*first, ("excite1", ())), "me", "p", self.gate["direction"]),
            goal_pulse=WIDTH + self.time((*first, ("excite0", ())), "mt", "pulse", "timer", ("timer",)),
            direction_pulse=WIDTH + self.time((*first, ("excite1", ())), "mt", "pulse", "timer", ("timer",)),
            inhibit=self.each(spans, lambda k: self.current(
                (*first, (f"inhibit{k}", ())), "mk", "n", self.gate["inhibit"][apart[k]])),
            inhibition=self.each(spans, lambda k: self.time(
                (*first, (f"inhibit{k}", ())), "mt", "inhibition", "timer", ("timer",))),
            second=self.current((*second, ("excite0", ())), "me", "p",
                                self.gate["second"][np.array(d.group)]),
            second_charge=q["second"] * self.offset((*second, ("threshold", ()))),
            recurrent=self.time((("recurrent", (2,)),), "mt", "recurrent", "recurrent", ("timer",)),
            emergency=float(self.time((("emergency", ()),), "mp", "emergency", "race", ("threshold",))[()]),
            group=np.array(d.group, dtype=np.int64),
        )  # fmt: skip

    def each(self, count: int, make: Callable[[int], F64]) -> F64:
        """Arrays of a device of each of `count` parts, stacked last."""
        return np.ascontiguousarray(np.stack([make(k) for k in range(count)], axis=-1))

    def time(self, path: Path, device: str, line: str, charge: str, end: tuple[str, ...]) -> F64:
        """Charge over current of a part's pFET, its charge ended by the comparator `end` below it."""
        current = self.current(path, device, "p", self.gate[line])
        where = (*path, *((name, ()) for name in end))
        return np.asarray(self.charge[charge] * self.offset(where) / current)

    def offset(self, path: Path) -> F64:
        """Factor of a charge by the offset of the comparator at a path."""
        paths: list[Path] = [(*path, (name, ())) for name in COMPARATOR]
        shape = _shape(path)
        areas = np.repeat(self.comparator_area, math.prod(shape)) * self.area
        v_t0, beta = self.silicon.deviations(NAME, paths, areas)
        moved = np.stack([np.broadcast_to(v_t0, areas.shape), np.log1p(np.broadcast_to(beta, areas.shape))])
        each = moved.reshape(2, len(COMPARATOR), *shape)
        return np.asarray(1.0 + np.einsum("dx,xd...->...", self.gradient, each))

    def current(self, path: Path, device: str, polarity: str, gate: F64, width: float = SIZE[0]) -> F64:
        """Saturated current of a device of `width` by 24 um whose gate is `gate` V from its bulk, A."""
        law = self.silicon.law("p" if polarity == "p" else "n")
        v_t0, beta = self.deviation(path, device, width)
        gate = gate.reshape(gate.shape + (1,) * (v_t0.ndim - gate.ndim)) if gate.ndim < v_t0.ndim else gate
        if gate.ndim > v_t0.ndim:
            v_t0, beta = (x.reshape(x.shape + (1,) * (gate.ndim - x.ndim)) for x in (v_t0, beta))
        half = 0.5 * law.kappa * (gate - law.v_t0 - v_t0) / law.u_t
        specific = law.square_current * (1.0 + beta) * width / SIZE[1]
        return np.asarray(specific * np.logaddexp(0.0, half) ** 2)

    def deviation(self, path: Path, device: str, width: float) -> tuple[F64, F64]:
        shape = _shape(path)
        area = width * SIZE[1] * _UM2 * self.area
        v_t0, beta = self.silicon.deviation(NAME, (*path, (device, ())), area)
        full = np.ones(math.prod(shape))
        return (full * v_t0).reshape(shape), (full * beta).reshape(shape)

    def taken(self, path: Path) -> F64:
        """What the mirror of a coincidence detector takes, A: a copy of `SHARE` inputs, by `md` and `mk`."""
        law = self.silicon.law("n")
        given = self.current(path, "me", "p", self.gate["cd"], SHARE * SIZE[0])
        (v_in, beta_in), (v_out, beta_out) = (self.deviation(path, m, SIZE[0]) for m in ("md", "mk"))
        specific = law.square_current * SIZE[0] / SIZE[1]
        root = np.sqrt(given / (specific * (1.0 + beta_in)))
        half = np.log(np.expm1(root)) + 0.5 * law.kappa * (v_in - v_out) / law.u_t
        return np.asarray(specific * (1.0 + beta_out) * np.logaddexp(0.0, half) ** 2)


def _shape(path: Path) -> tuple[int, ...]:
    return tuple(n for _, shape in path for n in shape)
