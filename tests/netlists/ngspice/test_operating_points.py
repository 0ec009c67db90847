"""Circuits whose rest state ngspice does not find in its usual iterations; random in `operating_points.json`.

Nodes held by diode-connected devices with next to no load: currents of 1e-20 A and less. Left alone, ngspice
39 ends its search in a transient of 10 us and calls its last point the operating point, here up to 4 V and
2e-8 A away from one.
"""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import replace
from decimal import Decimal, localcontext
from pathlib import Path
from typing import Any

import pytest

from circuits.circuit import GROUND, Circuit, Port
from circuits.devices import Capacitor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear, Pulse, Waveform
from circuits.errors import SimulatorError
from circuits.registry import load_block
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Deviation, Silicon
from circuits.solver import operating_point as native
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_testbench
from netlists.ngspice import engine
from netlists.ngspice import run as ngspice
from netlists.ngspice.library import NoOperatingPointError
from netlists.write.traversal import to_design

PLACE = Path(__file__).with_name("operating_points.json")
CIRCUITS: list[dict[str, Any]] = json.loads(PLACE.read_text())
NAMES = [each["name"] for each in CIRCUITS]
BY_ITSELF = ["r86", "r288", "r141"]  # in the iterations that our decks give
HELD = [name for name in NAMES if name not in BY_ITSELF]
ABSTOL = 1e-15  # A, of our decks
APART = 5e-3  # V: what 1e-19 A, far below abstol, are where the least conductance is 1e-17 S


def waveform(source: dict[str, Any]) -> Waveform:
    match source["kind"]:
        case "Constant":
            return Constant(source["value"])
        case "Pulse":
            starts = tuple(source["starts"])
            return Pulse(
                source["low"], source["high"], starts, source["width"], source["rise"], source["fall"]
            )
        case _:
            return PiecewiseLinear(tuple(source["time"]), tuple(source["value"]))


def circuit_of(name: str) -> tuple[Testbench, Silicon]:
    it = CIRCUITS[NAMES.index(name)]
    devices = (*(Transistor(*t) for t in it["transistors"]), *(Capacitor(*c) for c in it["capacitors"]))
    ports = tuple(Port(p, "supply" if p == "vdd" else "analog") for p in it["ports"])
    sources = tuple(Source(s["name"], s["node"], waveform(s)) for s in it["sources"])
    die = NOMINAL if it["die"] is None else Die(number=it["die"])
    return Testbench(name, Circuit(name, ports, devices), sources, it["stop_s"]), Silicon(
        AMI_1500_IDEAL, die=die
    )


def imbalance(bench: Testbench, silicon: Silicon, volts: dict[str, float]) -> float:
    """Largest sum of currents into a node that no source drives, A, by the law's equation with 50 digits."""
    net: defaultdict[str, Decimal] = defaultdict(Decimal)
    with localcontext() as context:
        context.prec = 50
        exact = {node: Decimal(v) for node, v in volts.items()}
        for device, shift in to_design(bench, silicon).top.devices:
            if isinstance(device, Transistor):
                current = drain_current(device, shift, silicon, exact)
                net[device.drain] += current
                net[device.source] -= current
    driven = {s.node for s in bench.sources} | {GROUND}
    return max(abs(float(current)) for node, current in net.items() if node not in driven)


def drain_current(
    device: Transistor, shift: Deviation, silicon: Silicon, volts: dict[str, Decimal]
) -> Decimal:
    law, sign = silicon.law(device.polarity), 1 if device.polarity == "n" else -1
    assert law.gamma == law.junction_leakage == law.early_field == 0.0
    d, g, s = (sign * (volts[n] - volts[device.bulk]) for n in (device.drain, device.gate, device.source))
    pinched = Decimal(law.kappa) * (g - Decimal(law.v_t0) - Decimal(shift.v_t0))
    forward, reverse = ((1 + ((pinched - v) / Decimal(2 * law.u_t)).exp()).ln() ** 2 for v in (s, d))
    ratio = Decimal(device.width) * Decimal(device.multiplicity) / Decimal(device.length)
    return sign * Decimal(law.square_current) * ratio * (1 + Decimal(shift.beta)) * (forward - reverse)


@pytest.mark.parametrize("name", NAMES)
def test_the_solvers_point_balances_all_currents(name: str) -> None:
    bench, silicon = circuit_of(name)
    point = native.operating_point(bench, silicon)
    # rounding of the largest current that meets a node, 4e-4 A
    assert imbalance(bench, silicon, point.voltages()) < 1e-18


@pytest.mark.usefixtures("ngspice_library")
@pytest.mark.parametrize("name", BY_ITSELF)
def test_ngspice_finds_a_rest_state_by_itself(name: str) -> None:
    """A warning would be an error here."""
    bench, silicon = circuit_of(name)
    expected = native.operating_point(bench, silicon).voltages()
    found = engine.simulate(bench, silicon, deadline_s=60.0).operating_point.voltages()
    assert found == pytest.approx(expected, abs=APART)
    assert imbalance(bench, silicon, found) < 10.0 * ABSTOL


@pytest.mark.usefixtures("ngspice_library")
def test_ngspice_finds_that_of_the_rebound_neuron_by_itself() -> None:
    """A warning would be an error here."""
    bench = replace(load_block("rebound-neuron").bench(), stop=1e-4)
    expected = native.operating_point(bench, Silicon(AMI_1500)).voltages()
    found = engine.simulate(bench, Silicon(AMI_1500), deadline_s=60.0).operating_point.voltages()
    assert found == pytest.approx(expected, abs=1e-6)


@pytest.mark.usefixtures("ngspice_library")
@pytest.mark.parametrize("name", HELD)
def test_ngspice_begins_at_a_rest_state_and_says_how_it_was_found(name: str) -> None:
    bench, silicon = circuit_of(name)
    expected = native.operating_point(bench, silicon).voltages()
    with pytest.warns(engine.Held, match=rf"^ngspice\.{name}: no operating point by itself; .*, there .* V$"):
        found = engine.simulate(bench, silicon, deadline_s=60.0).operating_point.voltages()
    assert found == pytest.approx(expected, abs=APART)
    assert imbalance(bench, silicon, found) < 10.0 * ABSTOL


@pytest.mark.usefixtures("ngspice_library")
def test_a_search_that_fails_is_no_operating_point() -> None:
    with pytest.raises(NoOperatingPointError, match=r"^ngspice: singular matrix: .*; give start voltages"):
        ngspice.run(format_testbench(*circuit_of("r58"), analysis="op"))


@pytest.mark.usefixtures("ngspice_library")
def test_what_no_guess_helps_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "_HOLD", 0.0)
    with pytest.raises(SimulatorError, match=r"neither beside the solver's, tied to it by 0 S"):
        engine.operating_point(*circuit_of("r58"))
