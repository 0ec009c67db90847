"""Claims: Bug 0's 2,050 neurons on the NEF chip run 25 times, Bug 2's 4,010 15 times as fast as in nengo.

A mismatched die, curves measured and decoders solved on it, a time step of 1 ms, senses as the robot has them
at a wall, set every 10 ms. Both sides by CPU time of one thread, in alternating turns, their medians;
compiling and building are left out. The peer is nengo's own simulator with `optimize=True`, on the same
ensembles, connections, functions and time constants, with ideal neurons and decoders of its own. It needs an
interpreter of its own, with SciPy: `--nengo PATH`; without it its rows are left out. What both decode of the
eight rays, averaged over the run, is compared with what they were set to and with each other.

The same network under the full law, with the bias generator, is told beside, without a claim.

Measuring curves and solving decoders must take less than 5 s; a second process, with another number of BLAS
threads, must come to the same spikes to the bit.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from _report import Row, parser_of, report
from chips.nef.build import Built, build
from chips.nef.chip import NefChip
from chips.nef.network.network import Connection, EnsembleArray, Network, Neurons, Probe, join
from chips.nef.population import evaluate
from chips.nef.simulation import Simulation
from circuits.arrays import F64
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from system.bug.neural import network_of

CLAIMS = {"bug0": 25.0, "bug2": 15.0}
CLAIM_BUILD, CLAIM_RAYS = 5.0, 0.1
DIE = Die(number=3000)
INTERVAL, SETTLING = 0.01, 0.5  # s
PEER = Path(__file__).parent / "_nef_network_nengo.py"
# at a wall on the right: nearness of the rays, directions of the goal, and so on
SENSES: dict[str, Any] = {
    "ranges": [0.0, 0.1, 0.6, 0.9, 0.6, 0.1, 0.0, 0.0], "ahead": [0.8, 0.6], "north": [0.6, 0.8],
    "distance": 0.4, "touch": 1.0, "one": 1.0,
}  # fmt: skip


def main() -> int:
    """Measure and print all rows."""
    parser = parser_of(__doc__, "a shorter run, one turn")
    parser.add_argument("--nengo", metavar="PATH", help="interpreter that has nengo")
    parser.add_argument("--print-hash", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.print_hash:
        print(_hash("bug2"))
        return 0
    duration, turns = (1.0, 1) if options.quick else (4.0, 3)
    rows = [row for agent in CLAIMS for row in measure(agent, duration, turns, options.nengo)]
    rows.append(_repeats())
    status = report(rows, options)
    if options.nengo is None and not options.json:
        print("nengo is not compared: give its interpreter, --nengo PATH")
    return status


def chip_of(die: Die) -> NefChip:
    """The chip of a die without second-order effects, at fixed gates."""
    return NefChip(die, "gate", process=ROLLS_180_IDEAL)


def _whole(agent: str, duration: float, turns: int, ideal: float) -> Row:
    """Speed of the same network under the full law, at the bias generator's currents.

    ideal: CPU time, s, of the run without second-order effects.
    """
    network = _network(agent)
    built = build(network, NefChip(DIE, "generator").at(27.0), 0)
    _run(built, INTERVAL)
    took = median(_run(built, duration)[0] for _ in range(turns))
    note = f"{took / ideal:.2f} times what the ideal law takes, noise off"
    return Row(f"{agent}: times real time, full law", took, duration, duration / took, note)


def measure(agent: str, duration: float, turns: int, interpreter: str | None) -> Iterator[Row]:
    """Speed of one agent's network, beside the peer."""
    network = _network(agent)
    # a build compiles its kernels and prepares the chip's circuit, which every die shares
    build(network, chip_of(Die(number=DIE.number + 1 if DIE.number else 0)).at(27.0), 0)
    start = time.process_time()
    built = build(network, chip_of(DIE).at(27.0), 0)
    took = time.process_time() - start
    yield Row(
        f"{agent}: s to measure curves and solve",
        took,
        None,
        took,
        f"{network.neurons} neurons",
        most=CLAIM_BUILD,
    )
    ours, theirs, apart = [], [], []
    _run(built, INTERVAL)
    for _ in range(turns):
        seconds, rays = _run(built, duration)
        ours.append(seconds)
        if interpreter is not None:
            seconds, other = _nengo(interpreter, built, duration)
            theirs.append(seconds)
            apart.append(float(np.abs(rays - other).max()))
    mine = median(ours)
    if theirs:
        peer = median(theirs)
        note = f"{duration / mine:.3g} and {duration / peer:.3g} times real time, {network.neurons} neurons"
        yield Row(f"{agent}: times nengo's speed", mine, peer, peer / mine, note, least=CLAIMS[agent])
        off = median(apart)
        set_to = [float(np.abs(x - SENSES["ranges"]).max()) for x in (rays, other)]
        note = f"off what was set: ours {set_to[0]:.3f}, nengo {set_to[1]:.3f}"
        yield Row(f"{agent}: largest distance of decoded rays", off, None, off, note, most=CLAIM_RAYS)
    else:
        yield Row(f"{agent}: times real time", mine, duration, duration / mine, "one core", least=1.0)
    yield _whole(agent, duration, turns, mine)


