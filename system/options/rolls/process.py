"""The process that a robot's ROLLS chip is made in: that of its models, or one that a user names or measured.

Nothing is tuned anew for it: the network keeps its weights, a table of codes is what it is, and a calibration
brings a die to the rates that it brings any other to.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.silicon.process import ROLLS_180, Process
from circuits.silicon.process_file import process_of
from system.option import option
from system.options.codes import Coded


@dataclass(frozen=True, slots=True, kw_only=True)
class MadeIn(Coded):
    """The part of a scenario that says in which process its chip is made.

    Attributes
    ----------
    process : str
        Its name, or its file in TOML.
    """

    process: str = option(
        ROLLS_180.name, "Of its chip, a name, or a .toml as extract writes it", metavar="NAME|FILE",
        silicon=True, study=True, key="process",
    )  # fmt: skip

    @property
    def made_in(self) -> Process:
        """The process with all its second-order effects; raises as `process_of`."""
        return process_of(self.process)
