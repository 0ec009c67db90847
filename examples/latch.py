"""A circuit with two rest states: the start decides, and the solver tells which states are stable."""

from __future__ import annotations

from circuits.circuit import Circuit, Instance, Port
from circuits.devices import Source, Transistor
from circuits.devices.source import Constant
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

UM = 1e-6
SUPPLY, IN, OUT = Port("vdd", "supply"), Port("a", "analog"), Port("y", "analog", "out")

INVERTER = Circuit(
    "inverter",
    (SUPPLY, IN, OUT),
    (
        Transistor("mp", "p", "y", "a", "vdd", "vdd", 6 * UM, 1.5 * UM),
        Transistor("mn", "n", "y", "a", "0", "0", 3 * UM, 1.5 * UM),
    ),
)
LATCH = Circuit(
    "latch",
    (SUPPLY, Port("q", "analog", "out"), Port("q_bar", "analog", "out")),
    instances=(
        Instance("left", INVERTER, {"vdd": "vdd", "a": "q", "y": "q_bar"}),
        Instance("right", INVERTER, {"vdd": "vdd", "a": "q_bar", "y": "q"}),
    ),
)


def main() -> None:
    """Print the rest state that each start leads to."""
    bench = Testbench("latch", LATCH, (Source("vdd", "vdd", Constant(5.0)),), stop=1e-6)
    for start in ({"q": 0.0, "q_bar": 5.0}, {"q": 5.0, "q_bar": 0.0}, {"q": 2.2, "q_bar": 2.2}):
        point = operating_point(bench, start=start)
        kind = "stable" if point.stable else "unstable"
        print(f"from q = {start['q']:.1f} V: q = {point['q']:.4f} V, q_bar = {point['q_bar']:.4f} V, {kind}")


if __name__ == "__main__":
    main()
