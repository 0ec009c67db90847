"""Text of the command line -> parameters, biases, stimuli and silicon of a block.

`NAME=VALUE` with a prefix and the quantity's own unit, which its field states (`circuits.units.quantity`). A
parameter of a part has a dotted name (`neuron.membrane_capacitance`); an array takes one value for all,
values with commas between, or one element (`i_inh_tau[3]=150pA`).
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import Field, dataclass, fields, is_dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from chips.registry import Chip, chip_names
from circuits.bias import rebias
from circuits.blocks.block import Block, Stimulus
from circuits.catalogue import loaded
from circuits.checks import implausible_allowed
from circuits.circuit import Bias, BiasKind, Circuit, Shape, split_reference
from circuits.errors import ParameterError, TopologyError, unknown_name
from circuits.generator.code import COARSE, CODES, currents_of
from circuits.place import circuit_at, instance_names
from circuits.silicon.course import Course
from circuits.silicon.die import Die, Place
from circuits.silicon.edit import Edit
from circuits.silicon.process_file import process_under
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from circuits.units import parse_quantity
from system.meaning import meanings
from system.options.assignment import split_assignment
from system.options.begin import FREE, BeginChoice
from system.options.begun import begun
from system.options.die.edited import check_edits
from system.options.on_silicon import OnSilicon
from system.options.silicon import SiliconChoice
from system.options.target import Target, file_of, load_target, own_silicon, split_place

ROLLS = "rolls"  # the chip that is no circuit with a testbench

_CODE = re.compile(r"([0-9]):([0-9]{1,3})")  # coarse and fine
_ELEMENT = re.compile(r"(.*)\[([0-9]{1,9}(?:,[0-9]{1,9})*)\]")
_NOMINAL = SiliconChoice()

Value = float | tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Parameter:
    """A settable number of a block: dotted name, value in `unit`."""

    name: str
    value: Any
    unit: str


@dataclass(frozen=True, slots=True)
class Choice:
    """What a user chose: a block with its parameters and biases, on silicon, under stimuli."""

    block: Block
    params: Any
    circuit: Circuit
    silicon: Silicon
    stimuli: Mapping[str, float | None]
    begin: BeginChoice = FREE
    allow_implausible: bool = False

    def testbench(self) -> Testbench:
        """The block's testbench under the stimuli; raises `ParameterError` unless it takes time."""
        with implausible_allowed(self.allow_implausible):
            bench = self.block.testbench(self.circuit, self.stimuli, self.silicon.process.v_dd)
        if not bench.stop > 0.0:
            raise ParameterError(f"duration: {bench.stop:g} s, must be > 0; give a longer run")
        return begun(bench, self.begin)


def choose(
    target: Target,
    params: Iterable[str] = (),
    biases: Iterable[str] = (),
    bias_kind: BiasKind | None = None,
    silicon: SiliconChoice = _NOMINAL,
    stimuli: Iterable[str] = (),
    bias_set: str | None = None,
    begin: BeginChoice = FREE,
) -> Choice:
    """Read the options that all commands on a block or chip share.

    target: its name, file or object (`system.options.target`), of which a netlist's own silicon holds where
    none but the usual is asked for; params, biases, stimuli: texts `NAME=VALUE`; bias_set: name of
    one of the block's sets, over which `biases` go; begin: where its runs begin. A block at its place on a
    chip has the sizes and biases that the chip gives it, unless `params`, `bias_set` or `biases` say
    otherwise. Biases of a chip, and of a block on one, come from its generator where no kind is asked for;
    those of a lone block are of their own kind. Raises `ParameterError` or `UnknownNameError` naming what is
    wrong.
    """
    params = list(params)
    with implausible_allowed(silicon.allow_implausible):
        block = block_of_target(target)
    if bias_kind is None and (silicon.at is not None or target in chip_names()):
        bias_kind = "generator"
    values = read_params(block.sizes, params)
    block = block.sized(values)
    with implausible_allowed(silicon.allow_implausible):
        circuit, place = block.build(values), None
        if silicon.at is not None:
            there, place = _circuit_at(silicon.at, circuit)
            circuit = replace(circuit, biases=there.biases) if params else there
        if bias_set is not None:
            circuit = rebias(circuit, read_bias_set(block, bias_set))
        circuit = rebias(circuit, read_biases(circuit, biases, bias_kind), bias_kind)
    with implausible_allowed(silicon.allow_implausible):
        made = replace(_silicon_of(target, block, silicon), place=place)
    check_edits(made.die, [(circuit, made)])
    read = read_stimuli(block.stimuli, stimuli)
    return Choice(block, values, circuit, made, read, begin, silicon.allow_implausible)


