"""Voltages of the bias generator's lines on a die: the operating point of its circuit, part by part.

No line draws direct current from what it shares with others, since only gates stand between them. So the
shared part is solved first, once a chip, and then all lines that are asked for at once. What comes out is
the operating point of the whole circuit.

The core's resistor is chosen for the process (ours): the nominal core makes its master current at 27 degC. On
a die every transistor deviates at its own place, `chip/bias generator/...`; resistors do not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.generator.circuit import MASTER_CURRENT, NARROW, line, line_sizes, masters
from circuits.generator.code import COARSE, REFERENCE_C, codes_of, currents_of
from circuits.generator.solve import AtRest, Network, no_room, rest_state, rest_states
from circuits.silicon.die import NOMINAL, Path, Place
from circuits.silicon.process import POLARITIES, Process, TransistorAtTemperature
from circuits.silicon.silicon import NO_DEVIATION, Deviation, Silicon

GENERATOR = ("bias generator", ())
"""Part of a place on a die; with its space it cannot be the name of an instance."""

SHARED_PATH: Path = (GENERATOR, ("shared masters", ()))
"""Path of what lines share, from the chip on."""
OFF = NARROW.off_gate  # of the start-up's diodes, at a third of the supply
RANGES = tuple(f"range_{k}" for k in range(len(COARSE)))
_RESISTANCE = 148e3  # Ohm, where the search for a process's resistor begins
_LEAST = 0.1 * _RESISTANCE  # Ohm, below which a core has no room to work; ours
_ROUNDS = 20


@dataclass(frozen=True, slots=True)
class Line:
    """Lines of a chip's generator, one for each current of a bias.

    place : of the chip.
    port, shape : the bias port, and how many lines it has along each axis.
    index : of the one line that is meant, where the port has more than are asked for; None for all.
    device : a device that is biased.
    """

    place: Place
    port: str
    shape: tuple[int, ...]
    index: tuple[int, ...] | None
    device: Transistor

    @property
    def node(self) -> str:
        """The line's node in its network."""
        return "v_n" if self.device.polarity == "n" else "v_p"


def line_voltages(lines: Line, current: F64, silicon: Silicon, resistance: float | None = None) -> F64:
    """Voltages of lines whose codes are nearest to currents, V, float64 of the currents' shape.

    Raises `ParameterError` for a current that no code reaches, and `SolverError` where the circuit does not
    work at the silicon's supply.

    Parameters
    ----------
    lines
        Where the lines stand, and for what device.
    current
        Currents at `REFERENCE_C`, A, above zero.
    silicon
        Process, supply, temperature and die.
    resistance
        The core's resistor, Ohm; the one that is chosen for the process unless given, so that a supply that
        moves must keep its own.
    """
    own = resistor_of(silicon.process) if resistance is None else resistance
    found = lines_at_rest(lines, coded(current), replace(silicon, place=lines.place), own)
    return found.voltages[lines.node].copy().reshape(current.shape)


def lone_line_voltages(lines: Sequence[Line], currents: Sequence[F64], silicon: Silicon) -> list[float]:
    """What `line_voltages` gives of lines of one copy each, V: those of a polarity are found side by side.

    currents: of shape () each, A. Raises as `line_voltages` does.
    """
    wanted = [(each, coded(current)) for each, current in zip(lines, currents, strict=True)]
    resistance = resistor_of(silicon.process)
    known = voltages_known(silicon, resistance)
    for polarity in POLARITIES:
        some = [each for each in wanted if each[0].device.polarity == polarity and each not in known]
        if some:
            known.update(zip(some, _side_by_side(some, silicon, resistance), strict=True))
    return [known[each] for each in wanted]


Codes = tuple[tuple[int, int], ...]  # coarse and fine


@lru_cache(maxsize=64)
def voltages_known(silicon: Silicon, resistance: float) -> dict[tuple[Line, Codes], float]:
    """Return what `lone_line_voltages` has found on a silicon, V, which it adds to; arguments as there."""
    return {}


def _side_by_side(wanted: Sequence[tuple[Line, Codes]], silicon: Silicon, resistance: float) -> list[float]:
    """Voltages of lines of one copy and one polarity each, V."""
    on = [replace(silicon, place=lines.place) for lines, _ in wanted]
    alone = tuple(line_network(lines, codes, silicon.process) for lines, codes in wanted)
    network, codes = joined_network(alone), [own for _, (own,) in wanted]
    deviations = []
    for (lines, _), own, there in zip(wanted, alone, on, strict=True):
        place, path = where_of(lines)
        deviations.append(_deviation(own, replace(there, place=place), path))
    count = len(network.transistors())
    v_t0, beta = (
        np.stack([np.broadcast_to(getattr(d, name), count) for d in deviations], axis=1).ravel()
        for name in Deviation._fields
    )
    shared = [masters_at_rest(there, resistance).voltages for there in on]
    given = {
        "vdd": np.full(len(wanted), silicon.process.v_dd),
        "range_n": np.array([v[RANGES[coarse]][0] for v, (coarse, _) in zip(shared, codes, strict=True)]),
        OFF: np.array([v[OFF][0] for v in shared]),
    }
    start = _line_start(network, codes, silicon)
    found = rest_states(network, silicon, Deviation(v_t0, beta), given, start)
    return [float(v) for v in found[wanted[0][0].node]]


