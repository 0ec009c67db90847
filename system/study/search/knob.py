"""Biases and sizes that a search may move, and how they are written as options of the command line.

At u in [-1, 1] a current or a size is its start times reach^u, a voltage its start plus span u; to four
digits, or to 1 mV, so that what was measured can be written down. An array moves as one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from circuits.errors import ParameterError, unknown_name
from circuits.units import format_quantity
from system.options.block import Choice, Value, bias_unit, parameters
from system.study.target import Subject

_LENGTHS = {"m", "mm", "um", "nm"}


@dataclass(frozen=True, slots=True)
class Knob:
    """Bias or size that a search moves.

    Attributes
    ----------
    option : option of the command line that sets it, `bias` or `param`.
    name : name of the bias or size.
    unit : unit of the value; a bias in V is moved by a difference, anything else by a factor.
    value : value at the start, in `unit`; an array has several, which move as one.
    """

    option: str
    name: str
    unit: str
    value: Value

    def at(self, u: float, reach: float, span: float) -> Value:
        """Give the value at the coordinate u, from -1 to 1.

        reach: factor by which currents and sizes move each way; span: voltage by which voltages move each
        way, V.
        """
        if isinstance(self.value, tuple):
            return tuple(_moved(v, u, self.unit, reach, span) for v in self.value)
        return _moved(self.value, u, self.unit, reach, span)

    def text(self, value: Value) -> str:
        """Write a value as the option takes it, as `i_lim=6.3uA`."""
        values = value if isinstance(value, tuple) else (value,)
        return f"{self.name}={','.join(format_quantity(v, self.unit) for v in values)}"

    def change(self, value: Value) -> float:
        """Give the change from the start to a value: a difference of voltages, V, or else a ratio.

        Of an array it is the change of the first element.
        """
        old, new = float(np.ravel(self.value)[0]), float(np.ravel(value)[0])
        return new - old if self.unit == "V" else new / old

    def change_text(self, value: Value) -> str:
        """Write the change from the start to a value as `x 1.250` or `+25 mV`."""
        change = self.change(value)
        return f"{1e3 * change:+.0f} mV" if self.unit == "V" else f"x {change:.3f}"


def knobs_of(choice: Choice, moves: Sequence[str], move_params: Sequence[str]) -> tuple[Knob, ...]:
    """Give the knobs for the biases `moves` and for the sizes `move_params` of a block.

    Where no bias is named, every current is moved. Raises `UnknownNameError` for a name that the block does
    not have, and `ParameterError` for a size that is not a number above 0.
    """
    known = {b.name: b for b in choice.circuit.biases}
    wanted = [n.replace("-", "_") for n in moves] or [n for n, b in known.items() if b.kind != "voltage"]
    for name in wanted:
        if name not in known:
            raise unknown_name("bias", name, known)
    biases = [Knob("bias", n, bias_unit(known[n]), _plain(known[n].value)) for n in dict.fromkeys(wanted)]
    return (*biases, *sizes_of(choice, move_params))


def sizes_of(choice: Choice, move_params: Sequence[str]) -> list[Knob]:
    """Give the knobs for the sizes `move_params` of a block; raises as `knobs_of`."""
    sizes = {p.name: p for p in parameters(choice.params)}
    names = list(dict.fromkeys(n.replace("-", "_") for n in move_params))
    for name in names:
        if name not in sizes:
            raise unknown_name("parameter", name, sizes)
        value = sizes[name].value
        if not (isinstance(value, float) and value > 0.0):
            raise ParameterError(f"move_param: {name} is {value}, must be a number above 0; leave it out")
    return [Knob("param", n, sizes[n].unit, sizes[n].value) for n in names]


def lengths_of(choice: Choice) -> list[str]:
    """Give the names of a block's sizes that are lengths; resistances and capacitances are none."""
    return [p.name for p in parameters(choice.params) if p.unit in _LENGTHS]


def moved_subject(subject: Subject, knobs: Sequence[Knob], values: Sequence[Value]) -> Subject:
    """Give the subject with the values of its knobs that differ from the start.

    They take the place of the subject's own options of the same names.
    """
    new = [(k, v) for k, v in zip(knobs, values, strict=True) if v != k.value]
    return replace(
        subject,
        biases=_with(subject.biases, [(k, v) for k, v in new if k.option == "bias"]),
        params=_with(subject.params, [(k, v) for k, v in new if k.option == "param"]),
    )


def options_of(subject: Subject) -> list[tuple[str, str]]:
    """Give the biases and sizes of a subject as pairs of the name of an option and its text."""
    named = [] if subject.bias_set is None else [("bias_set", subject.bias_set)]
    return [
        *named, *(("param", text) for text in subject.params), *(("bias", text) for text in subject.biases)
    ]  # fmt: skip


def _with(texts: Sequence[str], new: Sequence[tuple[Knob, Value]]) -> tuple[str, ...]:
    names = [knob.name for knob, _ in new]
    others = (t for t in texts if _name(t) not in names)
    return (*others, *(knob.text(value) for knob, value in new))


def _name(text: str) -> str:
    """Name in `NAME=VALUE` or `NAME[k]=VALUE`."""
    return text.partition("=")[0].partition("[")[0].strip().replace("-", "_")


def _plain(value: Any) -> Value:
    array = np.asarray(value, dtype=np.float64)
    return tuple(array.ravel().tolist()) if array.ndim else float(array)


def _moved(value: float, u: float, unit: str, reach: float, span: float) -> float:
    if u == 0.0:
        return value
    return round(value + span * u, 3) if unit == "V" else float(f"{value * reach**u:.4g}")