def _silicon_of(target: Target, block: Block, asked: SiliconChoice) -> Silicon:
    """The silicon that is asked for; what is left as usual is as a netlist states it."""
    celsius = parse_quantity(asked.celsius, "degC", "temperature")
    made = Silicon(process_under(block.process, asked.process, asked.law), celsius, read_die(asked))
    if file_of(target) and asked.process is None and (block.process.effects, asked.law) == ("ideal", "full"):
        _warn_of_law(target)
    stated_c, noted = own_silicon(target)
    if stated_c is not None and asked.temperature is None:
        made = replace(made, temperature_c=stated_c)
    if noted is None:
        return made
    if (asked.process, asked.law) == (_NOMINAL.process, _NOMINAL.law):
        made = replace(made, process=noted.process)
    usual = replace(_NOMINAL, temperature=asked.temperature, process=asked.process, law=asked.law)
    is_usual = replace(asked, at=None, allow_implausible=False) == usual
    return replace(made, die=noted.die) if is_usual else made


@lru_cache(maxsize=64)
def _warn_of_law(target: str) -> None:
    """Warn, once a process, of a file whose process is stated as ideal and runs under the full law."""
    warnings.warn(
        f"{target}: its process is stated without second-order effects and runs with them; choose law ideal"
        " to run without",
        stacklevel=4,
    )


def block_of_target(target: Target) -> Block:
    """A block, or a chip with a testbench; raises as `load_target`, and `ParameterError` for another chip."""
    found = load_target(target)
    if isinstance(found, Chip):
        raise ParameterError(f"{found.name}: has no testbench as one circuit; {found.remedy}")
    return found


def read_die(silicon: SiliconChoice) -> Die:
    """The die that was asked for, a study's where it is one of a plan."""
    asked = silicon.only, silicon.heal, silicon.deviate
    edits: tuple[Edit, ...] = loaded("system.options.die.file:edits_of")(*asked) if any(asked) else ()
    if silicon.study is None:
        return Die(
            silicon.lot, silicon.die, silicon.corner, silicon.mismatch, silicon.process_variation,
            variation=silicon.variation, edits=edits,
        )  # fmt: skip
    studied: Die = silicon.study
    return replace(studied, corner=silicon.corner, edits=(*studied.edits, *edits))


DIE_KEYS = meanings("""
lot                string    -  lot of the die
die                integer?  -  its number; null for the nominal die
corner             string    -  its corner; `random` where the die's own process is drawn
mismatch           boolean   -  whether its devices differ from each other
process_variation  boolean   -  whether its process differs from the nominal one
variation          string    -  components of variation it has beside: `plain` none, `transistors`, or `full`
edits              string[]  -  what was changed of it by hand, in words
""")
SILICON_KEYS = {
    **meanings("""
process        string  -     name of the process
law            string  -     `full` with second-order effects of the process, `ideal` without
temperature_C  number  degC  temperature of the silicon
"""),
    **DIE_KEYS,
    **meanings("at  string?  -  place on a chip, as `ranging-chip/neuron[2]`; null for a block by itself"),
}


def describe_silicon(silicon: Silicon) -> dict[str, Any]:
    """Process, law, temperature, die and place by the names that JSON has for them."""
    place, process = silicon.place, silicon.process
    return {
        "process": process.name,
        "law": process.effects,
        "temperature_C": silicon.temperature_c,
        **describe_die(silicon.die),
        "at": None if place is None else "/".join(_label(*part) for part in place),
    }


def silicon_line(silicon: Silicon) -> str:
    """Silicon in a line: `27 degC, die nominal`, and the process where its law is the ideal one."""
    return f"{silicon.temperature_c:g} degC, {silicon.die}{law_text(silicon)}"


def law_text(silicon: Silicon) -> str:
    """End of a title, `, rolls-180 under the ideal law`; empty under the full law."""
    process = silicon.process
    return "" if process.effects == "full" else f", {process.name} under the ideal law"


def describe_die(die: Die) -> dict[str, Any]:
    """A die by the names that JSON has for its parts."""
    return {
        "lot": die.lot,
        "die": die.number,
        "corner": die.corner,
        "mismatch": die.mismatch,
        "process_variation": die.process,
        "variation": die.variation,
        "edits": [str(edit) for edit in die.edits],
    }