def _run(built: Built, duration: float) -> tuple[float, F64]:
    """CPU time, s, and what is decoded of the rays, on average."""
    run = Simulation(built, INTERVAL)
    _sense(run, built.network)
    run.advance(SETTLING)
    total, steps = np.zeros(8), round(duration / INTERVAL)
    start = time.thread_time()
    for _ in range(steps):
        _sense(run, built.network)
        run.advance(INTERVAL)
        total += run.read("rays?")
    return time.thread_time() - start, total / steps


def _sense(run: Simulation, network: Network) -> None:
    for node in network.nodes:
        if node.name in SENSES:
            run.set(node.name, SENSES[node.name])


def _nengo(interpreter: str, built: Built, duration: float) -> tuple[float, F64]:
    """CPU time and the mean of the rays of the same network in nengo."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "network.pickle"
        path.write_bytes(pickle.dumps({**describe(built), "duration": duration, "settling": SETTLING}))
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        command = [interpreter, str(PEER), str(path)]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    found = json.loads(done.stdout)
    return float(found["seconds"]), np.array(found["rays"])


def describe(built: Built) -> dict[str, Any]:
    """The network as plain numbers: functions are tabulated where they are fitted."""
    network = built.network
    parts = []
    for part in network.ensembles:
        array = isinstance(part, EnsembleArray)
        each = part.each if isinstance(part, EnsembleArray) else part
        parts.append(
            {
                "name": part.name, "count": part.ensembles if isinstance(part, EnsembleArray) else 1,
                "array": array, "neurons": each.neurons, "dimensions": each.dimensions,
                "radius": each.radius, "max_rates": each.max_rates, "intercepts": each.intercepts,
                "encoders": [list(row) for row in each.encoders],
            }
        )  # fmt: skip
    nodes = [
        {"name": n.name, "size": n.size_out, "value": SENSES.get(n.name, np.zeros(n.size_out))}
        for n in network.nodes
    ]
    joined = [_joined(built, c) for c in network.connections]
    return {
        "parts": parts,
        "nodes": nodes,
        "connections": joined,
        "probes": [_probe(p) for p in network.probes],
    }


def _joined(built: Built, c: Connection) -> dict[str, Any]:
    neurons = isinstance(c.post, Neurons)
    found: dict[str, Any] = {
        "pre": c.pre, "post": c.post.name if isinstance(c.post, Neurons) else c.post, "neurons": neurons,
        "transform": np.asarray(c.transform, dtype=float), "synapse": c.synapse or None,
    }  # fmt: skip
    if c.pre in built.populations:
        points = built.populations[c.pre][0].points if c.points is None else np.asarray(c.points)
        found["points"], found["values"] = points, evaluate(c.function, points, c.pre)
    return found


def _probe(p: Probe) -> dict[str, Any]:
    return {"name": p.name, "target": p.target, "synapse": p.synapse}


def _repeats() -> Row:
    """Whether other processes with 1 and 2 BLAS threads come to the same."""
    found = []
    for threads in ("1", "2"):
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads}
        command = [sys.executable, str(Path(__file__)), "--print-hash"]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
        found.append(done.stdout.strip())
    same = float(found[0] == found[1] == _hash("bug2"))
    return Row(
        "same to the bit with 1 and 2 BLAS threads", same, None, same, "decoders and spikes", least=1.0
    )


def _network(agent: str) -> Network:
    """An agent's network, and what reads its rays."""
    return join((network_of(agent), Network(probes=(Probe("rays?", "rays"),))))


def _hash(agent: str) -> str:
    built = build(_network(agent), chip_of(DIE).at(27.0), 0)
    run = Simulation(built, INTERVAL)
    _sense(run, built.network)
    run.advance(1.0)
    digest = hashlib.sha256(built.net.decoder.tobytes())
    digest.update(run.state.spikes.tobytes())
    digest.update(run.state.y.tobytes())
    return digest.hexdigest()


if __name__ == "__main__":
    sys.exit(main())
