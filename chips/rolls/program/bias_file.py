"""Bias files of ROLLS: a name, a coarse current and a fine code a row, `I = I_coarse fine / 256`.

    name,coarse_A,fine_0_255
    IF_TAU1_N,15p,40
    SSP,SPECIAL,7

The header may be missing. Fields behind the third are flags, as in the control software's own files
(`IF_TAU1_N,15p,40,LowBias,Normal,NBias,BiasEnable,`); they are kept and written. Coarse currents are 24u,
3.2u, 0.4u, 50n, 6.5n, 820p, 105p and 15p, codes 0 to 7; the two shifted sources have SPECIAL instead. Names
that the chip does not have are kept, and `BiasTable.unknown` tells them.

Shipped in `chips/biases/`, both found: `rolls_default`, the defaults of mn256r1_ncs, and `rolls_parallella`,
`default.json` of the Parallella server in NCSRobotLib, the set-up of Milde et al. 2017. Their own table
(Appendix A) is not public. Every other bias file with these names is read alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

from circuits.blocks.rolls.bias import Code, current_of
from circuits.errors import DataError, ParameterError, unknown_name
from circuits.generator.code import CODES

COARSE_NAMES = ("24u", "3.2u", "0.4u", "50n", "6.5n", "820p", "105p", "15p")  # of codes 0 to 7
SPECIAL = "SPECIAL"
HEADER = "name,coarse_A,fine_0_255"
SHIPPED = ("rolls_default", "rolls_parallella")
DIRECT_CURRENT = "IF_DC_P"  # of every neuron, without input
OFF = (7, 0)  # coarse and fine code of a current that is off
_FIELDS = 3
_DIGITS = 10  # of a fine code, beyond which its size is not looked at; ours


@dataclass(frozen=True, slots=True)
class BiasEntry:
    """A row of a bias file.

    name: that of the bias. coarse: its coarse code, 0 to 7; None for a shifted source. fine: its fine code, 0
    to 255. flags: its flags, as the file has them.

    Raises `ParameterError` where a code is outside its range.
    """

    name: str
    coarse: int | None
    fine: int
    flags: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.coarse is not None and not 0 <= self.coarse < len(COARSE_NAMES):
            raise ParameterError(
                f"bias.{self.name}.coarse: {self.coarse}, must be 0 to {len(COARSE_NAMES) - 1};"
                f" they are {', '.join(COARSE_NAMES)}"
            )
        if not 0 <= self.fine < CODES:
            raise ParameterError(
                f"bias.{self.name}.fine: {self.fine}, must be 0 to {CODES - 1}; take another coarse current"
            )


@dataclass(frozen=True, slots=True)
class BiasTable:
    """Biases of a chip.

    entries: in the order of their file. Raises `ParameterError` for a name that is given twice.
    """

    entries: tuple[BiasEntry, ...]

    def __post_init__(self) -> None:
        names = self.names
        if len(set(names)) < len(names):
            twice = next(n for k, n in enumerate(names) if n in names[:k])
            raise ParameterError(f"bias.{twice}: given twice, must be one row a name; remove one")

    @property
    def names(self) -> tuple[str, ...]:
        """Names in order."""
        return tuple(entry.name for entry in self.entries)

    @property
    def unknown(self) -> tuple[str, ...]:
        """Names that the chip does not have."""
        known = set(default_biases().names)
        return tuple(name for name in self.names if name not in known)

    def code(self, name: str) -> Code:
        """Return (coarse, fine) of the bias `name`.

        Raises `UnknownNameError` for another name, and `ParameterError` for a shifted source.
        """
        entry = self._entry(name)
        if entry.coarse is None:
            raise ParameterError(
                f"bias.{name}: a shifted source, must be a bias with a coarse current; choose another"
            )
        return entry.coarse, entry.fine

    def current(self, name: str) -> float:
        """Return the nominal current of the bias `name` at 27 degC, A.

        It is `I_coarse fine / 256`, and `OFF_CURRENT` at code 0.
        """
        return current_of(self.code(name))

    def is_off(self, name: str) -> bool:
        """Return whether the fine code of the bias `name` is 0."""
        return self.code(name)[1] == 0

    def codes(self) -> Mapping[str, Code]:
        """Return (coarse, fine) by name, without the shifted sources."""
        return {e.name: (e.coarse, e.fine) for e in self.entries if e.coarse is not None}

    def with_code(self, name: str, coarse: int, fine: int) -> BiasTable:
        """Return the table with another code of `name`.

        Raises `UnknownNameError` for a name that it does not have, and `ParameterError` for a code outside
        the range.

        Parameters
        ----------
        name
            Name of the bias.
        coarse
            Coarse code, 0 to 7.
        fine
            Fine code, 0 to 255.
        """
        changed = replace(self._entry(name), coarse=coarse, fine=fine)
        return BiasTable(tuple(changed if e.name == name else e for e in self.entries))

    def _entry(self, name: str) -> BiasEntry:
        for entry in self.entries:
            if entry.name == name:
                return entry
        raise unknown_name("ROLLS bias", name, self.names)


def default_biases() -> BiasTable:
    """Return the defaults of the control software, on which every neuron fires without input.

    `resting_biases` has those on which a chip rests.
    """
    return shipped_biases(SHIPPED[0])


def resting_biases() -> BiasTable:
    """Return the defaults of the control software without the neurons' direct current, so that a chip rests.

    With it (`IF_DC_P` at 3.2u, 7: 88 nA) every neuron fires without input as fast as it can.
    """
    return default_biases().with_code(DIRECT_CURRENT, *OFF)


def shipped_biases(name: str) -> BiasTable:
    """Return the table `name` of `SHIPPED`; raises `UnknownNameError` for another name."""
    if name not in SHIPPED:
        raise unknown_name("ROLLS bias table", name, SHIPPED)
    text = files("chips").joinpath("biases", f"{name}.csv").read_text(encoding="utf-8")
    return parse_biases(text, name)


def read_biases(path: Path) -> BiasTable:
    """Read the bias file at `path`.

    Raises
    ------
    DataError
        The file cannot be read, or a row is none; the text names its line.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "no UTF-8 text"
        raise DataError(f"{path}: {reason}, must be a bias file; give another") from error
    return parse_biases(text, str(path))


