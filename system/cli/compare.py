"""The verb `noctule compare`: tells whether two netlists are the same circuit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from circuits.checks import implausible_allowed
from netlists.compare.circuits import TOLERANCE, Comparison, compare
from netlists.read import Note
from system.cli.exit_status import DONE, NO
from system.cli.import_netlist import read_file
from system.cli.output import print_json, print_line
from system.cli.verbs import Compare
from system.notice import say


def compare_command(asked: Compare) -> int:
    """Print whether the circuits of two netlist files are equal.

    Returns the exit status: 0 where they are equal, else 1.
    """
    with implausible_allowed():  # what is odd about both is no difference
        a, b = (read_file(path, asked.reading) for path in (asked.first, asked.second))
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
