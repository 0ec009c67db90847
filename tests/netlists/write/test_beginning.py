"""Where a run begins, in netlists: `.ic`, `.nodeset`, `ic=` and `uic` in, out, and as ngspice has them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySpice.Spice.Netlist import Circuit as PySpiceCircuit

from circuits.circuit import Circuit, InstanceArray, Node, Port
from circuits.devices import Capacitor, Resistor, Source, Transistor
from circuits.devices.source import Constant
from circuits.errors import DataError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from netlists.ngspice import engine
from netlists.ngspice import run as ngspice
from netlists.pyspice.read import from_pyspice
from netlists.pyspice.write import to_pyspice
from netlists.read import read_netlist
from netlists.registry import Settings, load_dialect
from tests.circuits.solver.examples import SUPPLY, latch
from tests.circuits.solver.oscillators import OSCILLATORS

UM, NF, US = 1e-6, 1e-9, 1e-6
DECK = """Two capacitors
v1 a 0 1
r1 a b 1k
c1 b 0 1n ic=0.25
r2 b c 1k
c2 c 0 1n
r3 c d 1k
c3 d a 1n
.nodeset v(d)=0.5
.ic v(c)=0.75
.tran 10n 5u{uic}
.end
"""


def chain() -> Testbench:
    """Two stages with a node of their own each, the second charged, and a transistor that divides."""
    stage = Circuit(
        "stage", (Port("a", "analog"), Port("y", "analog", "out")),
        (Resistor("r", "a", "m", 1e3), Resistor("s", "m", "y", 1e3), Capacitor("c", "m", "0", 1 * NF)),
    )  # fmt: skip
    circuit = Circuit(
        "chain", (Port("vdd", "supply"),),
        (
            Capacitor("load", "y[1]", "vdd", 2 * NF, ic=-1.5),
            Transistor("m", "n", "y[0]", "y[1]", "0", "0", 30 * UM, 1.5 * UM),
        ),
        (InstanceArray("stage", stage, (2,), {"a": "vdd", "y": "y"}),),
        (Node("y", (2,)),),
    )  # fmt: skip
    return Testbench("chain", circuit, (SUPPLY,), 10 * US, initial={"stage[0].m": 1.0})


@pytest.mark.usefixtures("kept_ngspice")
@pytest.mark.parametrize("begin", ["disturbed", "uic"])
def test_held_voltages_and_charges_are_those_of_ngspice(begin: str) -> None:
    bench = replace(chain(), begin=begin)  # type: ignore[arg-type]  # one of the two
    own = simulate(bench, Silicon(AMI_1500_IDEAL), rtol=1e-7)
    peer = engine.simulate(bench, Silicon(AMI_1500_IDEAL), reltol=1e-6, tmax=bench.stop / 20_000)
    after = peer.time > 5e-9  # with uic ngspice's first point has no meaning
    for node in own.nodes[1:]:
        ours = np.interp(peer.time[after], own.time, own[node])
        np.testing.assert_allclose(ours, peer[node][after], atol=1e-3, err_msg=node)
    assert (own["y[1]"][0] == 3.5) == (begin == "disturbed")


@pytest.mark.usefixtures("kept_ngspice")
@pytest.mark.parametrize("uic", ["", " uic"])
def test_a_hand_written_deck_runs_as_it_does_in_ngspice(uic: str) -> None:
    deck = DECK.format(uic=uic)
    found = read_netlist(deck)
    bench = found.testbench
    assert bench.initial == ({"c": 0.75, "d": 0.5} if uic else {"c": 0.75})  # as ngspice has it
    assert bench.start == ({} if uic else {"d": 0.5})
    assert (".nodeset with uic" in str(found.notes)) == bool(uic)
    assert bench.begin == ("uic" if uic else "disturbed")
    assert bench.circuit.device("c1").ic == (0.25 if uic else None)  # type: ignore[attr-defined]
    assert ("which a run without uic does not use" in str(found.notes)) != bool(uic)
    own = simulate(bench, Silicon(AMI_1500_IDEAL), rtol=1e-7)
    peer = ngspice.run(deck.replace(".tran 10n 5u", ".options reltol=1e-6\n.tran 10n 5u 0 1n"))
    after = peer.axis > 5e-9
    for node in "bcd":
        ours = np.interp(peer.axis[after], own.time, own[node])
        np.testing.assert_allclose(ours, peer.values[node][after], atol=1e-3, err_msg=node)


@pytest.mark.parametrize("begin", ["disturbed", "uic"])
@pytest.mark.parametrize("dialect", ["ngspice", "hspice", "xyce"])
def test_without_notes_it_comes_back_as_well(dialect: str, begin: str) -> None:
    circuit = Circuit(
        "pair", (Port("vdd", "supply"),),
        (Resistor("r", "vdd", "y", 1e3), Capacitor("c", "y", "0", NF, ic=1.0), Resistor("s", "y", "0", 1e3)),
    )  # fmt: skip
    bench = Testbench("pair", circuit, (SUPPLY,), US, start={"y": 2.0}, begin=begin)  # type: ignore[arg-type]
    text = load_dialect(dialect).write(bench, Silicon(AMI_1500_IDEAL), Settings())
    plain = "\n".join(line for line in text.splitlines() if not line.startswith("*%")) + "\n"
    found = read_netlist(plain, dialect=dialect).testbench
    assert found.begin == begin
    assert found.start == ({} if begin == "uic" else {"y": 2.0})  # without a rest state a guess says nothing
    assert found.initial == ({} if begin == "uic" else {"y": 1.0})
    first = simulate(found)["y"][0], simulate(bench)["y"][0]
    assert first == pytest.approx((1.0, 1.0), abs=1e-6)


@pytest.mark.parametrize("dialect", ["ngspice", "hspice", "xyce", "spectre"])
def test_dialects_write_their_own_words(dialect: str) -> None:
    words = {
        "ngspice": (r".ic v(xchain.xstage#0.m)=1.0 v(y#1)=3.5", " uic"),
        "hspice": (".ic v(", " uic"),
        "xyce": (".ic v(", " uic"),
        "spectre": ("\nic ", " skipdc=yes"),
    }[dialect]
    write = load_dialect(dialect).write
    held = write(chain(), Silicon(AMI_1500_IDEAL), Settings())
    assert words[1] not in held
    charged = write(replace(chain(), begin="uic"), Silicon(AMI_1500_IDEAL), Settings())
    assert words[1] in charged
    if dialect != "ngspice":
        assert words[0] in held
        assert words[0] in charged
    assert "ic=-1.5" in held


@pytest.mark.usefixtures("kept_ngspice")
@pytest.mark.parametrize("begin", ["disturbed", "uic"])
def test_pyspice_begins_likewise(begin: str) -> None:
    bench = replace(chain(), begin=begin)  # type: ignore[arg-type]  # one of the two
    circuit = to_pyspice(bench, Silicon(AMI_1500_IDEAL))
    found = circuit.transient()
    own = simulate(bench, Silicon(AMI_1500_IDEAL), rtol=1e-7)
    last = float(np.asarray(found[circuit.run_names["y[1]"]])[-1])
    assert last == pytest.approx(own["y[1]"][-1], abs=5e-3)
    assert circuit.uic == (begin == "uic")


def test_a_capacitor_of_pyspice_keeps_its_voltage() -> None:
    circuit = PySpiceCircuit("t")
    circuit.V("in", "a", circuit.gnd, 5.0)
    circuit.R(1, "a", "b", 1e3)
    circuit.C(1, "b", circuit.gnd, 1e-9, initial_condition=1.5)
    assert simulate(from_pyspice(circuit, stop=1e-6))["b"][0] == 1.5


@pytest.mark.usefixtures("kept_ngspice")
def test_ngspice_leaves_an_unstable_state_as_the_solver_does() -> None:
    oscillator = OSCILLATORS["oscillators"]()[1]
    silicon = Silicon(oscillator.process)
    peer = engine.simulate(oscillator.testbench, silicon, tmax=oscillator.period / 200)
    own = simulate(oscillator.testbench, silicon)
    assert peer.disturbance == own.disturbance
    assert peer["spike"][0] == pytest.approx(own["spike"][0], abs=1e-6)
    assert peer.spikes["spike"].size >= 6
    assert not peer.operating_point.stable


@pytest.mark.usefixtures("kept_ngspice")
def test_ngspice_counts_at_the_circuit_s_own_threshold() -> None:
    ring = OSCILLATORS["oscillators"]()[6]  # in the process of 5 V
    low = replace(ring.testbench, sources=(Source("vdd", "vdd", Constant(1.8)),), stop=0.3e-6)
    peer = engine.simulate(low, Silicon(ring.process), tmax=0.3e-6 / 4000)
    assert peer.spikes["spike"].size > 10
    ports = tuple(replace(p, threshold=2.5) if p.name == "spike" else p for p in low.circuit.ports)
    stated = replace(low, circuit=replace(low.circuit, ports=ports))
    peer = engine.simulate(stated, Silicon(ring.process), tmax=0.3e-6 / 4000)
    assert peer.uncrossed["spike"].threshold == 2.5


@pytest.mark.usefixtures("kept_ngspice")
def test_a_latch_is_set_in_both_engines() -> None:
    for node, other in (("a", "b"), ("b", "a")):
        bench = replace(latch(), initial={node: 5.0})
        for result in (simulate(bench), engine.simulate(bench, Silicon(AMI_1500_IDEAL))):
            assert result[node][-1] > 4.9
            assert result[other][-1] < 0.1


def test_what_the_notes_do_not_say_is_refused() -> None:
    text = load_dialect("ngspice").write(chain(), Silicon(AMI_1500_IDEAL), Settings())
    with pytest.raises(DataError, match="edited"):
        read_netlist(text.replace("=3.5", "=3.6"))
