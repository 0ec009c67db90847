"""Claims: `noctule --help` answers within 0.5 s; the second run of a command starts without compiling.

Whole processes, wall time, median of five; the first simulation of the second claim starts from an empty
kernel cache in a folder of its own.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from statistics import median

COMMAND = [sys.executable, "-c", "import sys; from system.command_line import main; sys.exit(main())"]


def seconds(arguments: list[str], environment: dict[str, str] | None = None) -> float:
    """Wall time of one process."""
    start = time.perf_counter()
    subprocess.run([*COMMAND, *arguments], check=True, capture_output=True, env=environment)
    return time.perf_counter() - start


def main() -> None:
    """Time the help text, and a simulation with an empty and with a filled cache."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="one repetition less of each")
    options = parser.parse_args()
    repetitions = 3 if options.quick else 5
    helping = median(seconds(["--help"]) for _ in range(repetitions))
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        simulate = ["simulate", "rebound-neuron", "--json"]
        first = seconds(simulate, environment)
        later = median(seconds(simulate, environment) for _ in range(repetitions))
    rows = [
        {
            "name": "noctule --help",
            "ours": helping,
            "peer": 0.5,
            "ratio": 0.5 / helping,
            "accuracy": "-",
            "cores": 1,
        },
        {
            "name": "simulate rebound-neuron, kernels cached, against compiling them",
            "ours": later,
            "peer": first,
            "ratio": first / later,
            "accuracy": "same bits",
            "cores": 1,
        },
    ]
    if options.json:
        print(json.dumps(rows, indent=2))
        return
    for row in rows:
        print(f"{row['name']:64} {row['ours']:6.2f} s against {row['peer']:6.2f} s, ratio {row['ratio']:.1f}")


if __name__ == "__main__":
    main()