def describe_dies(silicon: SiliconChoice) -> dict[str, Any]:
    """What all dies of a study or a mission have in common: a die's parts but its number and its corner."""
    shared = describe_die(read_die(silicon))
    return {name: part for name, part in shared.items() if name not in {"die", "corner"}}


def describe_run(scenario: OnSilicon) -> dict[str, Any]:
    """Silicon that a system ran on.

    That is the die, the law, the kind of its chips' biases, its temperature (degC), in words where it
    follows a course, and a ripple of the supply where there is one.
    """
    said = str(Course(scenario.course)) if scenario.course else scenario.temperature_c
    die = describe_die(scenario.die)
    return {
        **{name: value for name, value in die.items() if name != "edits" or value},
        "law": scenario.law,
        "bias_kind": scenario.bias_kind,
        "temperature_C": said,
        "ripple": None if scenario.ripple is None else str(scenario.ripple),
    }


def _circuit_at(text: str, wanted: Circuit) -> tuple[Circuit, Place]:
    """Circuit and place of `CHIP/INSTANCE[INDEX]/...`, where a circuit like `wanted` must stand."""
    name, parts = split_place(text)
    chip_block = block_of_target(name)
    chip = chip_block.build()
    if not parts:
        known = ", ".join(instance_names(chip)) or "none"
        raise ParameterError(f"at: {text}, must be CHIP/INSTANCE; instances of {name} are {known}")
    try:
        path = [split_reference(part) for part in parts]
    except TopologyError as error:
        raise ParameterError(f"at: {error}") from None
    circuit, place = circuit_at(chip, path)
    if circuit.name != wanted.name:
        raise ParameterError(f"at: {text} is a {circuit.name}, must be a {wanted.name}; name another place")
    return circuit, place


def _label(name: str, index: Shape) -> str:
    return f"{name}[{','.join(map(str, index))}]" if index else name


def parameters(params: Any) -> Iterator[Parameter]:
    """Every number of a `Params` value, those of its parts under dotted names.

    Raises `ParameterError` for a number whose field states no unit.
    """
    for field in fields(params):
        value = getattr(params, field.name)
        if is_dataclass(value):
            yield from (replace(inner, name=f"{field.name}.{inner.name}") for inner in parameters(value))
        else:
            yield Parameter(field.name, value, _unit(type(params), field))


def _unit(owner: type, field: Field[Any]) -> str:
    unit = field.metadata.get("unit")
    if not isinstance(unit, str):
        raise ParameterError(
            f"{owner.__module__}.{owner.__qualname__}.{field.name}: states no unit, must have one;"
            f' write {field.name} = quantity(value, "F"), or "" for a plain number'
        )
    return unit


def read_params(params: Any, texts: Iterable[str]) -> Any:
    """Return `params` with the values of `texts` set."""
    known = {p.name: p for p in parameters(params)}
    for text in texts:
        name, value = split_assignment(text, "param")
        if name not in known:
            raise unknown_name("parameter", name, known)
        params = _set(params, name, _like(known[name], value))
    return params


def read_bias_set(block: Block, name: str) -> Mapping[str, float]:
    """Values of a block's named set of biases, A or V.

    Raises `UnknownNameError` with the names that there are, `ParameterError` for a block without any.
    """
    if not block.bias_sets:
        raise ParameterError(f"bias_set: {name}, {block.name} has no named sets; set biases by `bias`")
    if name not in block.bias_sets:
        raise unknown_name(f"{block.name} bias set", name, block.bias_sets)
    return block.bias_sets[name]


def read_biases(circuit: Circuit, texts: Iterable[str], kind: BiasKind | None = None) -> dict[str, Value]:
    """Values of biases by name, A, or V for one of kind `voltage`.

    A current may be a code of the bias generator, as `6:244`, unless its bias has a fixed gate voltage; kind:
    what current biases become, their own unless given.
    """
    known = {b.name: b for b in circuit.biases}
    values: dict[str, Value] = {}
    for text in texts:
        name, value = split_assignment(text, "bias")
        element = _ELEMENT.fullmatch(name)
        name = element.group(1) if element else name
        if name not in known:
            raise unknown_name("bias", name, known)
        bias = known[name]
        made = bias.kind if kind is None or bias.kind == "voltage" else kind
        numbers = _coded(value, made, name) or _numbers(value, bias_unit(bias), name)
        shape = circuit.port(bias.port).shape
        size = int(np.prod(shape, dtype=int))
        if element and not shape:
            raise ParameterError(f"{name}[{element.group(2)}]: no array; set {name}")
        if element:
            numbers = _with_element(values.get(name, bias.value), size, element.group(2), numbers, name)
        elif isinstance(numbers, tuple) and len(numbers) != size:
            raise ParameterError(f"{name}: {len(numbers)} values, must be one or {size}")
        values[name] = numbers
    return values


