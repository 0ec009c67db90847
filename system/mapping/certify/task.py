"""What a network is to do: a function `task(network, seed) -> score` from 0 to 1, the same for every network.

FILE.npz      `inputs` of the channels (float64[samples, channels]; rates in Hz on ROLLS, values on the NEF
chip), and `labels`, the number of the output that is to be largest (int64[samples]); `window_s`
each, 0.1 s without; the score is the share that is right
NAME-v0       an environment of Gymnasium, or NAMESPACE/NAME-v0; numbers that are seen, over their reach, are
inputs as `system.mapping.certify.ends` says; the largest output is the action; the score is the
return over the environment's own threshold, at most 1
FILE.py:NAME  such a function of one's own

An output on ROLLS is how often its neurons spike in a window, on the NEF chip the mean of its value.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from circuits.arrays import F64, I64
from circuits.catalogue import entry_points, later
from circuits.errors import CircuitError, DataError, ParameterError
from system.files.aedat4 import UNREADABLE
from system.mapping.certify.ends import ends_of
from system.mapping.certify.player import Player
from system.mapping.nef.network import ValueNetwork
from system.mapping.network import Network
from system.options.code import code_of, guarded, load_code

gymnasium = later("gymnasium")

Task = Callable[[Player, int], float]
WINDOW = 0.1  # s, of a sample without a window of its own; ours
STEP = 20e-3  # s between two actions; ours
SEEDS = 1 << 31
ENVIRONMENTS = "gymnasium.envs"  # entry points that register environments, by their namespace


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Samples with labels; most : how many of them a run takes, drawn by its seed, all where 0."""

    inputs: F64
    labels: I64
    window: float
    most: int = 0

    def check(self, network: Network | ValueNetwork) -> None:
        """Raise `ParameterError` for a network that takes no such inputs, or has not their labels."""
        ends = ends_of(network)
        ends.check_channels(self.inputs.shape[1], "inputs")
        odd = np.argwhere(~((self.inputs >= ends.least) & (self.inputs <= ends.most)))
        if odd.size:
            k, channel = odd[0]
            told = f"inputs[{k},{channel}] {self.inputs[k, channel]:g}{ends.unit}"
            raise ParameterError(f"task: {told}, must be {ends.limits}, a {ends.noun}")
        wrong = np.flatnonzero((self.labels < 0) | (self.labels >= ends.outputs))
        if wrong.size:
            raise ParameterError(
                f"task.labels: sample {wrong[0]} has {self.labels[wrong[0]]}, must be 0 to"
                f" {ends.outputs - 1}, the outputs"
            )
        ends.check_window(self.window)

    def __call__(self, network: Player, seed: int) -> float:
        """Return the share of the samples that the network labels right; silence is wrong."""
        chosen = np.arange(len(self.labels))
        if 0 < self.most < chosen.size:
            chosen = np.sort(np.random.default_rng(seed).choice(chosen, self.most, replace=False))
        right = 0
        for k in chosen:
            outputs = network.answer(int(k), self.inputs[k], self.window)
            right += bool(outputs.any() and outputs.argmax() == self.labels[k])
        return right / chosen.size


@dataclass(frozen=True, slots=True)
class Episodes:
    """Episodes in an environment.

    name : id of the environment; reach : what each number that is seen is divided by; count : episodes a run.
    """

    name: str
    reach: tuple[float, ...]
    count: int

    def check(self, network: Network | ValueNetwork) -> None:
        """Raise `ParameterError` for a network that has not the environment's channels, or its actions."""
        ends = ends_of(network)
        ends.check_channels(ends.of_shares(np.zeros(len(self.reach))).size, self.name)
        actions = int(environment_of(self.name).action_space.n)
        if ends.outputs != actions:
            raise ParameterError(
                f"task: {self.name} has {actions} actions, must be the {ends.outputs} outputs of the"
                " network; give it a probe for each"
            )

    def __call__(self, network: Player, seed: int) -> float:
        """Return the mean return of a run's episodes over the environment's threshold."""
        environment = environment_of(self.name)
        threshold = float(environment.spec.reward_threshold)
        seeds = np.random.default_rng(seed).integers(SEEDS, size=self.count)
        returns = [self._episode(environment, network, k, int(each)) for k, each in enumerate(seeds)]
        shares = [r / threshold if threshold > 0.0 else threshold / min(r, -1e-9) for r in returns]
        return float(np.clip(shares, 0.0, 1.0).mean())

    def _episode(self, environment: Any, network: Player, number: int, seed: int) -> float:
        network.begin(number)
        seen, _ = environment.reset(seed=seed)
        total, action, over = 0.0, 0, False
        while not over:
            shares = np.clip(np.ravel(np.asarray(seen, dtype=np.float64)) / self.reach, -1.0, 1.0)
            outputs = network(network.ends.of_shares(shares), STEP)
            winners = np.flatnonzero(outputs == outputs.max())
            action = int(winners[0]) if winners.size == 1 else action
            seen, reward, ended, late, _ = environment.step(action)
            total, over = total + float(reward), bool(ended or late)
        return total


