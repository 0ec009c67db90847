"""Claims: at least 1,000 steps/s of `Forest`, `Bug` and `Rover`, and 1.8 times as many by two processes.

Steps of the environments as Gymnasium makes them, with its wrappers and checks, by CPU time; actions drawn
before. A run that ends is begun anew, which counts. By chips: the forest's ranging chip of die A/1000.

Two processes: elapsed time of the same steps of 32 environments in one process (`SyncVectorEnv`) and by two
workers, of turns that alternate. It is only measured where nothing else runs: `--alone` says so; the rows are
left out otherwise.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from statistics import median
from typing import Any

import gymnasium

from _report import Row, parser_of, report

CLAIM, CLAIM_WORKERS, TOGETHER = 1000.0, 1.8, 32
MEASURED: dict[str, tuple[str, dict[str, Any]]] = {
    "Forest": ("Forest", {}),
    "Forest, ranges of a die": ("Forest", {"ideal": False, "die": 1000, "selection": "ideal"}),
    "Bug": ("Bug", {}),
    "Rover": ("Rover", {}),
    "Car": ("Car", {}),
    "Head": ("Head", {}),
    "Pushbot": ("Pushbot", {}),
    "Approach": ("Approach", {"duration": 2.0}),
}
CLAIMED = ("Forest", "Bug", "Rover")


def main() -> int:
    """Measure and print all rows."""
    parser = parser_of(__doc__, "fewer steps")
    parser.add_argument("--alone", action="store_true", help="nothing else runs: measure two processes too")
    options = parser.parse_args()
    rows = [*single(300 if options.quick else 3000)]
    if options.alone:
        rows += [*shared(100 if options.quick else 400, 1 if options.quick else 3)]
    return report(rows, options)


def id_of(name: str) -> str:
    """The id that imports what registers it."""
    return f"system.gym:noctule/{name}-v0"


def single(steps: int) -> Iterator[Row]:
    """Steps a second of CPU of one environment."""
    for name, (kind, given) in MEASURED.items():
        environment = gymnasium.make(id_of(kind), **given)
        environment.action_space.seed(1)
        actions = [environment.action_space.sample() for _ in range(steps)]
        environment.reset(seed=1000)
        environment.step(actions[0])  # compiled, or loaded
        begun, over = time.process_time(), False
        for action in actions:
            if over:
                environment.reset()
            *_, ended, late, _ = environment.step(action)
            over = ended or late
        rate = steps / (time.process_time() - begun)
        claim = CLAIM if name in CLAIMED else 0.0
        yield Row(f"{name}, steps/s", rate, None, rate, f"{steps} steps", 1, claim)


def shared(steps: int, turns: int) -> Iterator[Row]:
    """By how much two processes are faster than one."""
    for name in CLAIMED:
        ways: list[dict[str, Any]] = [{"vectorization_mode": "sync"}, {"workers": 2}]
        both = [gymnasium.make_vec(id_of(name), num_envs=TOGETHER, **way) for way in ways]
        taken: list[list[float]] = [[], []]
        for _ in range(turns):
            for each, times in zip(both, taken, strict=True):
                times.append(_elapsed(each, steps))
        for each in both:
            each.close()
        one, two = (median(times) for times in taken)
        note = f"{TOGETHER} environments, {steps} steps each: {one:.3g} s and {two:.3g} s"
        yield Row(f"{name}, two processes over one", two, one, one / two, note, 2, CLAIM_WORKERS)


def _elapsed(together: Any, steps: int) -> float:
    """Wall clock (s) of so many steps of all environments."""
    together.action_space.seed(1)
    actions = [together.action_space.sample() for _ in range(steps)]
    together.reset(seed=1000)
    together.step(actions[0])
    begun = time.perf_counter()
    for action in actions:
        together.step(action)
    return time.perf_counter() - begun


if __name__ == "__main__":
    sys.exit(main())
