"""The latency chip as one circuit of transistors: delay line, memories, two racing layers, emergency.

A ping's onset starts the delay line and resets integrating neurons, cells and latches. Events of a memory
come to its synapses; the integrating neuron's spike goes to the memory's units, and what they say, to the
first layer's cells as far as `REACH` from it. The first layer's spikes go to the second one's cells, which
are the winners. Places are those of `chips.latency.model`, so that a die has the same devices in both; copies
of the generator are drawn for the ports of this circuit, others than the model's. Wires are resistors.

Beside it are the maps, the motors, the bus, and two switches: which synapse of a memory an event comes to,
and which of the goal's lines each cell has, which is a parameter here.

A small chip simulates whole: two memories of two units in 7 s for two pings. Groups of like sizes and equal
passive currents unless the biases are set; those of a bat's arcs are biases.

Source: Wen & Horiuchi 2022, section 3, Figures 6 to 8; circuits and sizes are ours.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from chips.latency.design import NAME, REACH, REFERENCE, SYNAPSES, Design, Line
from chips.latency.model import usual_biases
from circuits.blocks.block import Block, Stimulus, Values
from circuits.blocks.latency import neuron as latency_neuron
from circuits.blocks.latency import unit as latency_unit
from circuits.blocks.latency.layer import RECURRENT_CAPACITANCE, recurrent_inhibition
from circuits.blocks.latency.parts import any_of, edge_pulse, following_cell, lone_cell, racing_cell
from circuits.blocks.latency.tap import delay_tap
from circuits.blocks.latency.tonic import reset_wave
from circuits.circuit import Bias, Circuit, Instance, InstanceArray, Node, Port
from circuits.count import whole_number
from circuits.devices import Resistor, Source
from circuits.devices.source import Constant, Pulse, Waveform
from circuits.errors import ParameterError
from circuits.event import EDGE, WIDTH
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

GROUPS = 5
TIMER = 5e-12  # F, of the delay line's taps
# line of the design: the device that it biases
_DEVICES = {
    "tap": "tap.mt", "integrating": "memory.neuron.synapse0.me", "step": "memory.neuron.synapse0.mt",
    "cd": "memory.unit.cd.input0.me", "window": "memory.unit.cd.input0.mt",
    "tonic": "memory.unit.inh.cell.mp", "hold": "memory.unit.inh.hold.mt", "block": "memory.unit.gate.mt",
    "passive": "first.mp", "goal": "first.excite0.me", "direction": "first.excite1.me",
    "pulse": "first.excite0.mt", "inhibit": "first.inhibit0.mk", "inhibition": "first.inhibit0.mt",
    "second": "second.excite0.me", "kept": "second.excite0.mt", "recurrent": "recurrent.mt",
    "emergency": "emergency.mp", "comparator": "first.threshold.mc0",
}  # fmt: skip
_MEMORY_LINES = ("integrating", "step", "cd", "window", "tonic", "hold", "block")


@dataclass(frozen=True, slots=True)
class Params:
    """Size of the chip: numbers of memories, of units of each, and of synapses of each.

    goal: the cell at which the goal lies, -1 for the middle; wire_resistance: of the wires between arrays,
    Ohm. Raises `ParameterError` for a chip that cannot be built.
    """

    paths: int = quantity(33, "")
    taps: int = quantity(15, "")
    synapses: int = quantity(SYNAPSES, "")
    goal: int = quantity(-1, "")
    wire_resistance: float = quantity(100.0, "Ohm")

    def __post_init__(self) -> None:
        for name in ("paths", "taps", "synapses"):
            whole_number(name, getattr(self, name))
        if self.goal != int(self.goal) or not -1 <= self.goal < self.paths:
            raise ParameterError(f"goal: {self.goal:g}, must be a cell, 0 to {self.paths - 1}, or -1")


def design_of(params: Params) -> Design:
    """Return the chip's design, with groups of like sizes and equal passive currents."""
    n = int(params.paths)
    group = tuple(k * GROUPS // n if n >= GROUPS else k for k in range(n))
    return Design(group, (1.0,) * n, tuple(2e-3 + 2.8e-3 * k for k in range(GROUPS)), taps=int(params.taps))


def build(params: Params = Params()) -> Circuit:
    """Build the chip.

    Its event inputs are onset, reset, goal, direction[groups] and event[paths, synapses]; its outputs are
    winner[paths], emergency_out and memory_out[paths], which is what the memories send to the first layer.
    The others are the biases and the supply.
    """
    n, u = int(params.paths), int(params.taps)
    design, biases = design_of(params), _biases(params)
    ports = (
        Port("vdd", "supply"),
        *(Port(name, "event") for name in ("onset", "reset", "goal")),
        Port("direction", "event", "in", (max(design.group) + 1,)),
        Port("event", "event", "in", (n, int(params.synapses))),
        Port("memory_out", "event", "out", (n,)),
        Port("winner", "event", "out", (n,)),
        Port("emergency_out", "event", "out"),
        *(Port(b.port, "bias", "in", np.shape(b.value)) for b in biases),
    )
    nodes = (
        Node("tap_in", (u + 1,)), Node("tap_out", (u + 1,)), Node("tapped", (u,)),
        Node("inhibiting", (n, 2 * REACH + 1)), Node("directed", (n,)), Node("first_out", (n,)),
        Node("racing", (2, n + 1)), Node("stopped", (2,)),
    )  # fmt: skip
    return Circuit(NAME, ports, tuple(_wires(params, design.group)), tuple(_instances(params)), nodes, biases)


def memory(units: int, synapses: int) -> Circuit:
    """Build a memory; its ports are event[synapses], tap[units], onset, reset, spike and the biases."""
    neuron = latency_neuron.build(latency_neuron.Params(synapses=synapses))
    unit, pulse, out = latency_unit.build(), edge_pulse(), any_of(units)
    ports = (
        Port("vdd", "supply"),
        Port("event", "event", "in", (synapses,)),
        Port("tap", "event", "in", (units,)),
        *(Port(name, "event") for name in ("onset", "reset")),
        Port("spike", "event", "out"),
        *(Port(f"v_{name}", "bias") for name in (*_MEMORY_LINES, "cmp", "ref")),
    )
    same = {"v_cmp": "v_cmp", "v_ref": "v_ref", "vdd": "vdd"}
    array = unit.wired(integrating="spoken", spike="detected", v_exc="v_cd")  # fmt: skip
    return Circuit(
        "latency_memory",
        ports,
        (),
        (
            Instance("neuron", neuron, same | {
                "event": "event", "reset": "onset", "spike": "integrated", "v_exc": "v_integrating",
                "v_step": "v_step",
            }),
            Instance("pulse", pulse, {
                "vdd": "vdd", "level": "integrated", "out": "spoken", "v_cmp": "v_cmp",
            }),
            InstanceArray("unit", unit, (units,), array),
            Instance("out", out, {"vdd": "vdd", "each": "detected", "out": "spike"}),
        ),
        (Node("detected", (units,)),),
    )  # fmt: skip


def _instances(params: Params) -> Iterator[Instance | InstanceArray]:
    n, u = int(params.paths), int(params.taps)
    shared = {"vdd": "vdd", "v_cmp": "v_comparator", "v_ref": "v_ref"}
    race = shared | {"reset": "onset"}
    tap, kept = delay_tap(TIMER), memory(u, int(params.synapses))
    yield InstanceArray(
        "tap", tap, (u + 1,), shared | {"event": "tap_in", "out": "tap_out", "v_tap": "v_tap"}
    )
    lines = {f"v_{name}": f"v_{name}" for name in _MEMORY_LINES}
    yield InstanceArray("memory", kept, (n,), shared | lines | {
        "event": "event", "tap": "tapped", "onset": "onset", "reset": "reset", "spike": "memory_out",
    })  # fmt: skip
    lines = {f"v_{x}": f"v_{x}" for x in ("passive", "goal", "direction", "pulse", "inhibit", "inhibition")}
    yield InstanceArray("first", racing_cell(REACH), (n,), race | lines | {
        "goal": "goal", "direction": "directed", "inhibit": "inhibiting", "stop": "stopped[0]",
        "spike": "first_out",
    })  # fmt: skip
    yield InstanceArray("second", following_cell(), (n,), race | {
        "excite": "first_out", "stop": "stopped[1]", "spike": "winner", "v_second": "v_second",
        "v_kept": "v_kept",
    })  # fmt: skip
    stop = recurrent_inhibition(RECURRENT_CAPACITANCE, n + 1)
    yield InstanceArray("recurrent", stop, (2,), race | {
        "spike": "racing", "stop": "stopped", "v_recurrent": "v_recurrent",
    })  # fmt: skip
    yield Instance("emergency", lone_cell(), race | {
        "stop": "stopped[0]", "spike": "emergency_out", "v_passive": "v_emergency",
    })  # fmt: skip


def _wires(params: Params, group: tuple[int, ...]) -> Iterator[Resistor]:
    """Wires between arrays whose elements do not stand side by side."""
    n, u = int(params.paths), int(params.taps)
    pairs = [("onset", "tap_in[0]")]
    pairs += [(f"tap_out[{k}]", f"tap_in[{k + 1}]") for k in range(u)]
    pairs += [(f"tap_out[{k + 1}]", f"tapped[{k}]") for k in range(u)]
    for p in range(n):
        pairs.append((f"direction[{group[p]}]", f"directed[{p}]"))
        pairs += [(f"first_out[{p}]", f"racing[0,{p}]"), (f"winner[{p}]", f"racing[1,{p}]")]
        for k in range(2 * REACH + 1):
            q = p + k - REACH
            pairs.append((f"memory_out[{q}]" if 0 <= q < n else "0", f"inhibiting[{p},{k}]"))
    pairs += [("emergency_out", f"racing[0,{n}]"), ("0", f"racing[1,{n}]")]
    for k, (a, b) in enumerate(pairs):
        yield Resistor(f"w{k}", b, a, params.wire_resistance)


def _biases(params: Params) -> tuple[Bias, ...]:
    """The design's lines; the goal's and the second layer's are each cell's own here."""
    n, design = int(params.paths), design_of(params)
    goal = n // 2 if params.goal < 0 else int(params.goal)
    own = {"goal": np.abs(np.arange(n) - goal), "second": np.array(design.group)}
    made = []
    for name, line in usual_biases(design).lines.items():
        current = line.current[own[name]] if name in own else line.current
        made.append(Bias(f"i_{name}", f"v_{name}", "gate", _value(line, current), _DEVICES[name]))
    return (*made, Bias("v_ref", "v_ref", "voltage", REFERENCE))


def _value(line: Line, current: np.ndarray) -> float | tuple[float, ...]:
    return tuple(map(float, current)) if line.current.shape else float(current)


FIRST, PERIOD = 25e-3, 100e-3  # s, ours: the first ping, INH having settled, and the second
LATER = 75e-3  # s, that a run goes on after its last ping

STIMULI = (
    Stimulus("first", "s", 5e-3, "event of memory 0, after the first ping", can_be_off=True),
    Stimulus("second", "s", None, "event of memory 1", can_be_off=True),
    Stimulus("goal", "s", 5e-3, "charge of the goal, after each ping", can_be_off=True),
    Stimulus("direction", "s", None, "charge of the first direction", can_be_off=True),
    Stimulus("pings", "", 2.0, "how many, 1 or 2"),
    Stimulus("duration", "s", None, "length of the run", can_be_off=True),
)


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Return a testbench: a reset until 30 us, a ping at 25 ms, and one 0.1 s later unless `pings` is 1.

    Events of the first two memories, of the goal and of the first direction come the stimuli's times after
    the first ping, those of goal and direction after the second too. Raises `ParameterError` for stimuli that
    the circuit cannot have.
    """
    pings = stimuli["pings"] or 1.0
    if pings not in (1.0, 2.0):
        raise ParameterError(f"pings: {pings:g}, must be 1 or 2")
    starts = [FIRST + k * PERIOD for k in range(int(pings))]
    given: dict[str, list[float]] = {"onset": starts}
    for name, port, again in (
        ("first", "event[0,0]", False), ("second", "event[1,0]", False),
        ("goal", "goal", True), ("direction", "direction[0]", True),
    ):  # fmt: skip
        after = stimuli[name]
        if after is not None:
            if not after > 0.0:
                raise ParameterError(f"{name}: {after:g} s, must be > 0 s after the ping, or off")
            given[port] = [at + after for at in (starts if again else starts[:1])]
    sources = [Source("vdd", "vdd", Constant(v_dd)), Source("reset", "reset", reset_wave(None, v_dd))]
    for event in ("onset", "goal", "direction", "event"):
        nodes = circuit.port(event).elements()
        sources += [Source(node, node, _events(given.pop(node, []), v_dd)) for node in nodes]
    if given:
        raise ParameterError(f"second: not on a chip of {circuit.port('event').shape[0]} memories; give off")
    stop = stimuli["duration"] or starts[-1] + LATER
    watch = ("memory_out", "winner", "emergency_out")
    return Testbench("latency chip", circuit, tuple(sources), stop, watch=watch)


def _events(times: list[float], v_dd: float) -> Waveform:
    return Pulse(0.0, v_dd, tuple(times), WIDTH, EDGE, EDGE) if times else Constant(0.0)


def latencies(result: Result, port: str, ping: int) -> tuple[float, ...]:
    """Return the latency of each element's first spike after a ping, s, inf where there is none."""
    start, found = FIRST + ping * PERIOD, []
    for node in result.machine.testbench.circuit.port(port).elements():
        times = result.spikes[node]
        mine = times[(times >= start) & (times < start + PERIOD)]
        found.append(float(mine[0]) - start if mine.size else math.inf)
    return tuple(found)


def measures(result: Result) -> dict[str, float | None]:
    """Return `memory_s` of memory 0 at the first ping, `recall_s` at the second, and `winner_s`."""
    heard, recalled = (latencies(result, "memory_out", k)[0] for k in range(2))
    winner = min(latencies(result, "winner", 0))
    return {
        "memory_s": heard if math.isfinite(heard) else None,
        "recall_s": recalled if math.isfinite(recalled) else None,
        "winner_s": winner if math.isfinite(winner) else None,
    }


def outcome(result: Result) -> str:
    """Return the winners of the first ping, `emergency`, or `none`."""
    won = [str(k) for k, at in enumerate(latencies(result, "winner", 0)) if math.isfinite(at)]
    alarm = math.isfinite(latencies(result, "emergency_out", 0)[0])
    return "emergency" if alarm else " ".join(won) or "none"


CHIP = Block(
    name="latency-chip",
    summary="33 latency memories, delay line, two racing layers; a part: paths=2, taps=2",
    build=build,
    stimuli=STIMULI,
    testbench=testbench,
    measures=measures,
    outcome=outcome,
    plotted=("onset", "tap_out[0]", "memory[0].integrated", "memory_out[0]", "first[0].v_mem", "winner[0]"),
)
