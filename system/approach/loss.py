"""Where an approach loses its target, and which transistor of which neuron lost it.

A target is lost while the estimate is no longer near it, as the approach's own sentence of success has it. A
neuron lost it where the chip heard the call and the target's echo, the delay was the neuron's own, and it was
silent. What each of its transistors has to do with that is tried: the neuron's circuit gets the chip's pulses
about that call again, on the run's die, and on that die with a single transistor healed. Those come first
with which it spikes, the most deviating one before others, then those with which the membrane comes highest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.ranging.calibration.found import delays_of, off_of
from circuits.arrays import Bools
from circuits.devices import Transistor
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.silicon.edit import Edit
from circuits.solver.transient import Result, simulate
from system.approach.loop import CHIP_RTOL
from system.approach.neuron import bench_of, neuron_of, waveform
from system.approach.scenario import air_of
from system.approach.trace import NEAR, SETTLED, Trace
from system.view.devices import devices_in
from system.view.film import Device, Moment, Neuron, Panel
from system.worlds.sound.acoustics import speed_of_sound
from system.worlds.sound.microphone import Microphone
from system.worlds.sound.targets import range_at

_SHORTEST = 0.1  # s for which a target is away before it is lost; ours
_OFF = 1e-3  # s by which the target's echo may be off from where it is; ours
_LEAD = 5e-3  # s of a window before its first call; ours
_LONGEST = 60e-3  # s of a window after the call; ours
MOST = 3  # losses of a run that are explained; ours
DRAWN = 5  # devices of a neuron whose healing is drawn; ours


@dataclass(frozen=True, slots=True)
class Call:
    """A call to which the neuron of the target's delay was silent: when it and its echo were heard, s."""

    neuron: int
    time: float
    echo: float
    begin: float
    end: float


def losses(trace: Trace) -> list[tuple[float, float]]:
    """Return the stretches of time, s, in which the target is lost."""
    lost = _away(trace) & (trace.time_s >= SETTLED)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]]).astype(np.int8)))
    times = np.append(trace.time_s, trace.scenario.duration)
    pairs = [(float(times[a]), float(times[b])) for a, b in edges.reshape(-1, 2)]
    return [(begin, end) for begin, end in pairs if end - begin >= _SHORTEST]


def explained(trace: Trace) -> list[tuple[Moment, Neuron | None]]:
    """Return the first losses as moments, each with the neuron that lost the target where one did."""
    found = []
    for begin, end in losses(trace)[:MOST]:
        neuron, call = None, _silent(trace, begin, end)
        if call is not None:
            neuron = _tried(trace, call)
        about = begin, max(0.0, begin - 0.2), min(end, begin + 0.3)
        if neuron is not None and call is not None:
            about = call.echo, call.begin, call.end
        who = "" if neuron is None else neuron.name
        moment = Moment(time=about[0], name="target lost", neuron=who, begin=about[1], end=about[2])
        found.append((moment, neuron))
    return found


def _away(trace: Trace) -> Bools:
    """Where the estimate is not near the first target, bool[T]."""
    error = np.abs(trace.estimate_m - trace.range_m)
    others = [range_at(t.trajectory, trace.time_s) for t in trace.scenario.targets[1:]]
    if not others:
        return np.asarray(error > NEAR)
    return np.asarray(error >= np.min([np.abs(trace.estimate_m - r) for r in others], axis=0))


def _silent(trace: Trace, begin: float, end: float) -> Call | None:
    """The first call about a loss that the neuron of the target's delay did not answer."""
    s = trace.scenario
    speed, apart = speed_of_sound(air_of(s).temperature), Microphone().mouth_ear_delay
    delays = np.array(delays_of(s.ranging_codes))
    delays[[*off_of(s.ranging_codes)]] = np.inf
    spikes = np.array(trace.spikes, dtype=np.float64).reshape(-1, 2)
    last = np.append(trace.pulses[1:], s.duration)
    before = float(np.max(trace.pulses[trace.pulses <= begin], initial=0.0))
    for k in map(int, np.flatnonzero((trace.pulses >= before) & (trace.pulses < end))):
        call, after = float(trace.pulses[k]), float(last[k])
        delay = 2.0 * float(np.interp(call, trace.time_s, trace.range_m)) / speed - apart
        near = trace.echoes[np.abs(trace.echoes - call - delay) < _OFF]
        answered = spikes[(spikes[:, 0] > call) & (spikes[:, 0] < after)]
        neuron = int(np.argmin(np.abs(delays - delay)))
        if not near.size or neuron in answered[:, 1] or np.any(answered[:, 0] < near[0]):
            continue
        first = float(trace.pulses[max(0, k - 1)])
        return Call(neuron, call, float(near[0]), max(0.0, first - _LEAD), min(after, call + _LONGEST))
    return None


def _tried(trace: Trace, call: Call) -> Neuron | None:
    """The neuron with what healing each of its transistors does; None where its transistors do spike."""
    circuit, silicon, path = neuron_of(trace, call.neuron)
    machine = to_kernel(bench_of(trace, circuit, silicon, call.begin, call.end), silicon)
    own = _run(machine)
    if _spike(own, call) is not None:
        return None
    devices = devices_in(machine)
    tried = []
    for name in machine.flat.labels(Transistor):
        edits = (*silicon.die.edits, Edit("heal", (f"{path}.{name}",)))
        healed = _run(on_die(machine, replace(silicon.die, edits=edits)))
        device = _told(devices[name], f"{path}.{name}", own, healed, call)
        silent = _spike(healed, call) is None
        tried.append(((silent, -_peak(healed, call) if silent else -device.sigma), device, healed))
    tried.sort(key=lambda one: one[0])
    shown = [
        replace(device, waveform=_healed(device, own, healed, call)) for _, device, healed in tried[:DRAWN]
    ]
    return Neuron(
        name=f"neuron[{call.neuron}]",
        devices=(*shown, *(device for _, device, _ in tried[DRAWN:])),
        waveform=_panel("the call that it did not answer", call, {"v_mem": own, "spike": own}),
    )


def _run(machine: Machine) -> Result:
    return simulate(machine, rtol=CHIP_RTOL, record=("v_mem", "spike"))


def _spike(result: Result, call: Call) -> float | None:
    """When a neuron spikes in answer to a call, s of the run; None where it is silent."""
    times = result.spikes["spike"] + call.begin
    return next((float(t) for t in times if call.time < t < call.end), None)


def _peak(result: Result, call: Call) -> float:
    """The highest voltage of the membrane after the echo, V."""
    return float(np.max(result["v_mem"][result.time + call.begin >= call.echo]))


def _told(device: Device, path: str, own: Result, healed: Result, call: Call) -> Device:
    spike, peak = _spike(healed, call), _peak(healed, call)
    more = 1e3 * (peak - _peak(own, call))
    said = f"silent, the membrane {more:+.0f} mV" if abs(more) > 1.0 else "silent as before"
    if spike is not None:
        said = f"spikes {1e3 * (spike - call.echo):.2f} ms after the echo"
    return replace(device, path=path, mended=said)


def _healed(device: Device, own: Result, healed: Result, call: Call) -> Panel:
    """The membrane as it is, and without the deviation of a device."""
    return _panel(f"{device.path} healed alone", call, {"v_mem": own, "v_mem healed": healed})


def _panel(title: str, call: Call, runs: Mapping[str, Result]) -> Panel:
    lines = tuple(
        waveform(name, run.time + call.begin, run[name.partition(" ")[0]]) for name, run in runs.items()
    )
    return Panel(title=f"{title}, at transistor level", unit="V", lines=lines)
