"""The verb `noctule train NETWORK --task FILE.npz`."""

from __future__ import annotations

from dataclasses import dataclass

from system.cli import shared_options as shared
from system.cli.verb import argument, part, required
from system.mapping.train.recipe import Recipe


@dataclass(frozen=True, slots=True, kw_only=True)
class Train:
    """Find a network's weights with dies in the loop."""

    network: str = argument("NETWORK", "A network's .toml, or a .nir; weights in a matrix are trained")
    task: str = required("Samples with labels, as of certify", metavar="FILE.npz")
    output: str = required("Network to write", short="o", metavar="FILE.toml")
    recipe: Recipe = part(Recipe)
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()
