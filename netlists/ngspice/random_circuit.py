"""Random circuits: the same number is the same circuit, whatever other numbers are drawn.

A circuit has 3 to 12 devices between a supply, an input that pulses once, ground, and 2 to 5 nodes of its
own: transistors of any size, resistors, capacitors, and current sources of the testbench. What is drawn is
kept if it is a circuit that can be solved at all (no gate that floats, a path for direct current from every
node) and whose current sources have a way through resistors, which they lift by 20 V at most: one into a
transistor that is off has no operating point in silicon, and one of megavolts by the law. Else the next
attempt is drawn. All ranges are ours; sizes are drawn evenly in their logarithm.
"""

from __future__ import annotations

import math

import numpy as np

from circuits.circuit import GROUND, Circuit, Port
from circuits.devices import Capacitor, Device, Resistor, Source, Transistor
from circuits.devices.source import Constant, Pulse
from circuits.errors import TopologyError
from circuits.lowering.kernel import to_kernel
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench

DEVICES = (3, 12)
NODES = (2, 5)
SIZE = (1.5e-6, 60e-6)  # m, width and length of a transistor
RESISTANCE = (1e3, 1e9)  # Ohm
CAPACITANCE = (10e-15, 10e-12)  # F
CURRENT = (10e-12, 100e-6)  # A, of a source into a node or out of it
LIFT = 20.0  # V, four supplies
STOP = (1e-6, 10e-3)  # s, length of the run
_SHARES = {"transistor": 0.6, "resistor": 0.2, "capacitor": 0.13, "current": 0.07}
_ATTEMPTS = 1000
_KEY = 0x6E6F6374756C65  # of all draws of this module; ours


def random_testbench(number: int, silicon: Silicon) -> Testbench:
    """Draw the circuit of a number, with its sources and its length.

    Parameters
    ----------
    number : which circuit.
    silicon : what it must be solvable on; the drawing uses its supply voltage alone.
    """
    for attempt in range(_ATTEMPTS):
        draw = np.random.Generator(np.random.Philox(key=_KEY, counter=(0, 0, attempt, number)))
        bench = _drawn(draw, f"random_{number}", silicon.process.v_dd)
        if not (_has_ways(bench) and _lift(bench) <= LIFT):
            continue
        try:
            to_kernel(bench, silicon)
        except TopologyError:
            continue
        return bench
    raise TopologyError(f"random_{number}: no attempt of {_ATTEMPTS} can be solved; give another number")


def _has_ways(bench: Testbench) -> bool:
    """Whether resistors lead from each current source to ground or a voltage source."""
    reached = {GROUND, *(s.node for s in bench.sources if s.quantity == "voltage")}
    resistors = [{d.a, d.b} for d in bench.circuit.devices if isinstance(d, Resistor)]
    for _ in resistors:
        reached |= {n for ends in resistors if ends & reached for n in ends}
    return all(s.node in reached for s in bench.sources)


def _lift(bench: Testbench) -> float:
    """All currents of sources through all resistors, V."""
    amperes = sum(
        abs(s.waveform.value)
        for s in bench.sources
        if s.quantity == "current" and isinstance(s.waveform, Constant)
    )
    return amperes * sum(d.resistance for d in bench.circuit.devices if isinstance(d, Resistor))


def _drawn(draw: np.random.Generator, name: str, v_dd: float) -> Testbench:
    """One attempt: devices at random nodes, and the sources that drive them."""
    count = int(draw.integers(DEVICES[0], DEVICES[1] + 1))
    inner = [f"n{k}" for k in range(int(draw.integers(NODES[0], NODES[1] + 1)))]
    nodes = [GROUND, "vdd", "vin", *inner]
    kinds = draw.choice(list(_SHARES), size=count, p=list(_SHARES.values()))
    devices: list[Device] = []
    sources = [Source("vdd", "vdd", Constant(v_dd))]
    for k, kind in enumerate(kinds):
        if kind == "current":
            sign = 1.0 if draw.random() < 0.5 else -1.0
            node = str(draw.choice(inner))
            sources.append(Source(f"i{k}", node, Constant(sign * _log(draw, CURRENT)), "current"))
        else:
            devices.append(_device(draw, str(kind), k, nodes))
    stop = _log(draw, STOP)
    edge = stop * _log(draw, (1e-3, 5e-2))
    low, high = draw.permutation([0.0, v_dd]) if draw.random() < 0.5 else draw.uniform(0.0, v_dd, 2)
    pulse = Pulse(float(low), float(high), (0.1 * stop,), 0.4 * stop, edge, edge)
    sources.append(Source("vin", "vin", pulse))
    used = {n for device in devices for n in device.terminals()}
    used |= {source.node for source in sources if source.quantity == "current"}
    driven = {s.node for s in sources}
    ports = tuple(
        Port(n, "supply" if n == "vdd" else "analog") for n in ("vdd", "vin", *inner) if n in driven & used
    )
    kept = tuple(s for s in sources if s.node in used)
    return Testbench(name, Circuit(name, ports, tuple(devices)), kept, stop)


def _device(draw: np.random.Generator, kind: str, k: int, nodes: list[str]) -> Device:
    """A device of a kind at random nodes, two ends of which are never the same."""
    if kind == "transistor":
        polarity, bulk = ("n", GROUND) if draw.random() < 0.5 else ("p", "vdd")
        d, s = (str(n) for n in draw.choice(nodes, 2, replace=False))
        g = str(draw.choice(nodes))
        return Transistor(f"m{k}", polarity, d, g, s, bulk, _log(draw, SIZE), _log(draw, SIZE))  # type: ignore[arg-type]
    a, b = (str(n) for n in draw.choice(nodes, 2, replace=False))
    if kind == "resistor":
        return Resistor(f"r{k}", a, b, _log(draw, RESISTANCE))
    return Capacitor(f"c{k}", a, b, _log(draw, CAPACITANCE))


def _log(draw: np.random.Generator, ends: tuple[float, float]) -> float:
    """A number between two ends, evenly in its logarithm, to four digits."""
    value = math.exp(draw.uniform(math.log(ends[0]), math.log(ends[1])))
    return float(f"{value:.4g}")
