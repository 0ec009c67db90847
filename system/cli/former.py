"""What commands and options were called before; who uses an old name is told the new one."""

from __future__ import annotations

from collections.abc import Sequence

from circuits.errors import ParameterError

OPTIONS = {
    ("forest", "--model"): "a bat that thinks in spikes is run by noctule run spiking-bat --brain network",
}


def check_former(command: str | None, words: Sequence[str]) -> None:
    """Raise `ParameterError` for an option that a command had once, with what stands for it now."""
    for word in words:
        option = word.partition("=")[0]
        instead = OPTIONS.get((command or "", option))
        if instead is not None:
            raise ParameterError(f"{option}: is no option now; {instead}, chip or lif")
