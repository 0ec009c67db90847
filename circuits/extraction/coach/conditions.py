"""What was set at each measurement of the teaching chip, as a typed table.

The table is TOML: a `[[measurement]]` for each file, with the biases' types, masters and fine codes. That
of the package was transcribed once from the free text of `conditions.csv`, by which a test checks it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from circuits.errors import DataError, meant
from circuits.silicon.toml_file import read_toml
from circuits.units import parse_quantity

DATA = Path(__file__).parent / "data"
"""Folder of the package's own measurements."""
CIRCUITS = (
    "nfet", "pfet", "converter", "differential-pair", "bump-antibump", "transamp-n", "transamp-n-copies",
    "transamp-p", "wide-range-transamp", "follower-integrator", "ring-converters", "ring-inputs",
    "winner-take-all-ring", "dpi-synapse", "axon-hillock", "adaptive-neuron",
)  # fmt: skip
"""Circuits that a condition may name."""
MASTERS = ("60 pA", "460 pA", "3.8 nA", "30 nA", "240 nA")
CODES = 256
V_DD = 1.8  # V, the chip's supply, between which and ground all is set
_OWN = ("file", "split", "circuit", "points", "voltages", "biases")


@dataclass(frozen=True, slots=True)
class BiasSetting:
    """A line of the bias generator.

    name: its name on the chip. type: `N` or `P`, the rail on which its output device hangs. master: its
    master current, one of `MASTERS`. fine: its fine code, 0 to 255; None where it was swept.
    """

    name: str
    type: Literal["N", "P"]
    master: str
    fine: int | None

    @property
    def master_current(self) -> float:
        """The master current, A."""
        return parse_quantity(self.master.replace(" ", ""), "A", f"{self.name}.master")


@dataclass(frozen=True, slots=True)
class Condition:
    """What was set at one measurement.

    Attributes
    ----------
    file : str
        The file, `fit/NAME.csv` or `predict/NAME.csv`.
    split : str
        `fit` or `predict`.
    circuit : str
        What was measured, one of `CIRCUITS`.
    points : int
        Rows of the file.
    voltages : mapping of str to float
        Voltages that were held, V.
    biases : tuple
        Lines of the bias generator.
    settings : mapping
        All else: ranges, channels, times in s, currents in A.
    """

    file: str
    split: str
    circuit: str
    points: int
    voltages: Mapping[str, float] = field(default_factory=dict)
    biases: tuple[BiasSetting, ...] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The file's name without its folder and suffix."""
        return Path(self.file).stem

    def bias(self, name: str) -> BiasSetting:
        """A line of the bias generator by its name; raises `DataError` where the condition has none such."""
        for each in self.biases:
            if each.name == name:
                return each
        raise DataError(f"{self.file}: no bias {name}, must be stated in its condition; add it")


def read_conditions(path: Path | None = None) -> dict[str, Condition]:
    """Read what was set, by the file's name without folder and suffix.

    Parameters
    ----------
    path
        The table; the package's own unless given.

    Raises
    ------
    DataError
        The file cannot be read, or a measurement names no circuit, no master or no code.
    """
    path = path or DATA / "conditions.toml"
    given = read_toml(path, "a table of conditions")
    found = [_condition(path, k, entry) for k, entry in enumerate(given.get("measurement", []), 1)]
    if not found:
        raise DataError(f"{path}: no [[measurement]], must have at least one; add what was set")
    return {each.name: each for each in found}


def _condition(path: Path, number: int, entry: Mapping[str, Any]) -> Condition:
    where = f"{path}: measurement {number}"
    for name in _OWN[:4]:
        if name not in entry:
            raise DataError(f"{where}: lacks {name}; state it")
    where = f"{path}: {entry['file']}"
    if entry["circuit"] not in CIRCUITS:
        raise DataError(
            f"{where}: circuit {entry['circuit']}, must be one of {', '.join(CIRCUITS)}"
            f"{meant(str(entry['circuit']), CIRCUITS)}"
        )
    biases = tuple(_bias(where, each) for each in entry.get("biases", []))
    settings = {name: value for name, value in entry.items() if name not in _OWN}
    voltages = {name: float(value) for name, value in entry.get("voltages", {}).items()}
    for name, value in voltages.items():
        check_set(f"{where}: voltages.{name}", "V", value)
    return Condition(
        entry["file"], entry["split"], entry["circuit"], int(entry["points"]), voltages, biases, settings
    )


def check_set(where: str, unit: str, value: float) -> None:
    """Raise `DataError` for a voltage, `V`, that leaves the supply, or a fine code, `code`, that is none."""
    if unit == "V" and not 0.0 <= value <= V_DD:
        raise DataError(f"{where}: {value:g} V, must be within 0 V and the supply of {V_DD:g} V; correct it")
    if unit == "code" and not (0.0 <= value < CODES and value.is_integer()):
        raise DataError(f"{where}: {value:g}, must be a whole number from 0 to {CODES - 1}; correct it")


def _bias(where: str, given: Mapping[str, Any]) -> BiasSetting:
    name, kind, master, fine = (given.get(key) for key in ("name", "type", "master", "fine"))
    if kind not in ("N", "P"):
        raise DataError(f"{where}: {name}.type: {kind}, must be N or P")
    if master not in MASTERS:
        raise DataError(f"{where}: {name}.master: {master}, must be one of {', '.join(MASTERS)}")
    if fine == "swept":
        return BiasSetting(str(name), kind, master, None)
    if not isinstance(fine, int) or not 0 <= fine < CODES:
        raise DataError(f"{where}: {name}.fine: {fine}, must be a whole number from 0 to {CODES - 1}")
    return BiasSetting(str(name), kind, master, fine)
