"""Former names of commands and options, for which the command line names what takes their place."""

from __future__ import annotations

from collections.abc import Sequence

from circuits.errors import ParameterError

OPTIONS = {
    ("forest", "--model"): "a bat that thinks in spikes is run by noctule run spiking-bat --brain network",
}


def check_former(command: str | None, words: Sequence[str]) -> None:
    """Raise `ParameterError` for an option that a command no longer has, naming what stands for it.

    command: name of the command; words: its arguments as they were typed.
    """
    for word in words:
        option = word.partition("=")[0]
        instead = OPTIONS.get((command or "", option))
        if instead is not None:
            raise ParameterError(f"{option}: is no option now; {instead}, chip or lif")