@lru_cache(maxsize=32)
def joined_network(networks: tuple[Network, ...]) -> Network:
    """Return the copies of networks that are alike as those of one."""
    return Network([copy for each in networks for copy in each.copies], networks[0].given)


def coded(current: F64) -> Codes:
    """Codes nearest to currents, A; raises `ParameterError` for one that no code reaches."""
    return tuple((int(coarse), int(fine)) for coarse, fine in codes_of(current).reshape(-1, 2))


@lru_cache(maxsize=128)
def line_network(lines: Line, codes: Codes, process: Process) -> Network:
    """Lines at codes in a process."""
    sizes = line_sizes(process)
    own = [line(fine, lines.device, sizes[coarse]) for coarse, fine in codes]
    return Network(own, ("0", "vdd", "range_n", OFF))


@lru_cache(maxsize=32)
def masters_network(resistance: float, process: Process) -> Network:
    """What lines share in a process; resistance: of the core's resistor, Ohm."""
    return Network([masters(resistance, line_sizes(process))], ("0", "vdd"))


def where_of(lines: Line) -> tuple[Place, Path]:
    """Place from which the deviations of lines' devices are drawn, and their path from there on."""
    if lines.index is None:
        return lines.place, (GENERATOR, (lines.port, lines.shape))
    return (*lines.place, GENERATOR, (lines.port, lines.index)), ()


@lru_cache(maxsize=4096)
def lines_at_rest(lines: Line, codes: Codes, silicon: Silicon, resistance: float) -> AtRest:
    """Lines at codes on a silicon whose place is the chip's; arguments as of `line_voltages`."""
    shared = masters_at_rest(silicon, resistance).voltages
    network = line_network(lines, codes, silicon.process)
    place, path = where_of(lines)
    deviation = _deviation(network, replace(silicon, place=place), path)
    given = {
        "vdd": np.full(len(codes), silicon.process.v_dd),
        "range_n": np.array([shared[RANGES[coarse]][0] for coarse, _ in codes]),
        OFF: np.full(len(codes), shared[OFF][0]),
    }
    found = rest_state(network, silicon, deviation, given, _line_start(network, codes, silicon))
    return AtRest(network, deviation, {**found, **given})


@lru_cache(maxsize=256)
def masters_at_rest(silicon: Silicon, resistance: float) -> AtRest:
    """What lines share on a silicon whose place is the chip's; resistance: of the core's resistor, Ohm."""
    network = masters_network(resistance, silicon.process)
    deviation = _deviation(network, silicon, SHARED_PATH)
    found = _core_state(network, silicon, deviation)
    return AtRest(network, deviation, {**found, "vdd": np.array([silicon.process.v_dd])})


@lru_cache(maxsize=32)
def resistor_of(process: Process) -> float:
    """Resistor with which the nominal core makes `MASTER_CURRENT` at `REFERENCE_C` in a process, Ohm.

    Raises `SolverError` where it makes none at the process's supply.
    """
    nominal = Silicon(process, REFERENCE_C, NOMINAL)
    resistance = _RESISTANCE
    for _ in range(_ROUNDS):
        network = masters_network(resistance, process)
        over = float(_core_state(network, nominal, NO_DEVIATION)["core_r"][0])
        resistance, before = over / MASTER_CURRENT, resistance
        if resistance < _LEAST:
            raise no_room(nominal)
        if abs(resistance - before) < 1e-9 * before:
            break
    return resistance


def _deviation(network: Network, silicon: Silicon, path: Path) -> Deviation:
    devices = network.transistors()
    areas = network.of_transistors("gate_area").ravel()
    paths = [(*path, (d.name, ())) for d in devices]
    return silicon.deviations("", paths, areas, [d.polarity for d in devices])


def _core_state(network: Network, silicon: Silicon, deviation: Deviation) -> dict[str, F64]:
    """Rest state of what lines share."""
    v_dd, n, p = silicon.process.v_dd, silicon.law("n").v_t0, silicon.law("p").v_t0
    levels = {"core_n": n, "core_p": v_dd - p, "core_r": 2.0 * silicon.thermal_voltage, "kick": 0.0}
    levels |= {"kick_a": 0.7 * v_dd, "kick_b": 0.4 * v_dd} | dict.fromkeys(RANGES, n)
    start = {name: np.array([levels.get(name, 0.6 * v_dd)]) for name in network.unknown()}
    return rest_state(network, silicon, deviation, {"vdd": np.array([v_dd])}, start)


def _line_start(
    network: Network, codes: Sequence[tuple[int, int]], silicon: Silicon
) -> Mapping[str, F64]:  # fmt: skip
    """A guess of a line's nodes: weak inversion's logarithms of the currents, below the supply or ground."""
    v_dd, n, p = silicon.process.v_dd, silicon.law("n"), silicon.law("p")
    whole = np.array([COARSE[coarse] for coarse, _ in codes])
    out = currents_of(np.array(codes))
    below_gate = n.kappa * (v_dd - n.v_t0) - n.u_t * np.log(whole / n.square_current)
    splitter = np.clip(below_gate, 0.1 * v_dd, v_dd - p.v_t0)
    levels = {
        "sum": v_dd - _gate(p, out), "v_n": _gate(n, out), "v_p": v_dd - _gate(p, out), "f0": splitter,
    }  # fmt: skip
    return {name: levels.get(name, splitter) for name in network.unknown()}


def _gate(law: TransistorAtTemperature, current: F64) -> F64:
    return np.asarray(law.v_t0 + law.u_t / law.kappa * np.log(current / law.square_current))
