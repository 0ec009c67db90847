"""A robot whose runs take no time: whether one succeeds follows from draws of its die, world and noise."""

ROBOT = '''
from dataclasses import dataclass

import numpy as np

from circuits.errors import ParameterError
from system.option import check_options, option
from system.options.noise import Noisy, check_noise, noise_option, noise_seed_option
from system.options.on_silicon import OnSilicon
from system.system import SUCCEEDED, Account, System, metrics_with


@dataclass(frozen=True, slots=True)
class Scenario(OnSilicon):
    """A try."""

    level: str = option("behavioural", "Of its chip")
    area: float = option(1.0, "Of its devices, relative", unit="", above=0.0, study=True)
    broken: int = option(-1, "Die that cannot be calibrated", study=True)
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()

    def __post_init__(self) -> None:
        check_options(self)
        check_noise(self.silicon_noise, self.noise_seed)


@dataclass(frozen=True, slots=True)
class Trace:
    scenario: Scenario
    way: float


def run(scenario, progress=None):
    s = scenario
    if s.die.number == s.broken:
        raise ParameterError(f"chip: die {s.broken} cannot be calibrated")
    seeds = s.die.number, s.seed, s.seed if s.noise_seed is None else s.noise_seed
    die, world, noise = (
        np.random.default_rng((k, n)).standard_normal() for n, k in enumerate(seeds)
    )
    worse = 0.05 * abs(s.temperature_c - 27.0)
    return Trace(s, 1.0 + die / np.sqrt(s.area) + 0.5 * world + 0.5 * noise - worse)


def account(trace):
    return Account(trace.way > 0.0, "it is over", {}, distance_m=float(trace.way))


def draw(trace, figure):
    figure.subplots().plot([0.0, trace.way])


SYSTEM = System(
    name="tries",
    summary="tries",
    kind=Scenario,
    success="it comes forward",
    run=run,
    account=account,
    numbers=lambda trace: {"far": None if trace.way < -1.0 else float(trace.way > 1.0)},
    draw=draw,
    metrics=metrics_with(("far",)),
    yes_no=(SUCCEEDED, "far"),
)
'''
