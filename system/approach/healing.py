"""What each transistor of a neuron has to do with a lost target.

The neuron's circuit gets the chip's pulses about a call again, on the run's die, and on that die with a
single transistor healed. Those come first with which it does right, the most deviating one before others.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.silicon.edit import Edit
from circuits.solver.transient import Result, simulate
from system.approach.loop import CHIP_RTOL
from system.approach.loss import Reason, losses, reasons
from system.approach.neuron import bench_of, neuron_of, waveform
from system.approach.trace import Trace
from system.view.devices import devices_in
from system.view.film import Device, Moment, Neuron, Panel

MOST = 3  # losses of a run that are explained; ours
DRAWN = 5  # devices of a neuron whose healing is drawn; ours


def explained(trace: Trace) -> list[tuple[Moment, Neuron | None]]:
    """Return the first losses as moments, each with a neuron that lost the target where one did.

    A loss has as many moments as there are kinds of reasons, and a neuron is tried once.
    """
    found: list[tuple[Moment, Neuron | None]] = []
    known: dict[str, Neuron | None] = {}
    for begin, end in losses(trace)[:MOST]:
        before = len(found)
        for reason in reasons(trace, begin, end):
            if reason.name not in known:
                known[reason.name] = _tried(trace, reason)
            neuron = known[reason.name]
            if neuron is not None:
                found.append((_moment(reason.echo, reason), neuron))
        if len(found) == before:
            nobody = Reason(0, "", begin, begin, max(0.0, begin - 0.2), min(end, begin + 0.3))
            found.append((replace(_moment(begin, nobody), neuron=""), None))
    return found


def _moment(time: float, reason: Reason) -> Moment:
    return Moment(
        time=time, name="target lost", neuron=reason.name, why=reason.why, begin=reason.begin, end=reason.end
    )


def _tried(trace: Trace, reason: Reason) -> Neuron | None:
    """The neuron with what healing each of its transistors does; None where its transistors do right."""
    circuit, silicon, path = neuron_of(trace, reason.neuron)
    machine = to_kernel(bench_of(trace, circuit, silicon, reason.begin, reason.end), silicon)
    own = _run(machine)
    if _right(own, reason):
        return None
    devices = devices_in(machine)
    tried = []
    for name in machine.flat.labels(Transistor):
        edits = (*silicon.die.edits, Edit("heal", (f"{path}.{name}",)))
        healed = _run(on_die(machine, replace(silicon.die, edits=edits)))
        device = _told(devices[name], f"{path}.{name}", own, healed, reason)
        right = _right(healed, reason)
        rank = (not right, 0.0 if right else _wrong(healed, reason), -device.sigma)
        tried.append((rank, device, healed))
    tried.sort(key=lambda one: one[0])
    shown = [
        replace(device, waveform=_healed(device, own, healed, reason)) for _, device, healed in tried[:DRAWN]
    ]
    return Neuron(
        name=reason.name,
        devices=(*shown, *(device for _, device, _ in tried[DRAWN:])),
        waveform=_panel(f"{reason.name} {reason.why}: one such call", reason, {"v_mem": own, "spike": own}),
    )


def _run(machine: Machine) -> Result:
    return simulate(machine, rtol=CHIP_RTOL, record=("v_mem", "spike"))


def _spikes(result: Result, reason: Reason) -> F64:
    """When a neuron spikes after the call, s of the run."""
    times = result.spikes["spike"] + reason.begin
    return np.asarray(times[(times > reason.call) & (times < reason.end)])


def _right(result: Result, reason: Reason) -> bool:
    return reason.least <= _spikes(result, reason).size <= reason.most


def _wrong(result: Result, reason: Reason) -> float:
    """How far a neuron is from doing right: by its spikes, or by how low its membrane stays, V."""
    return -_peak(result, reason) if reason.least else float(_spikes(result, reason).size)


def _peak(result: Result, reason: Reason) -> float:
    """The highest voltage of the membrane after the echo, V."""
    return float(np.max(result["v_mem"][result.time + reason.begin >= reason.echo]))


def _told(device: Device, path: str, own: Result, healed: Result, reason: Reason) -> Device:
    return replace(device, path=path, mended=_said(own, healed, reason))


def _said(own: Result, healed: Result, reason: Reason) -> str:
    spikes, before = _spikes(healed, reason), _spikes(own, reason)
    if not reason.least:
        count = f"{spikes.size} {'spike' if spikes.size == 1 else 'spikes'} after the call"
        return f"{count}, as before" if spikes.size == before.size else f"{count}, not {before.size}"
    if spikes.size:
        return f"spikes {1e3 * (spikes[0] - reason.echo):.2f} ms after the echo"
    more = 1e3 * (_peak(healed, reason) - _peak(own, reason))
    return f"silent, the membrane {more:+.0f} mV" if abs(more) > 1.0 else "silent as before"


def _healed(device: Device, own: Result, healed: Result, reason: Reason) -> Panel:
    """The membrane as it is, and without the deviation of a device."""
    return _panel(f"{device.path} healed alone", reason, {"v_mem": own, "v_mem healed": healed})


def _panel(title: str, reason: Reason, runs: Mapping[str, Result]) -> Panel:
    lines = tuple(
        waveform(name, run.time + reason.begin, run[name.partition(" ")[0]]) for name, run in runs.items()
    )
    return Panel(title=f"{title}, at transistor level", unit="V", lines=lines)
