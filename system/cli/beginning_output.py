"""What a run reports by itself: how it left an unstable rest state, and signals that cross no threshold."""

from __future__ import annotations

from typing import Any

from circuits.solver.beginning import Disturbance
from circuits.solver.transient import Result


def told(result: Result | None) -> dict[str, Any]:
    """Give what a run reports by itself as members of a JSON document; there are none without a run."""
    if result is None:
        return {}
    swings = {
        node: {"low_V": s.low, "high_V": s.high, "threshold_V": s.threshold}
        for node, s in result.uncrossed.items()
    }
    return {"disturbance": disturbance_document(result.disturbance), "uncrossed": swings}


def disturbance_document(found: Disturbance | None) -> dict[str, Any] | None:
    """Give the disturbance that moved a run out of its unstable rest state, for JSON; None without one."""
    return None if found is None else {"nodes": list(found.nodes), "voltage_V": found.voltage}


def told_lines(result: Result | None) -> list[str]:
    """Give what a run reports by itself as lines of text; there are none without a run."""
    if result is None:
        return []
    lines = [] if result.disturbance is None else [f"{result.disturbance}; --at-rest keeps it there"]
    begin = result.machine.testbench.begin
    if result.disturbance is None and begin == "at_rest" and not result.operating_point.stable:
        lines.append("the operating point is not stable: --at-rest keeps the run there")
    return lines + [f"{node}: {swing}" for node, swing in result.uncrossed.items()]
