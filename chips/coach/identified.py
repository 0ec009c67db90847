"""What `noctule identify` found of a chip and its board, for the bench: process, generator, and readings.

The file of an identified die has all that was fitted together: numbers of the process, masters and codes of
the bias generator, offsets and scales of DAC and ADC, shunts and ammeters, charge and dead time of each
converter, lines' capacitances. The bench takes those that the measurements fixed; what they left as wide as
it was before is nominal. What belongs to one execution alone is left out: drifts of the converters, times,
phases, offsets that were subtracted.

A converter's charge is found in the scale of the nominal current of its calibration, so on the bench it is
that times what the circuit's transistor truly carries there, over the nominal current. The charge of one that
was not calibrated is nominal by nominal masters, so it goes with the scale of its master.

As in the fit, voltages of the test transistors have no offset of the DAC, and a line is at the gate voltage
of a device of the biased one's size. Masters are proportional to absolute temperature, and as found at the
temperature of the measurements.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

from chips.coach.generator import BITS, IDEAL_BITS, REFERENCE_C, Generator, master_named
from chips.coach.readout import CHANNELS, RANGES, Board, Channel, Range
from chips.coach.wiring import CIRCUITS
from circuits.errors import DataError
from circuits.extraction.coach.bench import BUFFER_HIGH, BUFFER_LOW, process_of
from circuits.extraction.coach.chip import die_of
from circuits.extraction.coach.conditions import MASTERS
from circuits.extraction.coach.posterior import (
    ConverterRow,
    PosteriorTable,
    check_process,
    posterior_of,
    read_table,
)
from circuits.extraction.coach.readings.converter import BITS as FITTED_BITS
from circuits.extraction.coach.unknown import Posterior
from circuits.silicon.process import Process, kelvin
from circuits.silicon.silicon import Silicon

_TRANSISTORS = {"NFET": "n", "PFET": "p"}  # behind ammeters
_RING, _SYNAPSE = "WTA", "DPI"
_RING_LINE = ("WTA_VB_N", "WTA 460 pA")  # name of the line whose bits the ring's converters were read by
_BY_RING = (2, 3, 4, 8, 9, 10, 15)  # channels whose nominal charge is that of a calibration at the ring
_FACTORS = {
    "WTA_VGAIN_P": "ring gain", "DPI_VTHR_N": "dpi threshold", "PEX_VTAU_N": "dpi extender",
    "ACN_VGAIN_N": "acn gain", "ACN_VREFR_N": "acn reset",
}  # fmt: skip
_LINES = {"FOI": "foi line", "DPI": "dpi line", "AHN": "ahn line", "ACN": "acn line"}
_CODE = re.compile(r"\w+ (\w+) (\S+ \S+) code (\d+)")
_SAME = 1e-6  # of a deviation of a device
_NOMINAL = "take a nominal board"  # what to do on other silicon


@dataclass(frozen=True, slots=True, eq=False)
class Identified:
    """What a file says that was found.

    file : the file.
    posterior : what is known after the fit.
    table : the file's own table.
    """

    file: str
    posterior: Posterior
    table: PosteriorTable

    @property
    def temperature_c(self) -> float:
        """Temperature of the measurements, degC."""
        return self.posterior.values()["temperature_c"]


@dataclass(frozen=True, slots=True)
class Found:
    """What of it a circuit's bench takes.

    file : where it was found.
    temperature_c : of the measurements, degC.
    board : what sets and reads; charges of `calibrated` are on the scale of its calibration.
    generator : the bias generator.
    sizes : of the circuit, by name, SI.
    current : that the chip's own sources give into nodes, A.
    calibrated : how the converter of a pin was calibrated, by the pin.
    identified, nominal : names of what the measurements fixed, and of what they left.
    """

    file: str
    temperature_c: float
    board: Board
    generator: Generator
    sizes: Mapping[str, float]
    current: Mapping[str, float]
    calibrated: Mapping[str, ConverterRow]
    identified: tuple[str, ...]
    nominal: tuple[str, ...]


def read_identified(path: Path) -> Identified:
    """Read what was found from the file of an identified die.

    Raises `DataError` for a file that cannot be read, that was not identified, or has no posterior of this
    chip.
    """
    table = read_table(path)
    posterior, _ = posterior_of(table, str(path))
    if "temperature_c" not in posterior.names:
        raise DataError(f"{path}: posterior: no unknown temperature_c, must have one; identify the die again")
    return Identified(str(path), posterior, table)


def identified_silicon(found: Identified, silicon: Silicon) -> Silicon:
    """The silicon with the numbers of the process that were found.

    Parameters
    ----------
    found
        What was found.
    silicon
        The die that was identified, on the process that it was identified on.

    Raises
    ------
    DataError
        The process or the die is another.
    """
    posterior, base = found.posterior, silicon.process
    check_process(posterior, base, found.table.process, found.file, _NOMINAL)
    _check_die(found, silicon)
    return replace(silicon, process=_process(posterior, base))


def _process(posterior: Posterior, base: Process) -> Process:
    """The process of the posterior's means, of the base where it is free, as `extract` gives one."""
    kept = {u.name: u.mean for u in posterior.unknowns if u.name in posterior.free()}
    return process_of({**posterior.values(), **kept}, base)


