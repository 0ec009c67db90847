"""What a sweep on the command line goes over: `NAME=FROM..TO:COUNT`, with `log` behind it, or `NAME=A,B,...`.

A name is looked for among the sources of the block's testbench, its biases, sizes and stimuli, and is one of
`temperature`, `die` and `corner`. One that is there twice has what it is before it, as `stimulus:call`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from circuits.errors import ParameterError, unknown_name
from circuits.lowering.kernel import to_kernel
from circuits.sweep.axis import MOST, SILICON
from circuits.testbench import Testbench
from circuits.units import parse_quantity
from system.options.assignment import split_assignment
from system.options.block import Choice, bias_unit, parameters

_RANGE = re.compile(r"(?P<first>\S+?)\.\.(?P<last>\S+?)(?::(?P<count>\d+)(?P<log>log)?)?")
_HELP = "write as 0V..1.8V:181, 1pA..1uA:61log, 1000..1019 or 1V,2V"
KINDS = ("source", "bias", "param", "stimulus", "silicon")

Options = Mapping[str, tuple[str, ...]]  # texts NAME=VALUE of `bias`, `param` and `stimulus`
Chosen = Callable[[Options], Choice]  # the block with these options over its own


@dataclass(frozen=True, slots=True)
class Swept:
    """A name that is swept: its kind, its name without it, unit, and values."""

    kind: str
    name: str
    unit: str
    values: tuple[Any, ...]


def read_swept(choice: Choice, texts: Iterable[str]) -> tuple[Swept, ...]:
    """Read what is swept; raises `ParameterError` and `UnknownNameError` naming what is wrong."""
    known = _known(choice)
    found: list[Swept] = []
    for text in texts:
        name, values = split_assignment(text, "over", keep=True)
        kind, name, unit = _named(name, known)
        if name in {each.name for each in found}:
            raise ParameterError(f"over: {name}, is there twice, must be once")
        found.append(Swept(kind, name, unit, read_values(values, unit, name)))
    return tuple(found)


def build_of(chosen: Chosen, swept: Sequence[Swept]) -> tuple[Callable[..., Testbench], dict[str, str]]:
    """Give what makes the testbench of values of its options, and the unit of each option that is swept."""
    options = {each.name: each for each in swept if each.kind not in {"source", "silicon"}}

    def build(**values: float) -> Testbench:
        texts: dict[str, tuple[str, ...]] = {}
        for name, value in values.items():
            each = options[name]
            texts[each.kind] = (*texts.get(each.kind, ()), f"{name}={_exact(value, each.unit)}")
        return chosen(texts).testbench()

    return build, {name: each.unit for name, each in options.items()}


def read_values(text: str, unit: str, name: str) -> tuple[Any, ...]:
    """Read values of a sweep, in `unit`; those of a corner are words.

    Raises `ParameterError` for a text of another form.
    """
    if name == "corner":
        return tuple(part.strip() for part in text.split(","))
    match = _RANGE.fullmatch(text)
    if match is None:
        if ".." in text or ":" in text:
            raise ParameterError(f'{name}: "{text}", must be FROM..TO:COUNT; {_HELP}')
        return tuple(_number(part, unit, name) for part in text.split(","))
    first, last = (_number(match[end], unit, name) for end in ("first", "last"))
    if match["count"] is None:
        return _whole(text, first, last, unit, name)
    count = int(match["count"])
    if not 2 <= count <= MOST:
        raise ParameterError(f'{name}: "{text}", {count} values, must be 2 to {MOST}; {_HELP}')
    if match["log"]:
        if not first * last > 0.0:
            raise ParameterError(f'{name}: "{text}", a log range must not reach 0; {_HELP}')
        return tuple(np.geomspace(first, last, count).tolist())
    return tuple(np.linspace(first, last, count).tolist())


def _whole(text: str, first: float, last: float, unit: str, name: str) -> tuple[Any, ...]:
    """Every whole number of a range without a count, as of dies."""
    if unit or first != int(first) or last != int(last) or not first <= last < first + MOST:
        raise ParameterError(f'{name}: "{text}", must say how many values; {_HELP}')
    return tuple(range(int(first), int(last) + 1))


def _number(text: str, unit: str, name: str) -> float | int:
    value = parse_quantity(text, unit, name)
    return int(value) if name == "die" and value == int(value) else value


def _known(choice: Choice) -> dict[str, dict[str, str]]:
    """Units of all that can be swept, by kind and name."""
    machine = to_kernel(choice.testbench(), choice.silicon)
    quantities = zip(machine.source_names, machine.source_quantities, strict=True)
    return {
        "source": {name: "V" if kind == "voltage" else "A" for name, kind in quantities},
        # a voltage is the same as the source at its port
        "bias": {b.name: bias_unit(b) for b in choice.circuit.biases if b.name not in machine.source_names},
        "param": {p.name: p.unit for p in parameters(choice.params)},
        "stimulus": {s.name: s.unit for s in choice.block.stimuli},
        "silicon": {name: unit for name, (_, unit) in SILICON.items()},
    }


def _named(given: str, known: Mapping[str, Mapping[str, str]]) -> tuple[str, str, str]:
    """Kind, name and unit of what is called so."""
    prefix, sign, rest = given.partition(":")
    kinds, name = ((prefix,), rest) if sign else (KINDS, given)
    if sign and prefix not in KINDS:
        raise unknown_name("over: kind", prefix, KINDS)
    for each in (name, name.replace("-", "_")):
        found = [(kind, each, known[kind][each]) for kind in kinds if each in known[kind]]
        if len(found) > 1:
            both = " or ".join(f"{kind}:{each}" for kind, _, _ in found)
            raise ParameterError(f"over: {name}, there are several of that name, must be one; write {both}")
        if found:
            return found[0]
    raise unknown_name("over: name", name, [each for kind in kinds for each in known[kind]])


def _exact(value: float, unit: str) -> str:
    """A value as a text that is read back to the same number, or to its last digit."""
    return f"{1e15 * float(value)!r}fF" if unit == "F" else f"{float(value)!r}{unit}"
