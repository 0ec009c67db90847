"""Claims: help, list and show answer within 0.3 s; a command's first run takes at most 2.5 times its second.

Whole processes, processor time, median of five, byte code kept. The first simulation of the second claim
starts from an empty kernel cache in a folder of its own, so that it compiles what the installation does not
ship.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from statistics import median

from _report import Row, parser_of, report

LIMIT, FIRST = 0.3, 2.5  # s; times
QUICK_ONES = (["--help"], ["list"], ["show", "dpi-synapse"])
COMMAND = [sys.executable, "-c", "import sys; from system.cli.command_line import main; sys.exit(main())"]


def seconds(arguments: list[str], environment: dict[str, str]) -> float:
    """Processor time of one process, s."""
    before = _spent()
    subprocess.run([*COMMAND, *arguments], check=True, capture_output=True, env=environment)
    return _spent() - before


def _spent() -> float:
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def main() -> int:
    """Time commands that compute nothing, and a simulation with an empty and with a filled cache."""
    options = parser_of(__doc__, "three repetitions instead of five").parse_args()
    repetitions = 3 if options.quick else 5
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        own = {"PYTHONPYCACHEPREFIX": f"{folder}/python", "NUMBA_CACHE_DIR": f"{folder}/kernels"}
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"} | own
        for words in QUICK_ONES:
            seconds(words, environment)  # writes the byte code
            taken = median(seconds(words, environment) for _ in range(repetitions))
            rows.append(Row(f"noctule {' '.join(words)}, s", taken, LIMIT, taken, "-", most=LIMIT))
        simulate = ["simulate", "rebound-neuron", "--json"]
        first = seconds(simulate, environment)
        later = median(seconds(simulate, environment) for _ in range(repetitions))
    name = "simulate rebound-neuron, first run over second"
    rows.append(Row(name, first, later, first / later, "s of both", most=FIRST))
    return report(rows, options, lambda r: f"{r.ours:6.2f} s against {r.peer:6.2f} s")


if __name__ == "__main__":
    sys.exit(main())
