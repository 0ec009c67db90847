"""The verb `noctule train`: a network's weights are found with drawn dies in the loop."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from circuits.errors import ParameterError
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.cli.train_verb import Train
from system.mapping.certify.task import Samples, task_of
from system.mapping.chips import read_any
from system.mapping.network_file import write_network
from system.mapping.program_file import check_program_path
from system.mapping.train.picture import draw_training
from system.mapping.train.train import Trained, train
from system.plot import check_picture, save_picture

_PARTS = 10  # of the steps, of which the first and the last are told


def train_command(asked: Train) -> None:
    """Train a network, print how it went, and write it."""
    check_picture(asked.plot)
    check_program_path(asked.output)
    network, samples = read_any(asked.network), _samples(asked.task)
    with progress_bar(f"{asked.network}, {asked.recipe.dies} dies") as progress:
        trained = train(network, samples, asked.recipe, progress)
    write_network(asked.output, trained.network)
    save_picture(asked.plot, partial(draw_training, trained))
    told = _document(asked, trained)
    if asked.as_json:
        print_json(told)
        return
    rows = [
        (when, f"{told[f'loss_{when}']:.3g}", f"{told[f'right_{when}']:.1%}") for when in ("first", "last")
    ]
    print_table("tenths of the steps, on the differentiable form", ("tenth", "loss:", "right:"), rows)
    print_line(f"{told['weights']} weights trained; no chip has run: certify judges them")
    print_line(f"{asked.output}: written, for noctule map")


def _samples(text: str) -> Samples:
    """Samples of a file; raises `ParameterError` for a task along which no weights can be moved."""
    task = task_of(text, 0, "") if text.endswith(".npz") else None
    if not isinstance(task, Samples):
        raise ParameterError(f"task: {text}, must be a FILE.npz of inputs and labels; certify takes others")
    return task


def _document(asked: Train, trained: Trained[Any]) -> dict[str, Any]:
    """What is told by JSON's names."""
    found: dict[str, Any] = {
        "network": asked.network, "file": asked.output, "dies": asked.recipe.dies, "seed": asked.recipe.seed,
        "weights": trained.weights,
    }  # fmt: skip
    few = max(trained.losses.size // _PARTS, 1)
    for when, part in (("first", slice(few)), ("last", slice(-few, None))):
        found[f"loss_{when}"] = float(np.mean(trained.losses[part]))
        found[f"right_{when}"] = float(np.mean(trained.right[part]))
    return {**found, "losses": trained.losses.tolist(), "right": trained.right.tolist()}