def _coded(text: str, kind: BiasKind, name: str) -> Value | None:
    """Nominal current of a coarse and a fine code, A, and None for what is no code."""
    code = _CODE.fullmatch(text)
    if code is None or kind == "voltage":
        return None
    if kind == "gate":
        raise ParameterError(
            f"{name}: code {text}, a fixed gate voltage has no code; take the bias kind generator or"
            " ideal, or give a current"
        )
    coarse, fine = (int(part) for part in code.groups())
    if not (coarse < len(COARSE) and 0 < fine < CODES):
        raise ParameterError(
            f"{name}: code {text}, must be coarse 0 to {len(COARSE) - 1} and fine 1 to {CODES - 1}"
        )
    return float(currents_of(np.array([coarse, fine])))


def bias_unit(bias: Bias) -> str:
    """V for a voltage, A for what a current stands behind."""
    return "V" if bias.kind == "voltage" else "A"


def read_stimuli(known: Iterable[Stimulus], texts: Iterable[str]) -> dict[str, float | None]:
    """A value for each stimulus, its default unless set; None is off."""
    by_name = {s.name: s for s in known}
    values = {s.name: s.default for s in by_name.values()}
    for text in texts:
        name, value = split_assignment(text, "stimulus")
        if name not in by_name:
            raise unknown_name("stimulus", name, by_name)
        values[name] = _stimulus(by_name[name], value)
    return values


def _stimulus(stimulus: Stimulus, text: str) -> float | None:
    if text == "off":
        if stimulus.can_be_off:
            return None
        raise ParameterError(
            f"{stimulus.name}: off, must have a value; give one in {stimulus.unit or 'numbers'}"
        )
    if text == "on" and stimulus.can_be_off and stimulus.default is not None:
        return stimulus.default
    return parse_quantity(text, stimulus.unit, stimulus.name)


def _like(parameter: Parameter, text: str) -> Any:
    """Read `text` as a value of the parameter's own type."""
    name, old = parameter.name, parameter.value
    if isinstance(old, bool) or not isinstance(old, int | float | tuple):
        raise ParameterError(f"{name}: no number; set it in Python")
    new = _numbers(text, parameter.unit, name)
    if isinstance(old, tuple):
        new = new if isinstance(new, tuple) else (new,) * len(old)
        if len(new) != len(old):
            raise ParameterError(f"{name}: {len(new)} values, must be one or {len(old)}")
        return new
    if isinstance(new, tuple):
        raise ParameterError(f"{name}: {len(new)} values, must be one")
    if isinstance(old, int):
        if new != int(new):
            raise ParameterError(f"{name}: {new:g}, must be a whole number")
        return int(new)
    return new


def _numbers(text: str, unit: str, name: str) -> Value:
    values = tuple(parse_quantity(part, unit, name) for part in text.split(","))
    return values if len(values) > 1 else values[0]


def _with_element(old: Value, size: int, index: str, value: Value, name: str) -> Value:
    if isinstance(value, tuple):
        raise ParameterError(f"{name}[{index}]: {len(value)} values, must be one")
    if "," in index or int(index) >= size:
        raise ParameterError(f"{name}[{index}]: no such element; it has {size}, counted from 0")
    values = list(old) if isinstance(old, tuple) else [old] * size
    values[int(index)] = value
    return tuple(values)


def _set(params: Any, name: str, value: Any) -> Any:
    head, _, rest = name.partition(".")
    return replace(params, **{head: _set(getattr(params, head), rest, value) if rest else value})


def refuse_bias_file(block: str, bias_file: str | None) -> None:
    """Raise `ParameterError` for a bias file of anything but `ROLLS`."""
    if bias_file is not None:
        raise ParameterError(f"bias_file: {bias_file}, of rolls only; set biases of {block} by `bias`")
