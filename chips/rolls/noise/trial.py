"""The same chip in another draw of its noise: its tables stay, what draws them is another."""

from __future__ import annotations

from dataclasses import replace

from chips.lines.steps import drawn_steps
from chips.noise import SiliconNoise, die_name
from chips.noise_draw import copied_slow, new_draws
from chips.rolls.circuit import NAME
from chips.rolls.depression.layout import most_devices
from chips.rolls.program.address import NEURONS
from chips.rolls.tables import Built
from circuits.silicon.silicon import Silicon


def drawn_anew(built: Built, silicon: Silicon, noise: SiliconNoise) -> Built:
    """Return the tables of a chip with the draws of a seed and a trial, which share all else.

    built: with noise that differs by its seed and its trial alone, or without noise, which stays as it is.
    """
    path = die_name(NAME, silicon.die)
    if built.noise is not None:
        draws = new_draws(noise.seed, noise.trial, path, NEURONS)
        tables = built.noise._replace(
            draws=draws._replace(normal=draws.normal[: built.noise.draws.normal.size]),
            slow=copied_slow(built.noise.slow),
            lines=drawn_steps(built.noise.lines, noise, path),
        )
        built = replace(built, noise=tables)
    cells = built.depression
    if cells is None or cells.noise is None:
        return built
    own = cells.noise._replace(draws=new_draws(noise.seed, noise.trial, path, most_devices(cells.tables)))
    return replace(built, depression=replace(cells, noise=own))
