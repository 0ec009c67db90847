"""Which codes the biases of a robot's chips have: of a calibration of the die, of the design, or of a file.

A robot's scenario has these fields by deriving from `Coded`, and names the calibrations of its chips in
`CALIBRATED`.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

from chips.codes import Codes
from chips.validity import require_area
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, Process
from system.codes.file import read_codes
from system.codes.find import codes_on, setup_of
from system.option import option
from system.options.die.file import read_die_file
from system.options.on_silicon import ROOM_TEMPERATURE, OnSilicon
from system.reader import whole
from system.registry import load_calibration

CALIBRATED, DEFAULT = "calibrated", "default"


def _read_coded_on(text: str, name: str) -> Die:
    """The die of a number, in the usual lot, or of a file."""
    return read_die_file(Path(text)) if text.endswith(".toml") else Die(number=whole(text, name))


@dataclass(frozen=True, slots=True, kw_only=True)
class Coded(OnSilicon):
    """The part of a scenario that says which codes its chips' biases have.

    Attributes
    ----------
    codes : str or None
        `calibrated` for those of a calibration of the die, `default` for those of the design, or files that
        `noctule calibrate` wrote, with commas between; a chip without a file of its own is calibrated. None
        is `calibrated` where the biases have codes, and `default` for fixed gate voltages, which have none.
    calibrated_c : float
        Temperature at which the chips were calibrated, degC.
    coded_on : Die or None
        Die whose calibration the codes are of; the run's own unless given.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = ()

    codes: str | None = option(
        None, "Of the die's own calibration, of the design, or of files; its own where biases have codes",
        metavar="calibrated|default|FILE,...", silicon=True, study=True,
    )  # fmt: skip
    calibrated_c: float = option(
        ROOM_TEMPERATURE, "Where the chips were calibrated", name="calibrated_at", unit="degC", silicon=True,
        study=True, key="calibrated_at_C",
    )  # fmt: skip

    coded_on: Die | None = option(
        None, "Take the codes of this die's calibration, a number or a file of one; its own unless given",
        read=_read_coded_on, name="codes_of", metavar="NUMBER|FILE", silicon=True, key="",
    )  # fmt: skip

    @property
    def code_choice(self) -> str:
        """What `codes` comes to: `calibrated`, `default`, or files."""
        usual = DEFAULT if self.bias_kind == "gate" else CALIBRATED
        return usual if self.codes is None else self.codes

    @property
    def modelled(self) -> bool:
        """Whether its chips are models, which hold at some temperatures alone, and none is transistors."""
        return True

    def codes_of(
        self, name: str, process: Process = AMI_1500, area: float = 1.0, setup: Hashable = None
    ) -> Codes | None:
        """Return the codes of a chip; None for those of its design.

        Parameters
        ----------
        name
            Name of its calibration.
        process
            The process with all its second-order effects.
        area
            Area of its devices over the circuit's, a ratio, for a chip whose silicon is drawn that large.
        setup
            What the chip is set up for; as its calibration states unless given.

        Raises
        ------
        ParameterError
            The chip could not be calibrated, or its model does not hold where the run begins, which is asked
            before; a file's codes are of another silicon, or the area is none.
        DataError
            A file is none of codes.
        """
        if self.code_choice == DEFAULT:
            return None
        require_area(name.replace("-", "_"), area, 0.0)
        if self.outside == "refuse" and self.modelled:
            load_calibration(name).require_temperature(self.silicon_at(self.beginning_c, process))
        silicon = self.silicon_at(self.calibrated_c, process)
        if self.coded_on is not None:
            silicon = replace(silicon, die=self.coded_on)
        silicon = silicon if area == 1.0 else silicon.of_area(area)
        files = _files(self.code_choice)
        if name not in files:
            return codes_on(name, silicon, self.bias_kind, setup)
        files[name].check(name, silicon, self.bias_kind, setup_of(name, setup))
        return files[name]


def check_codes(scenario: Coded) -> None:
    """Raise `ParameterError` for codes that its chips cannot have, `DataError` for a file that is none."""
    choice = scenario.code_choice
    if choice == DEFAULT:
        return
    if scenario.bias_kind == "gate":
        raise ParameterError(
            f"codes: {choice}, fixed gate voltages have no codes; take another bias_kind, or leave it out"
        )
    for name in _files(choice):
        if name not in scenario.CALIBRATED:
            known = ", ".join(scenario.CALIBRATED) or "none"
            raise ParameterError(f"codes: of {name}, must be of a chip in this run: {known}")


@lru_cache(maxsize=16)
def _files(choice: str) -> Mapping[str, Codes]:
    """Codes of files by the name of their chip."""
    if choice == CALIBRATED:
        return {}
    paths = [Path(text) for text in choice.split(",")]
    for path in paths:
        if not path.exists():
            raise ParameterError(
                f"codes: {path}, must be calibrated, default, or a file that calibrate wrote"
            )
    found = [read_codes(path) for path in paths]
    names = [codes.chip for codes in found]
    if len({*names}) < len(names):
        raise ParameterError(f"codes: {choice}, must be one file a chip")
    return dict(zip(names, found, strict=True))


def described(scenario: Coded) -> dict[str, str | float]:
    """Say in a run's account which codes its chips had."""
    if scenario.code_choice == DEFAULT:
        return {"codes": DEFAULT}
    of = "" if scenario.coded_on is None else f", of {scenario.coded_on}"
    return {"codes": f"{scenario.code_choice}{of}", "calibrated_at_C": scenario.calibrated_c}
