"""Claim: the codes that the Pushbot's nominal die has under the full law are those that its searches find.

Both searches start anew: that of the whole network from the codes of the ideal law, and that of the modified
network from what the first ends at. `ours` counts codes that the search moved, `peer` those of them that the
package ships; that the die then does what it did is a test's.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from _report import Row, parser_of, report
from chips.rolls.program.bias_file import COARSE_NAMES, BiasTable
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.pushbot.network.biases import (
    FULL_LAW,
    FULL_LAW_MODIFIED,
    LEVELS,
    modified_biases,
    pushbot_biases,
)
from system.pushbot.network.law_calibration import calibrate_law
from system.pushbot.network.modified import field_network, modified_network
from system.pushbot.network.modified_calibration import calibrate_modified
from system.pushbot.network.plain import PAPER

Codes = Mapping[str, tuple[str, int]]
FULL = Silicon(ROLLS_180)


def main() -> int:
    """Search twice, and print what was found."""
    options = parser_of(__doc__, "the whole network's codes alone").parse_args()
    return report(
        rows(quick=options.quick), options, lambda row: f"{row.ours:.0f} codes, shipped {row.peer:.0f}"
    )


def rows(*, quick: bool) -> Iterator[Row]:
    """One row a network."""
    table = pushbot_biases()
    found = calibrate_law(field_network(PAPER, LEVELS), table, FULL)
    yield row("whole network", named(found, table), FULL_LAW)
    if quick:
        return
    table = pushbot_biases(law="full")
    graded = modified_network(LEVELS, modified_biases(table))
    found = calibrate_modified(graded, table, FULL, "generator").biases
    yield row("modified network", named(found, modified_biases(table)), FULL_LAW_MODIFIED)


def named(table: BiasTable, other: BiasTable) -> Codes:
    """What a table has other codes for than another."""
    codes, others = table.codes(), other.codes()
    return {n: (COARSE_NAMES[c], f) for n, (c, f) in codes.items() if (c, f) != others[n]}


def row(name: str, found: Codes, shipped: Codes) -> Row:
    """How many of the codes that were found are shipped ones: all, and no others."""
    same = len(found.items() & shipped.items())
    missed = sorted(set(shipped.items()) ^ set(found.items()))
    said = "none differs" if not missed else f"differ: {missed}"
    return Row(name, len(found), same, same / max(len(found), len(shipped)), said, 1, 1.0, 1.0)


if __name__ == "__main__":
    raise SystemExit(main())