def task_of(text: str, samples: int, reach: str) -> Task:
    """Return the task of a text.

    Parameters
    ----------
    text
        As the module says.
    samples
        How many samples or episodes a run takes; all samples, or 10 episodes, where 0.
    reach
        Of each number that an environment shows, separated by commas; where empty, the larger size of its own
        two bounds.

    Raises
    ------
    DataError
        There is no such file, it has no samples, or one of them has no label.
    ParameterError
        There is no such environment, it has no actions to choose from, no threshold other than 0, it shows no
        array of numbers, or these have no bound.
    """
    code = code_of(text)
    if code is not None:
        found: Task = guarded(load_code(code), code.path)
        return found
    return _samples(Path(text), samples) if text.endswith(".npz") else _episodes(text, samples or 10, reach)


def _samples(path: Path, most: int) -> Samples:
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as held:
            inputs, told = np.asarray(held["inputs"], np.float64), np.asarray(held["labels"], np.float64)
            window = float(held["window_s"]) if "window_s" in held else WINDOW
    except (*UNREADABLE, TypeError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())[:80]
        raise DataError(f"{path}: {reason}, must have inputs and labels of numbers") from None
    if inputs.ndim != 2 or told.shape != inputs.shape[:1] or not told.size:
        shapes = f"{inputs.shape} and {told.shape}"
        raise DataError(f"{path}: inputs and labels of {shapes}, must be (samples, channels) and (samples,)")
    odd = np.flatnonzero(~(np.isfinite(told) & (told == np.round(told))))
    if odd.size:
        raise DataError(f"{path}: labels[{odd[0]}] {told[odd[0]]:g}, must be the number of an output")
    return Samples(inputs, told.astype(np.int64), window, most)


def environment_of(name: str) -> Any:
    """Return the environment of Gymnasium that an id names.

    Of an id with a namespace, as `noctule/Rover-v0`, what the entry point of that name registers is found
    without an import of its package.

    Raises
    ------
    ParameterError
        There is none of the id, it cannot be made, or Gymnasium is not installed.
    """
    namespace, slash, _ = name.rpartition(":")[2].partition("/")
    try:
        for entry in entry_points(ENVIRONMENTS).select(name=namespace) if slash else ():
            entry.load()()
        return gymnasium.make(name)
    except ModuleNotFoundError as error:
        lacking = error.name == "gymnasium"
        remedy = 'pip install "noctule[gymnasium]"' if lacking else "name an environment that is installed"
        raise ParameterError(f"task: {name}, {' '.join(str(error).split())[:140]}; {remedy}") from None
    except Exception as error:
        told = isinstance(error, CircuitError) or type(error).__module__.startswith("gymnasium")
        kind = "" if told else f"{type(error).__name__}: "
        line = f"{kind}{' '.join(str(error).split())}"[:140].rstrip(".")
        raise ParameterError(
            f"task: {name}, {line}; name an environment, FILE.npz or FILE.py:NAME"
        ) from error


def _episodes(name: str, count: int, reach: str) -> Episodes:
    environment = environment_of(name)
    space, spaces = environment.observation_space, gymnasium.spaces
    if not isinstance(environment.action_space, spaces.Discrete):
        raise ParameterError(f"task: {name} has no actions to choose from; write a FILE.py:NAME for it")
    if not environment.spec.reward_threshold:
        raise ParameterError(f"task: {name} has no threshold of its own, or 0; write a FILE.py:NAME for it")
    if not isinstance(space, spaces.Box):
        raise ParameterError(f"task: {name} shows no array of numbers; write a FILE.py:NAME for it")
    bounds = np.maximum(np.abs(space.low), np.abs(space.high))
    try:
        own = tuple(float(x) for x in (reach.split(",") if reach else np.ravel(bounds)))
    except ValueError:
        own = ()
    if len(own) != int(np.prod(space.shape)) or not all(0.0 < x < 1e6 for x in own):
        raise ParameterError(
            f'reach: "{reach}", must be {int(np.prod(space.shape))} numbers above 0, by commas; {name} has no'
            " such bounds of its own"
        )
    return Episodes(name, own, count)
