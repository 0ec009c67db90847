"""The spike-latency network in Brian2's cpp_standalone, for `latency_network.py`, which starts it.

Reads network.npz of the folder that it is given, and writes spikes.npz: steps and sources of all spikes, and
the CPU seconds of the compiled program. Runs in an interpreter that has Brian2, and imports nothing of ours.
Integrate-and-fire neurons by forward Euler, which is exact for those without a leak; the maps' neurons, whose
leak matters to a thousandth, spike in the same step.
"""

from __future__ import annotations

import resource
import sys
from pathlib import Path

import brian2 as b
import numpy as np

CONDUCTORS = """
dv/dt = (g_na * m**3 * h * (50*mV - v) + g_k * n**4 * (-77*mV - v) + g_l * (-54.387*mV - v)
    + g_e * (10*mV - v) + g_i * (-70*mV - v) + current) / (1*uF/cm**2) : volt
dm/dt = a_m * (1 - m) - b_m * m : 1
dh/dt = a_h * (1 - h) - b_h * h : 1
dn/dt = a_n * (1 - n) - b_n * n : 1
a_m = 1 / exprel((25 - u) / 10) / ms : Hz
b_m = 4 * exp(-u / 18) / ms : Hz
a_h = 0.07 * exp(-u / 20) / ms : Hz
b_h = 1 / (exp((30 - u) / 10) + 1) / ms : Hz
a_n = 0.1 / exprel((10 - u) / 10) / ms : Hz
b_n = 0.125 * exp(-u / 80) / ms : Hz
u = v / mV + 65 : 1
g_e : siemens/metre**2
y_e : siemens/metre**2/second
g_i : siemens/metre**2
y_i : siemens/metre**2/second
decay_e : 1 (constant)
decay_i : 1 (constant)
current : amp/metre**2 (constant)
"""
# the alpha function (13), exactly, as ours
CONDUCTANCES = """
g_e = (g_e + dt * y_e) * decay_e
y_e = y_e * decay_e
g_i = (g_i + dt * y_i) * decay_i
y_i = y_i * decay_i
"""
INTEGRATORS = """
dx/dt = (total - leak * x) * int(t > until - 0.5*dt) * int(x > 0 or total > 0*Hz) : 1
total = drive + boxes + held : Hz
drive : Hz (constant)
leak : Hz (constant)
boxes : Hz
held : Hz
until : second
wait : second (constant)
opened : second
released : 1 (constant)
"""
ON = {
    "excite": "y_e_post += weight*siemens/metre**2/second",
    "inhibit": "y_i_post -= weight*siemens/metre**2/second",
    "latch": "held_post += weight*Hz*int(stamp < opened_post); stamp = t",
}
NEVER = 1e6 * b.second