def _check_die(found: Identified, silicon: Silicon) -> None:
    """Refuse a die without the deviations that were found; it may have others on top."""
    for edit in die_of(found.posterior).edits:
        path, parameter = edit.paths[0], edit.parameter
        values = [e.value for e in silicon.die.edits if path in e.paths and e.parameter == parameter]
        if not any(abs(value - edit.value) <= _SAME * abs(edit.value) for value in values):
            stated = f"deviates by {values[-1]:.6g}" if values else "is as drawn"
            raise DataError(
                f"{found.file}: identified on a die whose {path}.{parameter} deviates by {edit.value:.6g}, on"
                f" this one it {stated}; give the die of that file, or {_NOMINAL}"
            )


@final
class _Reader:
    """Means of what the measurements fixed, which remembers what was asked for."""

    def __init__(self, posterior: Posterior) -> None:
        """Hold a posterior's means; nothing has been asked for."""
        self.means, self.free = posterior.values(), set(posterior.free())
        self.identified: dict[str, None] = {}
        self.nominal: dict[str, None] = {}

    def get(self, name: str) -> float | None:
        """Mean of an unknown; None where the measurements did not fix it."""
        fixed = name in self.means and name not in self.free
        (self.identified if fixed else self.nominal)[name] = None
        return self.means[name] if fixed else None

    def value(self, name: str, nominal: float) -> float:
        """Mean of an unknown, or the nominal one."""
        found = self.get(name)
        return nominal if found is None else found

    def exp(self, name: str, nominal: float) -> float:
        """Of an unknown that is a logarithm."""
        found = self.get(name)
        return nominal if found is None else math.exp(found)


def found_of(found: Identified, circuit: str) -> Found:
    """What the bench of a circuit takes; circuit: its name, as NDP."""
    reader = _Reader(found.posterior)
    for u in found.posterior.unknowns:
        if u.kind == "process":
            reader.get(u.name)
    calibrated = _calibrated(found, circuit)
    board, generator = _board(reader, circuit, calibrated), _generator(reader, circuit, found.temperature_c)
    sizes, into = _sizes(reader, circuit), reader.get("ahn input") if circuit == "AHN" else None
    current = {} if into is None else {"v_mem": math.exp(into)}
    free = set(found.posterior.free())
    calibrated = {p: row for p, row in calibrated.items() if f"channel {row.channel} Q" not in free}
    return Found(
        found.file, found.temperature_c, board, generator, sizes, current, calibrated,
        tuple(reader.identified), tuple(reader.nominal),
    )  # fmt: skip


def _sizes(reader: _Reader, circuit: str) -> dict[str, float]:
    """Capacitance of the line that is read, and widths of what loads the amplifier's copies."""
    if circuit in _LINES:
        line = reader.get(_LINES[circuit])
        return {} if line is None else {"line_capacitance": math.exp(line)}
    wide = reader.get("copies load") if circuit == "NTA" else None
    usual, names = CIRCUITS[circuit].block.sizes, ("readout_n_width", "readout_p_width")
    return {} if wide is None else {name: getattr(usual, name) * math.exp(wide) for name in names}


def _calibrated(found: Identified, circuit: str) -> dict[str, ConverterRow]:
    """How the converters of a circuit were calibrated, by the pin."""
    rows = {f"C2F{row.channel}": row for row in found.table.converter if row.circuit == circuit}
    return {pin: rows[pin] for pin in CIRCUITS[circuit].counted if pin in rows}


