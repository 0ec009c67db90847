"""Claims: the spike-latency network runs at 1.7 times real time on one core, and 15 times Brian2's speed.

The published network, 2,078 Hodgkin-Huxley and 2,931 integrate-and-fire neurons, dt 0.02 ms, exponential
Euler: ten pings a second in the scene of Figure 12, the head middle and middle left in turn, a reset after
every second ping. Both sides by CPU time of one thread, in alternating turns, their medians; all spikes are
recorded on both, compiling and building are left out.

The peer is Brian2's cpp_standalone, same synapses, delays, method and dt. It needs an interpreter of its own
(numpy below 2.3): `--brian2 PATH`; without it its rows are left out. Spikes are compared neuron by neuron:
numbers, and the largest distance of spikes in steps. A second run of ours must be the same to the bit.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

import numpy as np

from _report import Row, parser_of, report
from circuits.arrays import I64
from system.openspace.law import DIRECTIONS, Bat, arcs_of
from system.spiking_bat.bat import echo_delay, goal_neuron, nearest_place, places, seen_from
from system.spiking_bat.network.network import Conductors, Integrators, Network, Spikes, new_state, run
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.scene import HEADING, OBSTACLES, PING_RATE
from system.spiking_bat.topology import published

CLAIM, CLAIM_PEER, CLAIM_STEPS = 1.7, 15.0, 2.0
PEER = Path(__file__).parent / "_latency_network_brian2.py"


def main() -> int:
    """Measure and print all rows."""
    parser = parser_of(__doc__, "a shorter run, one turn")
    parser.add_argument("--brian2", metavar="PATH", help="interpreter that has Brian2")
    options = parser.parse_args()
    duration, turns = (0.5, 1) if options.quick else (2.0, 3)
    network = published(arcs_of(Bat(ping_rate=PING_RATE)), Numbers())
    if options.brian2 is None:
        print("Brian2 is not compared: give its interpreter, --brian2 PATH", file=sys.stderr)
    rows = measure(network, inputs_of(network, duration), duration, turns, options.brian2)
    return report(rows, options)


def inputs_of(network: Network, duration: float) -> I64:
    """Pings, echoes and resets of the whole run, int64[n, 2]."""
    arcs, step = arcs_of(Bat(ping_rate=PING_RATE)), network.wiring.step
    place = np.array([(-ahead, -left) for ahead, left in OBSTACLES])
    given = []
    for k in range(round(duration * PING_RATE)):
        start, head = round(k / PING_RATE / step), DIRECTIONS // 2 - k % 2
        given += [(start, network.number("onset")), (start, network.number("ping", head))]
        given.append((start, network.number("goal", goal_neuron(arcs, HEADING))))
        seen = seen_from(arcs, place, HEADING, head)
        late = np.rint(echo_delay(np.hypot(*seen.T)) / step).astype(int)
        for j, after in zip(nearest_place(seen, places()), late, strict=True):
            given.append((start + int(after), network.number("echo", int(j))))
        if k % 2:
            given.append((start + round(Numbers().reset_at / step), network.number("reset")))
    return np.array(sorted(given), dtype=np.int64)


def measure(
    network: Network, inputs: I64, duration: float, turns: int, interpreter: str | None
) -> Iterator[Row]:
    """Speed, agreement with the peer, and determinism."""
    first = _ours(network, inputs, duration)[0]
    own, other, peer = [], [], None
    for _ in range(turns):
        spikes, taken = _ours(network, inputs, duration)
        own.append(taken)
        if interpreter is not None:
            peer, peer_taken = _brian2(interpreter, network, inputs, duration)
            other.append(peer_taken)
    mine = median(own)
    note = f"{mine:.3g} s of CPU for {duration:g} s, {len(spikes.step)} spikes, one core"
    yield Row("times real time", mine, duration, duration / mine, note, least=CLAIM)
    same = np.array_equal(first.step, spikes.step) and np.array_equal(first.source, spikes.source)
    yield Row("second run the same to the bit", 1.0, None, float(same), "steps and sources", least=1.0)
    if peer is not None:
        theirs = median(other)
        note = f"Brian2 {theirs:.3g} s of CPU, {duration / theirs:.3g} times real time"
        yield Row("times Brian2's speed", mine, theirs, theirs / mine, note, least=CLAIM_PEER)
        yield from _compare(network, first, peer)


def _compare(network: Network, ours: Spikes, peer: I64) -> Iterator[Row]:
    """Spikes of every neuron on both sides."""
    neurons = network.wiring.begin.size - 1
    counts = np.bincount(ours.source, minlength=neurons), np.bincount(peer[:, 1], minlength=neurons)
    unequal = int((counts[0] != counts[1]).sum())
    yield Row("neurons with another number of spikes", unequal, None, unequal, f"of {neurons}", most=0.0)
    equal = counts[0] == counts[1]
    apart = []
    for step, source in ((ours.step, ours.source), (peer[:, 0], peer[:, 1])):
        order = np.lexsort((step, source))
        apart.append(step[order][equal[source[order]]])
    most = float(np.abs(apart[0] - apart[1]).max(initial=0))
    note = f"{apart[0].size} spikes"
    yield Row("largest distance of spikes, steps", most, None, most, note, most=CLAIM_STEPS)


def _ours(network: Network, inputs: I64, duration: float) -> tuple[Spikes, float]:
    state = new_state(network)
    start = time.thread_time()
    spikes, _ = run(network, state, duration, inputs)
    return spikes, time.thread_time() - start


def _brian2(interpreter: str, network: Network, inputs: I64, duration: float) -> tuple[I64, float]:
    """Spikes (step, source) and CPU time of the same network by Brian2."""
    with tempfile.TemporaryDirectory() as folder:
        write(network, inputs, duration, Path(folder) / "network.npz")
        subprocess.run([interpreter, str(PEER), folder], check=True, stdout=subprocess.DEVNULL)
        with np.load(Path(folder) / "spikes.npz") as found:
            return found["spikes"], float(found["seconds"])


def write(network: Network, inputs: I64, duration: float, path: Path) -> None:
    """Write all that the peer needs: synapses, neurons' constants, inputs."""
    w = network.wiring
    conductors = [p for p in network.populations.values() if isinstance(p, Conductors)]
    integrators = [p for p in network.populations.values() if isinstance(p, Integrators)]
    size = {p: int(np.prod(p.shape)) for p in conductors}
    neuron = {
        name: np.concatenate([np.full(size[p], getattr(p, name)) for p in conductors])
        for name in ("tau_exc", "tau_inh", "current")
    }
    leak = np.concatenate([np.full(int(np.prod(p.shape)), p.leak) for p in integrators])
    np.savez(
        path, step=w.step, duration=duration, conductors=w.conductors, release=w.release,
        source=np.repeat(np.arange(w.begin.size - 1), np.diff(w.begin)), target=w.target, delay=w.delay,
        hold=w.hold, weight=w.weight, drive=w.drive, refractory=w.refractory, released=w.released,
        leak=leak, inputs=inputs, **neuron,
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
