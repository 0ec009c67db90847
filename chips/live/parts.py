"""Chips that are parts of a loop (`chips.part`), driven live: the ranging and the wavefront chip."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from chips.codes import Codes
from chips.live.chip import Addresses, Train, moments, within
from chips.noise import SiliconNoise
from chips.part import Part
from chips.ranging.chip import RangingChip
from chips.wavefront.chip import ChipCells, Place, WavefrontChip
from chips.wavefront.part import WavefrontPart
from circuits.arrays import F64, I64, Bools
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon

_INDEX = re.compile(r"\[(\d+)\]")
UNIT = "unit"  # of the wavefront chip's delays, as the name of what is written


@dataclass(frozen=True)
class PartEngine:
    """A part of a loop as a live chip.

    part : the chip; ports : of the events that it takes, by address; outputs : of those that it sends.
    values : of its biases by name, A or V (s for `unit`).
    rebiased : makes the part, and carries a state, for other values.
    counted : counts of a state by name; driven : lines that can be driven.
    warmed : makes the part, and carries a state, at a temperature, degC.
    """

    part: Part[Any]
    inputs: tuple[Addresses, ...]
    outputs: tuple[Addresses, ...]
    values: Mapping[str, float]
    rebiased: Callable[[Part[Any], Any, Mapping[str, float]], tuple[Part[Any], Any]]
    warmed: Callable[[Part[Any], Any, float], tuple[Part[Any], Any]]
    counted: Callable[[Any], Mapping[str, int]]
    driven: tuple[str, ...] = ()

    @property
    def lines(self) -> Mapping[str, int]:
        """A number for each line."""
        return dict.fromkeys(self.driven, 1)

    def takes(self, addresses: I64) -> Bools:
        """Return whether it takes events of these addresses."""
        return within(self.inputs, addresses)

    def begin(self) -> Any:
        """Return the state at rest."""
        return self.part.begin(0.0)

    def go_on(self, state: Any, now: float, until: float, train: Train) -> tuple[Any, Train]:
        """Go on to `until`, s, through the events of a train."""
        events = [(self._port(int(a)), t) for t, a in zip(*(x.tolist() for x in train), strict=True)]
        state, sent = moments(self.part, state, until, events)
        times = np.array([time for _, time in sent])
        return state, (times, np.array([_index(port) for port, _ in sent], dtype=np.int64))

    def counts(self, state: Any) -> Mapping[str, int]:
        """Return what was lost or merged so far, by name."""
        return self.counted(state)

    def biases(self) -> Mapping[str, float]:
        """Return the biases by name, A or V."""
        return self.values

    def with_bias(self, state: Any, name: str, value: float) -> tuple[PartEngine, Any]:
        """Return the chip with another value of a bias, and the state as it goes on."""
        values = {**self.values, name: value}
        part, after = self.rebiased(self.part, state, values)
        return replace(self, part=part, values=values), after

    def at(self, state: Any, temperature_c: float) -> tuple[PartEngine, Any]:
        """Return the chip at another temperature, degC, and the state as it goes on."""
        part, after = self.warmed(self.part, state, temperature_c)
        return replace(self, part=part), after

    def drive(self, state: Any, line: str, values: F64) -> Any:
        """Hold a line at a value from now on."""
        held = np.array([state.time, state.time + 1.0]), np.repeat(values, 2)
        return self.part.advance(state, state.time, (), {line: held})[0]

    def show(self, state: Any) -> Mapping[str, F64]:
        """It shows nothing but its events."""
        return {}

    def _port(self, address: int) -> str:
        kind = next(one for one in self.inputs if one.first <= address < one.first + one.count)
        return kind.name if kind.count == 1 else f"{kind.name}[{address - kind.first}]"


def open_ranging(
    silicon: Silicon | None, bias_kind: BiasKind = "generator", *, noise: SiliconNoise | None = None,
    codes: Codes | None = None,
) -> PartEngine:  # fmt: skip
    """Return a ranging chip: calls and echoes go in, spikes of its neurons come out.

    codes : of its calibration; those of the design unless given.
    """
    chip = RangingChip(silicon or Silicon(), noise=noise, bias_kind=bias_kind, codes=codes)
    values = {
        bias.name: float(np.ravel(bias.value)[0])
        for bias in chip.model.circuit.biases if np.size(bias.value) == 1
    }  # fmt: skip
    return PartEngine(
        chip, (Addresses("call", 0, 1), Addresses("echo", 1, 1)),
        (Addresses("neuron", 0, len(chip.spikes)),), values, _ranging_rebiased, _ranging_warmed,
        _ranging_counts, ("v_ex_max",),
    )  # fmt: skip


def _ranging_counts(state: Any) -> dict[str, int]:
    return {"merged": state.merged, "undecided": state.undecided}


def _ranging_rebiased(part: Any, state: Any, values: Mapping[str, float]) -> tuple[Any, Any]:
    """The chip with other biases; what is left of inhibitions is left at the new rate."""
    other = part.rebiased(values)
    return other, other.carried(state, part)


def _ranging_warmed(part: Any, state: Any, temperature_c: float) -> tuple[Any, Any]:
    return part, part.moved(state, temperature_c)


def open_wavefront(
    silicon: Silicon | None, bias_kind: BiasKind = "generator", *, costs: F64, goal: Place | None = None,
    noise: SiliconNoise | None = None,
) -> PartEngine:  # fmt: skip
    """Return a wavefront chip with a map: starts go in, the wave's spikes come out.

    costs : int64[rows, columns], 0 to 31; goal : at which waves end, none unless given.
    """
    shape = np.shape(costs)
    if len(shape) != 2:
        raise ParameterError(f"wavefront_chip.costs: of shape {shape}, must have rows and columns")
    cells = ChipCells(silicon or Silicon(), bias_kind, noise=noise)
    chip = WavefrontChip(*shape, cells=cells)
    part = WavefrontPart(chip, chip.program(np.asarray(costs)), goal)
    count = math.prod(shape)
    return PartEngine(
        part, (Addresses("start", 0, count),), (Addresses("fired", 0, count),), {UNIT: chip.unit},
        _wave_rebiased, _wave_warmed, _wave_counts,
    )  # fmt: skip


def _wave_counts(state: Any) -> dict[str, int]:
    return {"lost_out": state.dropped, "waves": state.waves}


def _wave_rebiased(part: Any, state: Any, values: Mapping[str, float]) -> tuple[Any, Any]:
    """The chip with another unit of its delays, s; a wave that runs goes on as it began."""
    chip: WavefrontChip = part.chip
    other = WavefrontChip(*chip.shape, cells=chip.cells, unit=values[UNIT], bus=chip.bus)
    return WavefrontPart(other, part.program, part.goal, part.temperature, part.path), state


def _wave_warmed(part: Any, state: Any, temperature_c: float) -> tuple[Any, Any]:
    """The chip at another temperature, degC, for the waves to come."""
    return WavefrontPart(part.chip, part.program, part.goal, temperature_c, part.path), state


def _index(port: str) -> int:
    found = _INDEX.search(port)
    return 0 if found is None else int(found[1])
