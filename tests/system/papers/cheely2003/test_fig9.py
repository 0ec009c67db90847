"""Figure 9: delays at which no neuron fires are counted."""

from __future__ import annotations

from system.papers.cheely2003 import fig9 as cheely2003_fig9


def test_silent_delays_of_the_linear_chip_are_counted_and_told() -> None:
    fractions: list[float] = []
    report = cheely2003_fig9.run_on_grid(fractions.append, 6.5e-3)
    ours = {row.name: row.shown for row in report.rows}
    # of 2, 8.5, 15, 21.5 and 28 ms those between neuron 11 (11 ms) and neuron 12 (26 ms) have no neuron
    assert ours["linear_silent_delays"] in (2, 3)
    assert any("no neuron fires" in note for note in report.notes)
