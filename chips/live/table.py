"""The chips that can be opened live, by their names; users add theirs under `noctule.live_chips`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from chips.live.chip import Engine, LiveChip
from circuits.catalogue import Catalogue
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500, ROLLS_180
from circuits.silicon.silicon import Silicon

OPENERS: dict[str, str] = {
    "rolls": "chips.live.rolls:open_rolls",
    "nef-chip": "chips.live.nef:open_nef",
    "ranging-chip": "chips.live.parts:open_ranging",
    "wavefront-chip": "chips.live.parts:open_wavefront",
    "loopback": "chips.live.loopback:open_loopback",
}
PROCESSES = {"rolls": ROLLS_180, "nef-chip": ROLLS_180}
Opener = Callable[..., Engine]
_openers: Catalogue[Opener] = Catalogue("live chip", OPENERS, "noctule.live_chips")


def open_chip(
    name: str, die: Die = NOMINAL, temperature_c: float = 27.0, *, bias_kind: BiasKind = "generator",
    **given: Any,
) -> LiveChip:  # fmt: skip
    """Open a chip on a die, to be driven live.

    Parameters
    ----------
    name
        Its name: rolls, nef-chip, ranging-chip or wavefront-chip, or that of a user's own; loopback sends
        back what it is sent.
    die
        Its die; the nominal one unless given.
    temperature_c
        Its temperature, degC.
    bias_kind
        Kind of its biases.
    given
        What the chip needs besides: `program` (rolls), `network` and `probes` (nef-chip), `costs` and `goal`
        (wavefront-chip), and `noise` of its devices.

    Raises
    ------
    UnknownNameError
        There is no such chip that can be opened.
    ParameterError
        What it needs is missing or breaks a rule, or its model does not cover die and temperature.
    """
    opener = _openers.load(name)
    silicon = Silicon(PROCESSES.get(name, AMI_1500), temperature_c, die)
    try:
        engine = opener(silicon, bias_kind=bias_kind, **given)
    except TypeError as error:
        raise ParameterError(
            f"{name}: {str(error).removeprefix(f'{opener.__name__}() ')}; see open_chip"
        ) from None
    return LiveChip(engine, name)


def live_names() -> list[str]:
    """Return the names of all chips that can be opened."""
    return _openers.names()
