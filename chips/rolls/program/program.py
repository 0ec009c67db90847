"""A program of ROLLS: weight levels, virtual synapses, leak latches and biases that are written to it.

Level 0 lets nothing in; 1 to 4 excite and -1 to -4 inhibit. All synapses of a sign share three currents, so
that a level is one of four sums (control software, `ROLLSDevice.h`: weight_0 is the constant current,
weight_1 and weight_2 add one bit, weight_3 both):

    I_w(1) = I_const    I_w(2) = I_const + I_w0    I_w(3) = I_const + I_w1    I_w(4) = I_const + I_w0 + I_w1

They rise with the level only where the biases let them. A level that needs a current whose fine code is 0
does not exist: it would be another one. An external input takes one virtual synapse or more of every neuron
it reaches; a virtual synapse belongs to one input (ours: the chip itself does not know who stimulates it).

`chips.rolls.program.words` writes a program to a chip.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from chips.rolls.depression.program import STEP_BIAS, ShortTermDepression
from chips.rolls.plastic.program import PlasticArray
from chips.rolls.program.address import LAB_VIRTUAL, NEURONS, VirtualSynapses
from chips.rolls.program.bias_file import BiasTable, resting_biases
from circuits.arrays import I8, I64, Bools
from circuits.blocks.rolls.bias import current_of
from circuits.errors import ParameterError

HIGHEST_LEVEL = 4
_CONSTANT = {1: "NPA_WEIGHT_EXC_P", -1: "NPA_WEIGHT_INH_N"}
_BITS = {1: ("NPA_WEIGHT_EXC0_P", "NPA_WEIGHT_EXC1_P"), -1: ("NPA_WEIGHT_INH0_N", "NPA_WEIGHT_INH1_N")}
_VIRTUAL_WEIGHT = {False: "VA_EXC_N", True: "VA_INH_P"}  # by inhibitory


@dataclass(frozen=True, slots=True)
class VirtualInput:
    """An external input on virtual synapses of one sign.

    Attributes
    ----------
    name : str
        Name of the input.
    neurons : tuple of int
        Neurons that it reaches, each once; an event is for one of them (`input_words`).
    synapses : int
        How many virtual synapses of a neuron each event reaches.
    inhibitory : bool
        Whether these inhibit.
    """

    name: str
    neurons: tuple[int, ...]
    synapses: int = 1
    inhibitory: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "neurons", tuple(int(n) for n in self.neurons))


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """What is written to a chip; arrays are copied and cannot be written.

    Raises `ParameterError` for a ninth weight, a level or an input whose bias is off, a neuron that the chip
    does not have, more virtual inputs than a neuron has virtual synapses, and depression of nothing.

    Attributes
    ----------
    levels
        Weight levels, int8[post, pre], 256 x 256, -4 to 4; a smaller square one holds for the first
        neurons.
    biases
        Biases of the chip, by code.
    tau1
        Neurons whose leak is IF_TAU1; all others have IF_TAU2.
    inputs
        External inputs.
    virtual
        How many virtual synapses a neuron has.
    plastic
        The plastic array; None where it is not used.
    depression
        Short-term depression of the excitatory synapses; None where it is not used.
    """

    levels: I8
    biases: BiasTable = field(default_factory=resting_biases)
    tau1: tuple[int, ...] = ()
    inputs: tuple[VirtualInput, ...] = ()
    virtual: VirtualSynapses = LAB_VIRTUAL
    plastic: PlasticArray | None = None
    depression: ShortTermDepression | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "levels", _checked_levels(self.levels))
        object.__setattr__(self, "tau1", tuple(sorted({int(n) for n in self.tau1})))
        _check_neurons("tau1", self.tau1)
        _check_biases(self.levels, self.biases)
        _check_inputs(self)
        if self.plastic is not None and not isinstance(self.plastic, PlasticArray):
            raise ParameterError(f"program.plastic: {type(self.plastic).__name__}, must be a PlasticArray")
        if self.depression is not None:
            _check_depression(self, self.depression)

    def slow_leak(self) -> Bools:
        """Return whether the leak of each neuron is IF_TAU1, bool[256]."""
        chosen = np.zeros(NEURONS, dtype=np.bool_)
        chosen[list(self.tau1)] = True
        return chosen

    def input(self, name: str) -> VirtualInput:
        """Return the input that is called `name`; raises `ParameterError` for another name."""
        for each in self.inputs:
            if each.name == name:
                return each
        known = ", ".join(each.name for each in self.inputs) or "none"
        raise ParameterError(f"program.input: {name}, must be one of the inputs; they are {known}")


def check_unlearned(program: Program, what: str) -> None:
    """Raise `ParameterError` where a program has a plastic array, which `what` does not."""
    if program.plastic is not None:
        raise ParameterError(f"program.plastic: given, must be None for {what}; leave the plastic array out")


def check_undepressed(program: Program, what: str) -> None:
    """Raise `ParameterError` where a program has short-term depression, which `what` does not."""
    if program.depression is not None:
        raise ParameterError(f"program.depression: given, must be None for {what}; leave depression out")


def level_current(biases: BiasTable, level: int) -> float:
    """Return the nominal current that a synapse of `level` draws during its pulse, A, 0 for level 0.

    Raises `ParameterError` for a level that is not -4 to 4.
    """
    if not -HIGHEST_LEVEL <= level <= HIGHEST_LEVEL:
        raise ParameterError(f"level: {level}, must be {-HIGHEST_LEVEL} to {HIGHEST_LEVEL}; 0 is off")
    if level == 0:
        return 0.0
    sign, bits = int(np.sign(level)), abs(level) - 1
    names = [_CONSTANT[sign], *(name for k, name in enumerate(_BITS[sign]) if bits >> k & 1)]
    return sum(current_of(biases.code(name)) for name in names)


def missing_levels(biases: BiasTable) -> dict[int, str]:
    """Return the levels that the biases do not have, each with the bias that is off."""
    missing = {}
    for sign in (1, -1):
        needed = {1: (_CONSTANT[sign],), 2: _BITS[sign][:1], 3: _BITS[sign][1:], 4: _BITS[sign]}
        for level, names in needed.items():
            off = [name for name in names if biases.is_off(name)]
            if off:
                missing[sign * level] = off[0]
    return missing


def _checked_levels(levels: ArrayLike) -> I8:
    given = np.asarray(levels)
    if given.ndim != 2 or given.shape[0] != given.shape[1]:
        shape = " x ".join(map(str, given.shape))
        raise ParameterError(f"program.levels: {shape}, must be a square of (post, pre); give both neurons")
    if given.shape[0] > NEURONS:
        raise ParameterError(
            f"program.levels: neuron {given.shape[0] - 1}, must be 0 to {NEURONS - 1};"
            " make populations smaller, or take two chips"
        )
    whole = given.astype(np.float64)
    wrong = ~((np.abs(whole) <= HIGHEST_LEVEL) & (whole == np.floor(whole)))
    if wrong.any():
        post, pre = np.argwhere(wrong)[0]
        raise ParameterError(
            f"program.levels[{post}, {pre}]: {given[post, pre]}, must be a whole number from -4 to 4;"
            " the chip has eight weights, so share one, or change the weight biases"
        )
    placed = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    placed[: given.shape[0], : given.shape[1]] = given
    placed.flags.writeable = False
    return placed


def _check_biases(levels: I8, biases: BiasTable) -> None:
    for level, name in missing_levels(biases).items():
        if (levels == level).any():
            post, pre = np.argwhere(levels == level)[0]
            raise ParameterError(
                f"program.levels[{post}, {pre}]: {level}, must be a level that the biases have; {name} has"
                " fine code 0: raise it, or take another level"
            )


def _check_depression(program: Program, depression: object) -> None:
    if not isinstance(depression, ShortTermDepression):
        raise ParameterError(
            f"program.depression: {type(depression).__name__}, must be a ShortTermDepression"
        )
    if program.biases.is_off(STEP_BIAS):
        raise ParameterError(
            f"program.depression: {STEP_BIAS} has fine code 0, must be > 0; raise it, or leave depression out"
        )
    if not (program.levels > 0).any():
        raise ParameterError(
            "program.depression: no excitatory synapse, must have one; inhibitory ones are not depressed"
        )


def _check_neurons(name: str, neurons: Iterable[int]) -> None:
    for neuron in neurons:
        if not 0 <= neuron < NEURONS:
            raise ParameterError(
                f"program.{name}: neuron {neuron}, must be 0 to {NEURONS - 1}; the chip has {NEURONS} neurons"
            )


def _check_inputs(program: Program) -> None:
    seen: dict[str, VirtualInput] = {}
    count = {False: np.zeros(NEURONS, dtype=np.int64), True: np.zeros(NEURONS, dtype=np.int64)}
    for each in program.inputs:
        path = f"inputs.{each.name}"
        if each.name in seen:
            raise ParameterError(f"program.{path}: given twice, must be one input a name; rename one")
        seen[each.name] = each
        _check_neurons(path, each.neurons)
        if not each.neurons or len(set(each.neurons)) < len(each.neurons):
            raise ParameterError(f"program.{path}.neurons: none or one twice, must be one or more, each once")
        if each.synapses < 1:
            raise ParameterError(f"program.{path}.synapses: {each.synapses}, must be >= 1; drop the input")
        weight = _VIRTUAL_WEIGHT[each.inhibitory]
        if program.biases.is_off(weight):
            raise ParameterError(f"program.{path}: {weight} has fine code 0, must be > 0; raise it")
        count[each.inhibitory][list(each.neurons)] += each.synapses
        _check_fan_in(program.virtual, each, count[each.inhibitory])


def _check_fan_in(virtual: VirtualSynapses, each: VirtualInput, count: I64) -> None:
    limit, sign = (
        len(virtual.columns(inhibitory=each.inhibitory)),
        "inhibitory" if each.inhibitory else "excitatory",
    )
    if count.max() > limit:
        neuron = int((count > limit).argmax())
        raise ParameterError(
            f"program.inputs.{each.name}: {count[neuron]} {sign} virtual synapses of neuron {neuron}, must be"
            f" <= {limit}; send inputs through one synapse, or take fewer synapses an input"
        )
