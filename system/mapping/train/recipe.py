"""How a network is trained, as options."""

from __future__ import annotations

from dataclasses import dataclass

from system.option import Checked, option

UNSEEN = 1000  # the first die that is kept for judging
LARGEST = (1 << 64) - 1  # seed, of a generator's key


@dataclass(frozen=True, slots=True)
class Recipe(Checked):
    """How a network is trained.

    Attributes
    ----------
    dies : int
        How many drawn dies are in the loop, from die 0 on; the nominal die alone where 0.
    together : int
        How many of them a step takes.
    steps : int
        How many steps it takes.
    batch : int
        Samples of a step.
    pace : float
        Of the first steps, as a share of the largest weight.
    seed : int
        Of what is drawn.

    Raises
    ------
    ParameterError
        A value is outside of its limits.
    """

    dies: int = option(16, "Drawn dies in the loop, from die 0 on; 0 for the nominal", least=0, most=UNSEEN)
    together: int = option(4, "Of them in a step", least=1, most=64)
    steps: int = option(300, "Steps of the weights", least=1, most=100_000)
    batch: int = option(32, "Samples of a step", least=1, most=4096)
    pace: float = option(
        0.03, "Of the first steps, as a share of the largest weight", unit="", above=0.0, most=1.0
    )
    seed: int = option(0, "Of what is drawn", least=0, most=LARGEST)
