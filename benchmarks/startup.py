"""Claims: `noctule --help` answers within 0.5 s; the second run of a command starts without compiling.

Whole processes, wall time, median of five; the first simulation of the second claim starts from an empty
kernel cache in a folder of its own.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from statistics import median

from _report import Row, parser_of, report

COMMAND = [sys.executable, "-c", "import sys; from system.cli.command_line import main; sys.exit(main())"]


def seconds(arguments: list[str], environment: dict[str, str] | None = None) -> float:
    """Wall time of one process."""
    start = time.perf_counter()
    subprocess.run([*COMMAND, *arguments], check=True, capture_output=True, env=environment)
    return time.perf_counter() - start


def main() -> int:
    """Time the help text, and a simulation with an empty and with a filled cache."""
    options = parser_of(__doc__, "one repetition less of each").parse_args()
    repetitions = 3 if options.quick else 5
    helping = median(seconds(["--help"]) for _ in range(repetitions))
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        simulate = ["simulate", "rebound-neuron", "--json"]
        first = seconds(simulate, environment)
        later = median(seconds(simulate, environment) for _ in range(repetitions))
    rows = [
        Row("noctule --help", helping, 0.5, 0.5 / helping, "-"),
        Row(
            "simulate rebound-neuron, kernels cached, against compiling them",
            later,
            first,
            first / later,
            "same bits",
        ),
    ]
    return report(rows, options, lambda r: f"{r.ours:6.2f} s against {r.peer:6.2f} s, ratio {r.ratio:.1f}")


if __name__ == "__main__":
    sys.exit(main())
