"""What a chip is to a task: the parts of it that can be healed, its players, and the noise of its devices.

The one place that knows which chip a program is for; all else of certify is the same for every chip.

The ideal are the equations that were asked for. Of a network of values these have no neurons, since what too
few of them cannot say is lost to its task whatever they are made of.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

from chips.nef import circuit as nef
from chips.nef.build import Built
from chips.noise import SiliconNoise
from chips.rolls.circuit import FILTERS, chip
from circuits.circuit import BiasKind, Circuit
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon
from system.mapping.certify.player import Player
from system.mapping.certify.spiking import ChipPlayer, IdealPlayer
from system.mapping.certify.values import AskedPlayer, NeuronPlayer
from system.mapping.chips import AnyMapped, chip_of
from system.mapping.nef.mapped import MappedValues
from system.mapping.rolls.calibrate import calibrated
from system.mapping.rolls.mapped import Mapped

NOTHING = "nothing"  # that is healed
_ROW = "rolls_chip/row[*]."
_VIRTUAL = ("virtual_exc", "virtual_inh")
Parts = Mapping[str, tuple[str, ...]]


class Where(NamedTuple):
    """On what a program runs: silicon and area of its devices over the circuit's, biases, codes and noise."""

    silicon: Silicon
    area: float
    kind: BiasKind
    codes: str
    noise: SiliconNoise | None


class OnChip(NamedTuple):
    """A chip as tasks meet it.

    noun : its name; parts : paths of the devices of each of its parts; circuits : its circuits; ideal,
    on_die : players of a mapped network.
    """

    noun: str
    parts: Parts
    circuits: Callable[[], tuple[Circuit, ...]]
    ideal: Callable[[Any], Player]
    on_die: Callable[[Any, Where], Player]


def _on_rolls(mapped: Mapped, where: Where) -> Player:
    silicon = where.silicon.of_area(where.area)
    found = _calibrated(mapped, silicon, where.kind) if where.codes == "calibrated" else mapped
    return ChipPlayer(found, silicon, where.kind, where.noise)


def _on_nef(mapped: MappedValues, where: Where) -> Player:
    built = _built(mapped, where.silicon, where.area, where.kind, solved=where.codes == "calibrated")
    return NeuronPlayer(mapped.network, built, where.noise)


@lru_cache(maxsize=16)
def _calibrated(mapped: Mapped, silicon: Silicon, kind: BiasKind) -> Mapped:
    return calibrated(mapped, silicon, kind)


@lru_cache(maxsize=4)
def _built(mapped: MappedValues, silicon: Silicon, area: float, kind: BiasKind, *, solved: bool) -> Built:
    return mapped.on(silicon, kind, solved=solved, area=area)


CERTIFIED: Mapping[str, OnChip] = {
    "rolls": OnChip(
        "ROLLS chip",
        {
            "neurons": (f"{_ROW}neuron",),
            "synapses": tuple(_ROW + name for name in ("synapse", *_VIRTUAL)),
            "filters": tuple(_ROW + name for name in FILTERS),
            "pulses": ("rolls_chip/extender", *(f"{_ROW}{name}_extender" for name in _VIRTUAL)),
        },
        lambda: (chip(),),
        lambda mapped: IdealPlayer(mapped.network),
        _on_rolls,
    ),
    "nef": OnChip(
        "NEF chip",
        {
            "neurons": (f"{nef.NAME}/neuron",),
            "stages": (f"{nef.NAME}/column[*].stage",),
            "filters": (f"{nef.NAME}/filter",),
            "lines": (f"{nef.NAME}/line",),
        },
        nef.circuits,
        lambda mapped: AskedPlayer(mapped.network),
        _on_nef,
    ),
}
HEALED: Parts = {
    NOTHING: (),
    **{
        name: tuple(path for each in CERTIFIED.values() for path in each.parts.get(name, ()))
        for every in CERTIFIED.values()
        for name in every.parts
    },
}


def certified(mapped: AnyMapped) -> OnChip:
    """Return the chip of a mapped network."""
    return CERTIFIED[chip_of(mapped.network)]


def check_part(chip: str, healed: str) -> None:
    """Raise `ParameterError` for a part that a chip, by its name, has not."""
    parts = CERTIFIED[chip].parts
    if healed != NOTHING and healed not in parts:
        raise ParameterError(
            f"healed: {healed}, the {CERTIFIED[chip].noun} has none; take {', '.join(parts)}"
        )


def usual_changes(chip: str) -> tuple[str, ...]:
    """Return the changes that tell what costs a network on a chip how much."""
    healed = (f"healed={part}" for part in CERTIFIED[chip].parts)
    return ("codes=default", *healed, "area=4", "silicon_noise=off")
