"""Claim: one transient of the rebound neuron is at least 100 times faster than in ngspice with our equations.

The run of 16 ms: a call at 1 ms, an echo 6.4 ms later, one spike. Process CPU time, one thread each: of the
transient alone (ngspice's is the run's less that of `.op` on the same deck), and of all that a single run
needs, lowering or parsing and operating point included. Both sides give spike time and t_inh within 1 us of
one reference, and still do when their tolerances are halved; the reference is the solver at rtol 1e-8, and
the distance of ngspice's own converged run to it is printed.

The peer is ngspice at the cheapest of the settings tried that qualify: gear or trapezoidal, reltol, largest
step, trtol 1; flat deck, ideal bias voltages folded into the expressions, the cheaper form of ln(1 + e^x).
A second row has the same topology and biases in ngspice's compiled BSIM3, against its own converged run; its
gate voltages come from diode-connected copies fed with the bias currents.
Cards: the figures published for MOSIS run n88z (AMI 1.5 um); what is not published is left at its default.
"""

from __future__ import annotations

import contextlib
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from statistics import median

import numpy as np

from _report import Row, parser_of, report
from circuits.bias import bias_voltages
from circuits.blocks.sonar import rebound_neuron
from circuits.devices import Capacitor, Source, Transistor
from circuits.devices.source import Constant
from circuits.lowering.flatten import FlatCircuit, flatten
from circuits.lowering.kernel import complete_sources, to_kernel
from circuits.silicon.die import Path
from circuits.silicon.process import AMI_1500_IDEAL, TransistorAtTemperature
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner, simulate
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_device
from netlists.ngspice import run as ngspice
from netlists.ngspice.engine import upward_crossings
from netlists.write import law

CLAIM = 100.0  # times
WITHIN = 1e-6  # s, of the reference
SILICON = Silicon(AMI_1500_IDEAL)
V_DD = SILICON.process.v_dd
RTOLS = (1e-3, 5e-4, 2e-4, 1e-4, 7e-5, 5e-5, 4e-5, 3e-5, 2e-5, 1e-5)
OPTIONS = "gmin=1e-15 abstol=1e-15 chgtol=1e-17 trtol=1"
NMOS = """.model nmos nmos level=8 version=3.2.4 tox=30.4e-9 vth0=0.5816 k1=0.934 k2=-0.067 nch=7.5e16
+ u0=640 ute=-1.5 kt1=-0.11 voff=-0.0836 nfactor=0.495 cj=2.81e-4 cgdo=2.7e-10 cgso=2.7e-10
+ lint=1.13e-7 wint=6.76e-7"""
PMOS = """.model pmos pmos level=8 version=3.2.4 tox=30.4e-9 vth0=-0.806 k1=0.463 nch=2.4e16
+ u0=268 voff=-0.0673 nfactor=0.989 cj=2.96e-4 cgdo=2.7e-10 cgso=2.7e-10"""


@dataclass(frozen=True, slots=True)
class Setting:
    """Options of ngspice and the largest step, s."""

    method: str
    reltol: float
    tmax: float

    def halved(self) -> Setting:
        """Half the tolerances."""
        return replace(self, reltol=0.5 * self.reltol, tmax=0.5 * self.tmax)

    def __str__(self) -> str:
        return f"{self.method} reltol={self.reltol:g} tmax={1e6 * self.tmax:g}us"


@dataclass(frozen=True, slots=True)
class Events:
    """What a run is judged by: the first spike, and the release after the call, s."""

    spike: float
    release: float

    def distance(self, other: Events) -> float:
        """Largest difference to another run, s; infinite where either has no spike or release."""
        found = max(abs(self.spike - other.spike), abs(self.release - other.release))
        return found if np.isfinite(found) else float("inf")