def _board(reader: _Reader, circuit: str, calibrated: Mapping[str, ConverterRow]) -> Board:
    if circuit in _TRANSISTORS:
        return Board(ranges=_ranges(reader, _TRANSISTORS[circuit]))
    board = Board(dac_offset=reader.value("dac offset", 0.0), channels=_channels(reader, circuit, calibrated))
    if not CIRCUITS[circuit].outputs:
        return board
    scale = 1.0 - reader.value("adc scale", 0.0)
    behind = reader.value("dpi buffer", 0.0) if circuit == _SYNAPSE else 0.0
    return replace(
        board,
        adc_offset=reader.value("adc offset", 0.0) + behind / scale,
        adc_scale=scale,
        buffer_low=(BUFFER_LOW + behind) / scale,  # the fit's limits are those of what is read
        buffer_high=(BUFFER_HIGH + behind) / scale,
    )


def _ranges(reader: _Reader, polarity: str) -> dict[str, Range]:
    return {
        name: Range(
            reader.exp(f"shunt {name}", span.shunt),
            span.full,
            reader.value(f"fet_{polarity} ammeter {name}", 0.0),
        )
        for name, span in RANGES.items()
    }


def _channels(reader: _Reader, circuit: str, calibrated: Mapping[str, ConverterRow]) -> dict[str, Channel]:
    """Converters of a circuit by the pin."""
    found = {}
    for pin in CIRCUITS[circuit].counted:
        number = int(pin.removeprefix("C2F").partition("_")[0])
        charge, dead = _names(circuit, number)
        usual, own = CHANNELS[number], reader.get(charge) if _known(circuit, pin, calibrated) else None
        if own is None:
            reader.nominal[charge] = None
            master = "s 460 pA" if number in _BY_RING else "s 30 nA"
            found[pin] = replace(usual, charge=usual.charge * reader.exp(master, 1.0))
            continue
        if circuit == _RING and pin.endswith("_ALL"):
            own += reader.value(f"ring mirror {number}", 0.0)
        counts = round(calibrated[pin].counts) if pin in calibrated else usual.counts
        found[pin] = Channel(math.exp(own), reader.value(dead, usual.dead_time), counts)
    return found


def _names(circuit: str, number: int) -> tuple[str, str]:
    """Unknowns of a converter's charge and dead time while it reads a circuit."""
    if circuit == _RING:
        return f"ring channel {number} Q", "ring t_d"
    own = "dpi" if circuit == _SYNAPSE else f"channel {number}"
    return f"{own} Q", f"{own} t_d"


def _known(circuit: str, pin: str, calibrated: Mapping[str, ConverterRow]) -> bool:
    """Whether it is known which current a converter's charge was found at."""
    return circuit in (_RING, _SYNAPSE) or pin in calibrated


def _generator(reader: _Reader, circuit: str, celsius: float) -> Generator:
    names = tuple(CIRCUITS[circuit].lines)
    if not names:
        return Generator(reference="biased")
    cold = kelvin(REFERENCE_C) / kelvin(celsius)
    scale = {}
    for master in MASTERS:
        found = reader.get(f"s {master}")
        if found is not None:
            scale[master_named(master)] = math.exp(found) * cold
    known = {name: _bits(reader, name) for name in names}
    factors = {name: reader.exp(_FACTORS[name], 1.0) for name in names if name in _FACTORS}
    return Generator(
        bits=IDEAL_BITS,
        scale=scale,
        lines={name: bits for name, bits in known.items() if bits is not None},
        factors=factors,
        codes=_codes(reader, names),
        reference="biased",
    )


def _bits(reader: _Reader, name: str) -> tuple[float, ...] | None:
    """What the bits of a line are worth; None of one that was fitted as if they were what they should be."""
    fitted = _RING_LINE[1] if name == _RING_LINE[0] else name
    if f"{fitted} bit 0" not in reader.means:
        return None
    of_all = [reader.value(f"splitter bit {k}", BITS[k]) for k in range(FITTED_BITS)]
    own = [reader.value(f"{fitted} bit {k}", 1.0) for k in range(FITTED_BITS)]
    return (*(a * b for a, b in zip(of_all, own, strict=True)), *BITS[FITTED_BITS:])


def _codes(reader: _Reader, names: tuple[str, ...]) -> dict[tuple[str, float, int], float]:
    """Errors of single codes of lines."""
    found = {}
    for unknown in reader.means:
        told = _CODE.fullmatch(unknown)
        if told is not None and told[1] in names:
            error = reader.get(unknown)
            if error is not None:
                found[told[1], master_named(told[2]), int(told[3])] = math.exp(error)
    return found