def parse_biases(text: str, source: str) -> BiasTable:
    """Return the table of a file's `text`; `source` names it in errors.

    Raises `DataError` with the line.
    """
    entries: dict[str, BiasEntry] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        fields = [field.strip() for field in line.split(",")]
        if not any(fields) or (number == 1 and fields[0] == "name"):
            continue
        entry = _entry_of(fields, f"{source}, line {number}")
        if entry.name in entries:
            raise DataError(f"{source}, line {number}: {entry.name} stands twice, must once; remove one row")
        entries[entry.name] = entry
    if not entries:
        raise DataError(f"{source}: no bias, must have rows as IF_TAU1_N,15p,40; write one a bias")
    return BiasTable(tuple(entries.values()))


def format_biases(table: BiasTable) -> str:
    """Return the text of a bias file with its header, flags behind the codes."""
    rows = [HEADER]
    for entry in table.entries:
        coarse = SPECIAL if entry.coarse is None else COARSE_NAMES[entry.coarse]
        rows.append(",".join((entry.name, coarse, str(entry.fine), *entry.flags)))
    return "\n".join(rows) + "\n"


def write_biases(path: Path, table: BiasTable) -> None:
    """Write the biases of `table` to a file at `path`; raises `DataError` where it cannot be written."""
    try:
        path.write_text(format_biases(table), encoding="utf-8")
    except OSError as error:
        raise DataError(f"{path}: {error.strerror}, must be a file to write; give another") from error


def _entry_of(fields: list[str], where: str) -> BiasEntry:
    if len(fields) < _FIELDS or not fields[0]:
        text = ",".join(fields)
        raise DataError(f'{where}: "{text}", must be name,coarse,fine as in IF_TAU1_N,15p,40; complete it')
    name, coarse, fine = fields[:_FIELDS]
    if coarse not in COARSE_NAMES and coarse != SPECIAL:
        names = ", ".join(COARSE_NAMES)
        raise DataError(f"{where}: coarse current {coarse} of {name}, must be one of {names}; change it")
    if not (fine.isascii() and fine.isdigit() and len(fine) < _DIGITS and int(fine) < CODES):
        raise DataError(f"{where}: fine code {fine} of {name}, must be 0 to {CODES - 1}; change it")
    code = None if coarse == SPECIAL else COARSE_NAMES.index(coarse)
    return BiasEntry(name, code, int(fine), tuple(f for f in fields[_FIELDS:] if f))