FINEST = Setting("gear", 1e-6, 2e-6)
SETTINGS = tuple(
    Setting(method, reltol, tmax)
    for method in ("trap", "gear")
    for reltol in (1e-3, 5e-4, 3e-4, 1e-4, 3e-5, 1e-5)
    for tmax in (100e-6, 50e-6, 20e-6, 10e-6)
)
# the neighbourhood of the cheapest that the whole search finds
QUICK = tuple(Setting("trap", reltol, tmax) for reltol in (5e-4, 3e-4, 1e-4) for tmax in (100e-6, 50e-6))


def main() -> int:
    """Search both sides' cheapest qualifying settings, time them and print the ratios."""
    options = parser_of(__doc__, "fewer settings of ngspice, one repetition").parse_args()
    # ngspice's BSIM3 leaves a log file where it runs
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        rows = list(measure(QUICK if options.quick else SETTINGS, 3 if options.quick else 9))
    return report(rows, options, figures)


def figures(row: Row) -> str:
    """Both CPU times, and on how many cores."""
    times = f"{1e3 * row.ours:.2f} ms, peer {1e3 * row.peer:.0f} ms, {row.ratio:.0f} times"
    return f"{times}, {row.cores} core"


def measure(settings: tuple[Setting, ...], repetitions: int) -> Iterator[Row]:
    """Two rows a peer."""
    testbench = neuron()
    reference = ours(testbench, 1e-8)
    errors = ((rtol, _solver_error(testbench, rtol, reference)) for rtol in RTOLS)
    rtol, error = next((r, e) for r, e in errors if e < WITHIN)
    whole = median(cpu(lambda: ours(testbench, rtol)) for _ in range(30))
    transient = median(cpu(prepared(testbench, rtol)) for _ in range(30))
    ekv, bsim3 = ekv_deck(testbench), bsim3_deck(testbench)
    own = peer(bsim3, testbench, FINEST)
    check = 1e6 * peer(ekv, testbench, FINEST).distance(reference)
    for name, deck, target, converged in (
        ("the same equations", ekv, reference, f"{check:.2f} us from the reference"),
        ("BSIM3", bsim3, own, "its own reference"),
    ):
        best, distance = cheapest(deck, testbench, settings, target)
        spent = median(cpu(partial(peer, deck, testbench, best)) for _ in range(repetitions))
        rest = median(cpu(partial(ngspice.run, _op(deck(best)))) for _ in range(repetitions))
        accuracy = (
            f"ours {1e6 * error:.2f} us at rtol {rtol:g}; ngspice {1e6 * distance:.2f} us at {best}, and at"
            f" {FINEST} {converged}"
        )
        for part, mine, its in (("transient", transient, spent - rest), ("whole run", whole, spent)):
            title = f"rebound neuron, 16 ms, {part}, ngspice with {name}"
            claim = CLAIM if (name, part) == ("the same equations", "transient") else 0.0
            yield Row(title, mine, its, its / mine, accuracy, least=claim)


def neuron() -> Testbench:
    """The block's own testbench with its default stimuli."""
    block = rebound_neuron.BLOCK
    return block.bench()


def ours(testbench: Testbench, rtol: float) -> Events:
    """Run the solver."""
    result = simulate(testbench, SILICON, rtol=rtol, record=("inhibition.b",))
    release = upward_crossings(result.time, -result["inhibition.b"], -0.5 * V_DD)
    return Events(_first(result.spikes["spike"]), _first(release))


def prepared(testbench: Testbench, rtol: float) -> Callable[[], object]:
    """The solver's transient alone, from the operating point on; warmed."""
    machine = to_kernel(testbench, SILICON)
    point = operating_point(machine)
    runner = Runner(machine, ("inhibition.b",), rtol)
    return lambda: runner.advance(runner.begin(point), testbench.stop, stop_at_event=False)


def peer(deck: Callable[[Setting], str], testbench: Testbench, setting: Setting) -> Events:
    """Run ngspice."""
    flat = flatten(testbench.circuit)
    names = [f"n{flat.node(path)}" for path in ("spike", "inhibition.b")]
    waveforms = ngspice.run(deck(setting), deadline_s=60.0)
    spike, b = (waveforms.values[n] for n in names)
    release = upward_crossings(waveforms.axis, -b, -0.5 * V_DD)
    return Events(_first(upward_crossings(waveforms.axis, spike, 0.5 * V_DD)), _first(release))


