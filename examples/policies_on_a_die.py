"""CartPole and MountainCar by policies trained outside, put on two sides of a ROLLS chip, on dies."""

from __future__ import annotations

from typing import NamedTuple

import gymnasium
import numpy as np
from scipy.optimize import differential_evolution

from chips.api import open_chip
from chips.api.rolls import QUIET, Program, table
from circuits.api import Die
from system.api.gym import OnChip
from system.api.play import ChipPolicy, Ranges, RateCode, VoteDecoder

SIZE, WINDOW, SOURCE = 32, 0.02, 200  # neurons of a side; s between two pushes; first column of the inputs
CURRENTS = {"NPA_WEIGHT_EXC_P": 4e-9, "NPA_WEIGHT_EXC0_P": 4e-9, "NPA_WEIGHT_EXC1_P": 8e-9}  # levels 1 to 4


class Task(NamedTuple):
    """An environment; what its numbers are counted from, and where they end; its two pushes; its goal."""

    id: str
    middle: tuple[float, ...]
    reach: tuple[float, ...]
    pushes: tuple[int, int]
    longer_is_better: bool

    def shares(self, seen):
        """Numbers as shares of their reach."""
        return (np.asarray(seen) - self.middle) / self.reach


TASKS = (
    Task("CartPole-v1", (0.0, 0.0, 0.0, 0.0), (1.0, 1.5, 0.2, 2.0), (0, 1), longer_is_better=True),
    Task("MountainCar-v0", (-0.5, 0.0), (0.7, 0.05), (0, 2), longer_is_better=False),
)


def episode(environment, act, seed):
    """Steps of an episode."""
    seen, _ = environment.reset(seed=seed)
    steps, over = 0, False
    while not over:
        seen, _, ended, late, _ = environment.step(act(seen))
        steps, over = steps + 1, ended or late
    return steps


def linear(task, weights):
    """A push to the right where a weighted sum is above 0, to the left where it is not."""
    return lambda seen: task.pushes[int(weights @ task.shares(seen) > 0.0)]


def trained(task):
    """Weights of a linear policy, the largest of them 1."""
    environment, sign = gymnasium.make(task.id), -1.0 if task.longer_is_better else 1.0

    def lost(weights):
        return sign * np.mean([episode(environment, linear(task, weights), seed) for seed in range(3)])

    bounds = [(-1.0, 1.0)] * len(task.reach)
    found = differential_evolution(lost, bounds, popsize=6, maxiter=5, seed=1, polish=False)
    return found.x / np.abs(found.x).max()


def program_of(weights):
    """Both signs of each number drive the side that its weight says, by a level from 1 to 4; 0 for none."""
    levels = np.zeros((256, 256), dtype=np.int8)
    for k, weight in enumerate(weights):
        for sign in (0, 1):
            side = int((weight > 0.0) != bool(sign))
            levels[side * SIZE : (side + 1) * SIZE, SOURCE + 2 * k + sign] = round(4.0 * abs(weight))
    levels[: 2 * SIZE, SOURCE + 2 * len(weights)] = 2
    return Program(levels, table(QUIET, CURRENTS))


def policy_on(task, program, die):
    """The program on a die, with inputs by rate, and the side that fires more as action."""
    count = 2 * len(task.reach) + 1
    sources = [np.flatnonzero(program.levels[:, SOURCE + k]) for k in range(count)]
    addresses = [[int(n) + ((256 + SOURCE + k) << 8) for n in s] for k, s in enumerate(sources)]
    code = RateCode(Ranges([0.0] * count, [1.0] * count, addresses), most=1600.0)
    sides = [[]] * (task.pushes[1] + 1)  # no neurons stand for what is between the pushes
    sides[task.pushes[0]], sides[task.pushes[1]] = range(SIZE), range(SIZE, 2 * SIZE)

    def features(seen):
        """Positive and negative part of each number, and a constant that keeps both sides awake."""
        shares = task.shares(seen)
        return np.append(np.stack([shares, -shares], axis=1).clip(0.0, 1.0).ravel(), 0.15)

    chip = open_chip("rolls", die, program=program)
    return ChipPolicy(chip, code, VoteDecoder(sides), WINDOW, features)


def main():
    """Train, and tell how many steps episodes take without a chip and on dies."""
    seeds = (1000, 1001)
    for task in TASKS:
        weights = trained(task)
        plain = gymnasium.make(task.id)
        outside = [episode(plain, linear(task, weights), seed) for seed in seeds]
        print(f"{task.id}: weights {np.round(weights, 2).tolist()}, steps outside {outside}")
        for number in (1000, 1001):
            policy = policy_on(task, program_of(weights), Die("A", number))
            environment = OnChip(gymnasium.make(task.id), policy)
            print(f"die A/{number}: {[episode(environment, lambda _: None, seed) for seed in seeds]}")


if __name__ == "__main__":
    main()
