"""CartPole by a policy that was trained outside, put on two populations of a ROLLS chip, on three dies."""

from __future__ import annotations

import gymnasium
import numpy as np
from scipy.optimize import differential_evolution

from chips.api import open_chip
from chips.api.rolls import QUIET, Program, table
from circuits.api import Die
from system.api.gym import OnChip
from system.api.play import ChipPolicy, Ranges, RateCode, VoteDecoder

REACH = np.array(
    [1.0, 1.5, 0.2, 2.0]
)  # of cart's place and speed, pole's angle and rate, at which inputs end
SIZE, WINDOW, SOURCE = 32, 0.02, 200  # neurons of a side; s between two pushes; first column of the inputs
CURRENTS = {"NPA_WEIGHT_EXC_P": 4e-9, "NPA_WEIGHT_EXC0_P": 4e-9, "NPA_WEIGHT_EXC1_P": 8e-9}  # levels 1 to 4


def episode(environment, policy, seed):
    """Steps that a policy keeps the pole up, 500 at most."""
    seen, _ = environment.reset(seed=seed)
    for k in range(500):
        seen, _, fallen, over, _ = environment.step(policy(seen))
        if fallen or over:
            return k + 1
    return 500


def trained():
    """Weights of a linear policy, from -1 to 1, of numbers as shares of their reach."""
    environment = gymnasium.make("CartPole-v1")

    def lost(weights):
        return -np.mean(
            [episode(environment, lambda x: int(weights @ (x / REACH) > 0.0), s) for s in range(3)]
        )

    found = differential_evolution(lost, [(-1.0, 1.0)] * 4, popsize=6, maxiter=5, seed=1, polish=False)
    return found.x / np.abs(found.x).max()


def program_of(weights):
    """Both signs of each number drive the side that its weight says, by a level from 1 to 4; 0 for none."""
    levels = np.zeros((256, 256), dtype=np.int8)
    for k, weight in enumerate(weights):
        for sign in (0, 1):
            side = int((weight > 0.0) != bool(sign))
            levels[side * SIZE : (side + 1) * SIZE, SOURCE + 2 * k + sign] = round(4.0 * abs(weight))
    levels[: 2 * SIZE, SOURCE + 8] = 2
    return Program(levels, table(QUIET, CURRENTS))


def policy_on(program, die):
    """The program on a die, with inputs by rate, and the side that fires more as action."""
    chip = open_chip("rolls", die, program=program)
    sources = [np.flatnonzero(program.levels[:, SOURCE + k]) for k in range(9)]
    addresses = [[int(n) + ((256 + SOURCE + k) << 8) for n in s] for k, s in enumerate(sources)]
    encoder = RateCode(Ranges([0.0] * 9, [1.0] * 9, addresses), most=1600.0)
    sides = [range(SIZE), range(SIZE, 2 * SIZE)]
    return ChipPolicy(chip, encoder, VoteDecoder(sides), WINDOW, features)


def features(seen):
    """Positive and negative part of each number as shares, and a constant that keeps both sides awake."""
    shares = np.asarray(seen) / REACH
    return np.append(np.stack([shares, -shares], axis=1).clip(0.0, 1.0).ravel(), 0.15)


def main() -> None:
    """Train, and tell how long the pole stays up without the chip and on dies."""
    weights = trained()
    plain = gymnasium.make("CartPole-v1")
    seeds = range(1000, 1002)
    print(f"weights {np.round(weights, 2).tolist()}")
    print(f"outside: {[episode(plain, lambda x: int(weights @ (x / REACH) > 0.0), s) for s in seeds]}")
    program = program_of(weights)
    for number in (1000, 1001, 1002):
        environment = OnChip(gymnasium.make("CartPole-v1"), policy_on(program, Die("A", number)))
        print(f"die A/{number}: {[episode(environment, lambda _: None, s) for s in seeds]}")


if __name__ == "__main__":
    main()