def cheapest(
    deck: Callable[[Setting], str], testbench: Testbench, settings: tuple[Setting, ...], target: Events
) -> tuple[Setting, float]:
    """The setting of least CPU time that qualifies, and its distance to the target, s."""
    found: list[tuple[float, Setting, float]] = []
    for setting in settings:
        start = time.process_time()
        distance = peer(deck, testbench, setting).distance(target)
        if distance < WITHIN:
            found.append((time.process_time() - start, setting, distance))
    for _, setting, distance in sorted(found, key=lambda f: f[0]):
        if peer(deck, testbench, setting.halved()).distance(target) < WITHIN:
            return setting, distance
    raise SystemExit("no setting of ngspice qualifies")


def cpu(work: Callable[[], object]) -> float:
    """Process CPU time, s."""
    start = time.process_time()
    work()
    return time.process_time() - start


def ekv_deck(testbench: Testbench, silicon: Silicon = SILICON) -> Callable[[Setting], str]:
    """Flat deck with our equations, each transistor as it is on the die."""
    flat = flatten(testbench.circuit)
    folded = _folded(testbench, flat, silicon)

    def difference(a: str, b: str) -> str:
        if a == b:
            return law.ZERO
        terms = (
            [f"v({n})" if n != "0" else "" for n in (a, b)]
            if not {a, b} & set(folded)
            else [_term(a), _term(b)]
        )
        return f"({terms[0]}{'-' + terms[1] if terms[1] else ''})"

    def _term(node: str) -> str:
        return repr(folded[node]) if node in folded else "" if node == "0" else f"v({node})"

    lines = []
    for group, device in zip(flat.groups, _devices(flat), strict=True):
        if isinstance(device, Transistor):
            ends = (device.drain, device.source) if device.polarity == "n" else (device.source, device.drain)
            at = _on_die(device, flat.circuit.name, (*group.path, (group.device.name, ())), silicon)
            # the ideal law has no terms of its own that a node would hold
            current = law.channel_current(device, at, difference, str, _quick_softplus).current
            lines += [f"b{device.name} {' '.join(ends)} i={current}", *format_device(device, SILICON)[1:]]
        else:
            lines += format_device(device, SILICON)
    return _assembled(lines, testbench, flat, folded)


def _quick_softplus(x: str) -> str:
    """`ln(1 + e^x)`, 0 below x = -37: the error is 1e-16 absolute, 1e-32 of I_S in a current."""
    return f"(max({x},0)+ln(1+exp(-abs({x}))))"


def _on_die(device: Transistor, circuit: str, path: Path, silicon: Silicon) -> TransistorAtTemperature:
    """The law of one transistor with its deviation on the die."""
    shared = silicon.law(device.polarity)
    v_t0, beta = silicon.deviation(circuit, path, device.width * device.length * device.multiplicity)
    return replace(
        shared,
        v_t0=shared.v_t0 + float(np.ravel(v_t0)[0]),
        square_current=shared.square_current * (1.0 + float(np.ravel(beta)[0])),
    )


def bsim3_deck(testbench: Testbench) -> Callable[[Setting], str]:
    """Flat deck with BSIM3 transistors, their gates where the bias currents put them."""
    flat = flatten(testbench.circuit)
    folded = _bsim3_biases(testbench, flat)
    lines = [NMOS, PMOS]
    for device in _devices(flat):
        lines += [_bsim3(device)] if isinstance(device, Transistor) else format_device(device, SILICON)
    return _assembled(lines, testbench, flat, folded)


def _bsim3(device: Transistor) -> str:
    size = f"w={device.width!r} l={device.length!r} m={device.multiplicity!r}"
    return f"m{device.name} {' '.join(device.terminals())} {device.polarity}mos {size}"


