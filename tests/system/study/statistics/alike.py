"""Synthetic studies whose yield is known: dies that differ, and trials of a die that are alike."""

from collections.abc import Iterable, Iterator

import numpy as np

from circuits.arrays import F64

LEAST, MOST = 0.5, 0.95  # yields
CORRELATIONS = (0.02, 0.1, 0.3, 0.6)  # of two trials of a die
WORLDS = 2
_CLOSE = 3.0  # how little worlds of one die differ: parameter of their beta distribution


def studies(seeds: Iterable[int], family: str, dies: int, trials: int) -> Iterator[tuple[float, F64, float]]:
    """Yields, shares of each die's trials that pass, float64[dies], and correlations, a study a seed.

    family: `beta`, dies whose chances are of a beta distribution; `dead`, dies of which some never pass and
    the others have one chance; `worlds`, beta dies whose trials are in two worlds, which differ too.
    """
    for seed in seeds:
        rng = np.random.default_rng(seed)
        p, rho = float(rng.uniform(LEAST, MOST)), float(rng.choice(CORRELATIONS))
        yield p, _FAMILIES[family](rng, p, rho, (dies, trials)), _correlation(family, rho, trials)


def _correlation(family: str, rho: float, trials: int) -> float:
    """Correlation with which the variance of a die's share is p (1 - p) (1 + (m - 1) rho) / m."""
    if family != "worlds":
        return rho
    runs, world = trials // WORLDS, 1.0 / (1.0 + _CLOSE)
    share = rho + (1.0 - rho) * (world + (1.0 - world) / runs) / WORLDS
    return (trials * share - 1.0) / (trials - 1.0)


def _beta(rng: np.random.Generator, p: float, rho: float, shape: tuple[int, int]) -> F64:
    return rng.binomial(shape[1], _chances(rng, p, rho, shape[0])) / shape[1]


def _dead(rng: np.random.Generator, p: float, rho: float, shape: tuple[int, int]) -> F64:
    chance = p + rho * (1.0 - p)
    alive = rng.random(shape[0]) < p / chance
    return np.where(alive, rng.binomial(shape[1], chance, shape[0]), 0) / shape[1]


def _worlds(rng: np.random.Generator, p: float, rho: float, shape: tuple[int, int]) -> F64:
    dies, trials = shape
    chances = np.clip(_chances(rng, p, rho, dies), 1e-9, 1.0 - 1e-9)
    inside = rng.beta(_CLOSE * chances, _CLOSE * (1.0 - chances), (WORLDS, dies))
    return np.asarray(rng.binomial(trials // WORLDS, inside).sum(axis=0) / trials)


def _chances(rng: np.random.Generator, p: float, rho: float, dies: int) -> F64:
    spread = 1.0 / rho - 1.0
    return np.asarray(rng.beta(p * spread, (1.0 - p) * spread, dies))


_FAMILIES = {"beta": _beta, "dead": _dead, "worlds": _worlds}
