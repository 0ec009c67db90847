"""The verb `noctule compare`: tells whether two netlists, blocks or circuits of a user are the same."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict

from circuits.checks import implausible_allowed
from circuits.testbench import Testbench
from netlists.compare.circuits import TOLERANCE, Comparison, compare
from netlists.read import Imported, Note
from system.cli.exit_status import DONE, NO
from system.cli.import_netlist import read_file
from system.cli.output import print_json, print_line
from system.cli.verbs import Compare
from system.notice import say
from system.options.block import block_of_target
from system.options.code import code_of
from system.registry import block_and_chip_names


def compare_command(asked: Compare) -> int:
    """Print whether the circuits of two netlist files are equal.

    Returns the exit status: 0 where they are equal, else 1.
    """
    with implausible_allowed():  # what is odd about both is no difference
        a, b = (_read(each, asked) for each in (asked.first, asked.second))
    found = compare(a.circuit, b.circuit, deviations=(a.deviations, b.deviations))
    dropped = (*a.dropped, *b.dropped)
    if asked.as_json:
        print_json(_document(asked.first, asked.second, found, dropped))
    else:
        _print(found)
        for note in dropped:
            print_line(f"dropped by --drop: {note}")
    if found.equal:
        return DONE
    say(f"compare: {_counted(found)}, {len(found.differences)} differences")
    return NO


def _read(target: str, asked: Compare) -> Imported:
    """A netlist, or the circuit of a block, a chip or a user's code as it is built."""
    if target in block_and_chip_names() or code_of(target) is not None:
        return Imported(Testbench(target, block_of_target(target).build(), (), math.inf))
    return read_file(target, asked.reading)


def _document(first: str, second: str, found: Comparison, dropped: Sequence[Note]) -> dict[str, object]:
    return {
        "first": first,
        "second": second,
        "equal": found.equal,
        "devices": found.devices,
        "nodes": found.nodes,
        "size_tolerance": TOLERANCE,
        "not_compared": ["stimuli", "kinds of ports", "parasitics"],
        "dropped": [asdict(note) for note in dropped],
        "differences": [{"kind": d.kind, "path": d.path, "text": d.text} for d in found.differences],
    }


def _print(found: Comparison) -> None:
    if found.equal:
        counts = f"{found.devices[0]} devices, {found.nodes[0]} nodes"
        print_line(f"equal: {counts}; stimuli and parasitics are not compared")
        return
    print_line(f"{_counted(found)}; the first differences:")
    for difference in found.differences:
        print_line(str(difference))


def _counted(found: Comparison) -> str:
    devices, nodes = (" and ".join(map(str, pair)) for pair in (found.devices, found.nodes))
    return f"different: {devices} devices, {nodes} nodes"