def _bsim3_biases(testbench: Testbench, flat: FlatCircuit) -> dict[str, float]:
    """Gate voltages of the biases: diode-connected copies fed with the currents."""
    lines, wanted = [NMOS, PMOS], {}
    circuit = testbench.circuit
    voltages = {}
    for bias in circuit.biases:
        node = f"n{int(flat.port_nodes(bias.port)[0])}"
        device = circuit.device(bias.device) if bias.device else None
        if not isinstance(device, Transistor):
            voltages[node] = float(bias_voltages(circuit, bias, SILICON))
            continue
        rail = "top" if device.polarity == "p" else "0"
        copy = replace(device, name=node, drain=node, gate=node, source=rail, bulk=rail)
        ends = f"{node} 0" if rail == "top" else f"0 {node}"
        lines += [_bsim3(copy), f"i{node} {ends} dc {bias.value!r}"]
        wanted[node] = bias.name
    deck = ["* biases", *lines, f"vtop top 0 dc {V_DD!r}", f".options {OPTIONS}", ".op", ".end"]
    found = ngspice.run("\n".join(deck) + "\n").values
    return voltages | {node: float(found[node][0]) for node in wanted}


def _folded(testbench: Testbench, flat: FlatCircuit, silicon: Silicon) -> dict[str, float]:
    """Voltages of the nodes that constant sources fix."""
    return {
        f"n{int(flat.port_nodes(s.node)[0])}": s.waveform.value
        for s in complete_sources(testbench, flat, silicon)
        if isinstance(s.waveform, Constant)
    }


def _devices(flat: FlatCircuit) -> Iterator[Transistor | Capacitor]:
    """Devices of the flat circuit on nodes n1, n2, ..., named by their number."""
    for k, group in enumerate(flat.groups):
        nodes = [f"n{int(n)}" if n else "0" for n in group.nodes[:, 0]]
        device = group.device
        if isinstance(device, Transistor):
            drain, gate, source, bulk = nodes
            yield replace(device, name=str(k), drain=drain, gate=gate, source=source, bulk=bulk)
        elif isinstance(device, Capacitor):
            yield replace(device, name=str(k), a=nodes[0], b=nodes[1])


def _assembled(
    lines: list[str], testbench: Testbench, flat: FlatCircuit, folded: dict[str, float]
) -> Callable[[Setting], str]:
    """Deck of the elements and the sources, for any setting."""
    for source in testbench.sources:
        node = f"n{int(flat.port_nodes(source.node)[0])}"
        lines += format_device(replace(source, node=node), SILICON)
    driven = {f"n{int(flat.port_nodes(s.node)[0])}" for s in testbench.sources}
    lines += [
        line
        for node, value in folded.items()
        if node not in driven
        for line in format_device(Source(node, node, Constant(value)), SILICON)
    ]
    saved = " ".join(f"v(n{flat.node(path)})" for path in ("spike", "inhibition.b"))

    def deck(setting: Setting) -> str:
        tail = [
            f".options {OPTIONS} reltol={setting.reltol!r} method={setting.method}",
            f".save {saved}",
            f".tran {setting.tmax!r} {testbench.stop!r} 0 {setting.tmax!r}",
            ".end",
        ]
        return "\n".join(["* rebound neuron, flat", *lines, *tail]) + "\n"

    return deck


def _op(deck: str) -> str:
    """The same deck with its operating point as the only analysis."""
    return "\n".join(".op" if line.startswith(".tran") else line for line in deck.splitlines()) + "\n"


def _solver_error(testbench: Testbench, rtol: float, reference: Events) -> float:
    """The larger distance of the run and of the one at half the tolerance, s."""
    return max(ours(testbench, r).distance(reference) for r in (rtol, 0.5 * rtol))


def _first(times: np.ndarray) -> float:
    return float(times[0]) if times.size else float("nan")


if __name__ == "__main__":
    sys.exit(main())
