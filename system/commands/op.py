"""`noctule op`: where a block rests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from circuits.circuit import GROUND, BiasKind
from circuits.errors import ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.solver.operating_point import OperatingPoint, operating_point
from system.commands.output import print_json, print_line, print_table, working
from system.options import choose, describe_silicon, read_voltages
from system.registry import unknown
from system.silicon_choice import SiliconChoice

HIGHEST_START = 100.0  # V; from farther away Newton's iteration only wanders


def op_command(
    block: str,
    *,
    params: Sequence[str],
    biases: Sequence[str],
    bias_kind: BiasKind | None,
    silicon: SiliconChoice,
    stimuli: Sequence[str],
    start: Sequence[str],
    as_json: bool,
) -> None:
    """Print the operating point of `block` with its stimuli at their values at 0 s."""
    choice = choose(block, params, biases, bias_kind, silicon, stimuli)
    given = read_voltages(start, "--start")
    with working("solving (the first run compiles its kernels)"):
        machine = to_kernel(choice.testbench(), choice.silicon)
        _check_start(given, machine.names[1:])
        point = operating_point(machine, start=given or None)
    if as_json:
        print_json(
            {
                "block": choice.block.name,
                **describe_silicon(choice.silicon),
                "stimuli": choice.stimuli,
                "start_V": given,
                **_state(point),
                "other_states": [_state(other) for other in point.others],
            }
        )
    else:
        _print(point)


def _check_start(start: Mapping[str, float], nodes: Sequence[str]) -> None:
    for node, voltage in start.items():
        if node not in nodes:
            raise unknown("node", node, nodes)
        if not abs(voltage) <= HIGHEST_START:
            limit = f"must be within -{HIGHEST_START:g} to {HIGHEST_START:g} V"
            raise ParameterError(f"{node}: {voltage:g} V, {limit}; start near the supply's range")


def _state(point: OperatingPoint) -> dict[str, object]:
    voltages = {node: v for node, v in point.voltages().items() if node != GROUND}
    return {"stable": point.stable, "voltages_V": voltages}


def _print(point: OperatingPoint) -> None:
    states = (point, *point.others)
    table = [[v for node, v in s.voltages().items() if node != GROUND] for s in states]
    nodes = [node for node in point.voltages() if node != GROUND]
    headings = ["node", "voltage (V):", *("other state (V):" for _ in point.others)]
    silicon = point.machine.silicon
    title = f"operating point at {silicon.temperature_c:g} degC, {silicon.die}"
    print_table(
        title, headings, [(n, *(f"{v:.6f}" for v in row)) for n, *row in zip(nodes, *table, strict=True)]
    )
    print_line(f"the state is {_stability(point)}")
    for other in point.others:
        print_line(f"without the start another state is found, which is {_stability(other)}")


def _stability(point: OperatingPoint) -> str:
    return "stable" if point.stable else "not stable: the smallest disturbance leaves it"