def main(folder: Path) -> None:
    """Build, compile, run and write."""
    b.set_device("cpp_standalone", build_on_run=False)
    b.prefs.devices.cpp_standalone.openmp_threads = 0
    with np.load(folder / "network.npz") as found:
        net = {name: found[name] for name in found.files}
    b.defaultclock.dt = float(net["step"]) * b.second
    groups = neurons(net)
    monitors = [b.SpikeMonitor(group) for group in groups]
    network = b.Network(*groups, *monitors, *synapses(net, groups))
    network.run(float(net["duration"]) * b.second)
    b.device.build(directory=str(folder / "code"), run=False, compile=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    b.device.run()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    firsts = np.cumsum([0, *(len(group) for group in groups[:-1])])
    spikes = [
        np.stack([np.rint(np.asarray(m.t / b.second) / float(net["step"])), np.asarray(m.i) + first], axis=1)
        for m, first in zip(monitors, firsts, strict=True)
    ]
    np.savez(
        folder / "spikes.npz",
        spikes=np.concatenate(spikes).astype(np.int64),
        seconds=after.ru_utime - before.ru_utime,
    )


def neurons(net: dict[str, np.ndarray]) -> list[b.NeuronGroup | b.SpikeGeneratorGroup]:
    """Conductors, integrators, and inputs."""
    conductors = int(net["conductors"])
    siemens = b.msiemens / b.cm**2
    names = {"g_na": 120 * siemens, "g_k": 36 * siemens, "g_l": 0.3 * siemens}
    hh = b.NeuronGroup(
        conductors, CONDUCTORS, threshold="v >= 0*mV", refractory="v >= 0*mV", method="exponential_euler",
        namespace=names,
    )  # fmt: skip
    hh.v = -65 * b.mV
    x1, x2 = 2.5, 1.0
    pairs = {
        "m": (x1 / np.expm1(x1), 4.0),
        "h": (0.07, 1.0 / (np.exp(3.0) + 1.0)),
        "n": (0.1 * x2 / np.expm1(x2), 0.125),
    }
    for name, (opening, closing) in pairs.items():
        setattr(hh, name, opening / (opening + closing))
    hh.decay_e, hh.decay_i = (np.exp(-float(net["step"]) / net[name]) for name in ("tau_exc", "tau_inh"))
    hh.run_regularly(CONDUCTANCES, when="after_groups")
    hh.current = net["current"] * b.amp / b.metre**2
    lif = b.NeuronGroup(
        net["drive"].size, INTEGRATORS, threshold="x >= 1", reset="x = 0; until = t + wait", method="euler",
    )  # fmt: skip
    lif.drive, lif.leak = net["drive"] * b.Hz, net["leak"] * b.Hz
    forever = net["refractory"] > 1 << 60
    lif.wait = np.where(forever, float(NEVER / b.second), net["refractory"] * net["step"]) * b.second
    lif.released = net["released"].astype(float)
    first = conductors + net["drive"].size
    given = net["inputs"]
    count = int(max(net["source"].max(), given[:, 1].max())) + 1 - first
    source = b.SpikeGeneratorGroup(count, given[:, 1] - first, given[:, 0] * float(net["step"]) * b.second)
    return [hh, lif, source]


def synapses(net: dict[str, np.ndarray], groups: list) -> list[b.Synapses]:
    """All synapses, by their source, target and kind, and the release."""
    edges = np.cumsum([0, *(len(group) for group in groups)])
    origin = np.searchsorted(edges, net["source"], side="right") - 1
    goal = np.searchsorted(edges, net["target"], side="right") - 1
    kind = np.where(
        goal == 0,
        np.where(net["weight"] > 0.0, "excite", "inhibit"),
        np.where(net["hold"] < 0, "latch", "box"),
    )
    found = []
    for s in range(3):
        for name in ("excite", "inhibit", "latch", "box"):
            mine = (origin == s) & (kind == name)
            if mine.any():
                found.append(_one(net, groups[s], groups[int(goal[mine][0])], mine, name, edges))
    release = b.Synapses(
        groups[2], groups[1], on_pre="x_post = 0; until_post = 0*second; held_post = 0*Hz; opened_post = t"
    )
    marked = np.flatnonzero(net["released"])
    release.connect(i=np.full(marked.size, int(net["release"]) - edges[2]), j=marked)
    return [*found, release]


def _one(net: dict, pre: object, post: object, mine: np.ndarray, kind: str, edges: np.ndarray) -> b.Synapses:
    step = float(net["step"]) * b.second
    first_pre = edges[np.searchsorted(edges, net["source"][mine][0], side="right") - 1]
    first_post = edges[np.searchsorted(edges, net["target"][mine][0], side="right") - 1]
    if kind == "box":
        made = b.Synapses(
            pre, post, "weight : 1 (constant)",
            on_pre={"on": "boxes_post += weight*Hz", "off": "boxes_post -= weight*Hz"},
        )  # fmt: skip
    else:
        model = "weight : 1 (constant)" + ("\nstamp : second" if kind == "latch" else "")
        made = b.Synapses(pre, post, model, on_pre=ON[kind])
    made.connect(i=net["source"][mine] - first_pre, j=net["target"][mine] - first_post)
    made.weight = net["weight"][mine]
    if kind == "box":
        made.on.delay = net["delay"][mine] * step
        made.off.delay = (net["delay"][mine] + net["hold"][mine]) * step
    else:
        made.delay = net["delay"][mine] * step
    if kind == "latch":
        made.stamp = -1 * b.second
    return made


if __name__ == "__main__":
    main(Path(sys.argv[1]))
