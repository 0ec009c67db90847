"""Words of a ROLLS program: those that write it to a chip, and those of the events of its inputs.

A program is written a latch at a time, five words a synapse, sender by sender as the control software does
it, with a pause of 10 us after each synapse (`aerctl.cpp`); what a word takes on the link is not public.
The plastic array's latches and weights follow, where a program has one (`chips.rolls.plastic.words`); its
broadcast latches can be cleared, not set.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from chips.rolls.depression.program import ShortTermDepression
from chips.rolls.plastic.words import plastic_of_words, plastic_words
from chips.rolls.program.address import (
    LAB_VIRTUAL,
    LEAK_RELEASE,
    LEAK_RESET,
    LEAK_TAU1,
    NEURONS,
    NONPLASTIC_LATCHES,
    PLASTIC_LATCHES,
    PLASTIC_WEIGHTS,
    REGIONS,
    VirtualSynapses,
    in_region,
    latch_words,
    leak_words,
    read_latch_words,
    stimulate_words,
)
from chips.rolls.program.bias_file import BiasTable, resting_biases
from chips.rolls.program.program import Program, VirtualInput
from circuits.arrays import I64
from circuits.errors import ParameterError

CELL_PAUSE = 10e-6  # s, after each synapse; aerctl.cpp


def virtual_columns(program: Program) -> dict[str, I64]:
    """Return the columns of each input's virtual synapses by its name, int64[neurons of the input, synapses].

    A neuron gives its inputs its virtual synapses in the order of the inputs.
    """
    used = {False: np.zeros(NEURONS, dtype=np.int64), True: np.zeros(NEURONS, dtype=np.int64)}
    columns = {}
    for each in program.inputs:
        first, taken = program.virtual.columns(inhibitory=each.inhibitory).start, used[each.inhibitory]
        neurons = np.array(each.neurons, dtype=np.int64)
        columns[each.name] = first + taken[neurons][:, None] + np.arange(each.synapses)
        taken[neurons] += each.synapses
    return columns


def input_words(program: Program, name: str, neurons: ArrayLike) -> I64:
    """Return the words of events of the input `name` of `program`, int64[events, synapses].

    `neurons` has the neuron of each event, int64[events]. Raises `ParameterError` where the program does not
    have the input, or the input does not reach a neuron.
    """
    target = program.input(name)
    wanted = np.atleast_1d(np.asarray(neurons, dtype=np.int64))
    order = np.argsort(target.neurons)
    reached = np.array(target.neurons, dtype=np.int64)[order]
    at = np.minimum(np.searchsorted(reached, wanted), reached.size - 1)
    if (reached[at] != wanted).any():
        k = int((reached[at] != wanted).argmax())
        raise ParameterError(
            f"program.input.{name}[{k}]: neuron {wanted[k]}, must be one that it reaches,"
            f" {reached[0]} to {reached[-1]}; add it to the input"
        )
    return stimulate_words(wanted[:, None], virtual_columns(program)[name][order[at]])


def program_words(program: Program, since: Program | None = None) -> I64:
    """Return the words that write a program, in order, int64.

    Only what differs from `since` is written where that is given. Leak latches come first, then five words a
    synapse: recurrent, sign, w0, w1, broadcast (always 0); then those of the plastic array, if it has one.
    """
    pre, post = np.meshgrid(np.arange(NEURONS), np.arange(NEURONS), indexing="ij")
    changed = np.ones((NEURONS, NEURONS), dtype=np.bool_)
    leak = leak_words(np.array(program.tau1, dtype=np.int64))
    if since is not None:
        changed = (program.levels != since.levels).T
        leak = leak if program.tau1 != since.tau1 else leak[:0]
    level = program.levels.T[changed].astype(np.int64)
    bits = np.maximum(np.abs(level) - 1, 0)
    values = np.stack((level != 0, level > 0, bits & 1, bits >> 1, np.zeros_like(level)), axis=1)
    latches = np.arange(len(NONPLASTIC_LATCHES.latches))
    cells = latch_words(
        NONPLASTIC_LATCHES, post[changed][:, None], pre[changed][:, None], latches, values.astype(np.int64)
    )
    plastic = plastic_words(program.plastic, None if since is None else since.plastic)
    return np.concatenate((leak, cells.ravel(), plastic))


def program_of_words(
    words: ArrayLike,
    biases: BiasTable | None = None,
    inputs: Iterable[VirtualInput] = (),
    virtual: VirtualSynapses = LAB_VIRTUAL,
    depression: ShortTermDepression | None = None,
) -> Program:
    """Return the program that words leave on a chip whose latches were all off.

    It has a plastic array if a word sets a latch or a weight there. Biases, inputs and depression are not
    among the words.

    Parameters
    ----------
    words
        Latch words in their order, int64[n].
    biases
        Biases of the chip; those of a new program unless given.
    inputs
        Inputs of the program.
    virtual
        How many virtual synapses each neuron has.
    depression
        Depression of the excitatory synapses; none unless given.

    Raises
    ------
    ParameterError
        A word writes no latch or sets a broadcast latch (not modelled), or the program itself is refused.
    """
    found = np.asarray(words, dtype=np.int64).ravel()
    cells, leak = in_region(NONPLASTIC_LATCHES, found), (found >= LEAK_TAU1) & (found <= LEAK_RELEASE)
    plastic = in_region(PLASTIC_LATCHES, found) | in_region(PLASTIC_WEIGHTS, found)
    if not (cells | leak | plastic).all():
        k = int((~(cells | leak | plastic)).argmax())
        raise ParameterError(
            f"program.words[{k}]: {found[k]} writes no latch; leave out words that stimulate"
        )
    latches = np.zeros((len(NONPLASTIC_LATCHES.latches), NEURONS, NEURONS), dtype=np.int8)
    writes = read_latch_words(NONPLASTIC_LATCHES, found[cells])
    latches[writes.latch, writes.post, writes.pre] = writes.bit  # of several writes the last one holds
    recurrent, sign, w0, w1, broadcast = latches
    if broadcast.any():
        post, pre = np.argwhere(broadcast)[0]
        raise ParameterError(
            f"program.words: broadcast of {pre} to {post} is set, must be 0; broadcasts are not modelled"
        )
    levels = recurrent * (2 * sign - 1) * (1 + w0 + 2 * w1)
    table = resting_biases() if biases is None else biases
    array = plastic_of_words(found[plastic])
    slow = _slow_neurons(found[leak])
    return Program(levels.astype(np.int8), table, slow, tuple(inputs), virtual, array, depression)


def programming_time(words: ArrayLike, pause: float = CELL_PAUSE) -> float:
    """Return the least time that writing words can take, s.

    Parameters
    ----------
    words
        Words, int64 of any shape, in their order; words of the same synapse that follow each other are one
        synapse.
    pause
        Pause after each synapse, s.
    """
    found = np.asarray(words, dtype=np.int64).ravel()
    kind = np.zeros(found.size, dtype=np.int64)
    for k, region in enumerate(REGIONS, start=1):
        kind[in_region(region, found)] = k
    synapse = ((found & 0xFFFF) + (kind << 16))[kind > 0]  # the lower 16 bits tell one cell from another
    return pause * (synapse.size and 1 + int((np.diff(synapse) != 0).sum()))


def _slow_neurons(words: I64) -> tuple[int, ...]:
    """Neurons that leak words, in their order, leave at IF_TAU1."""
    chosen: set[int] = set()
    for word in words.tolist():
        if word == LEAK_RESET:
            chosen.clear()
        elif word < LEAK_RESET:
            chosen.add(word - LEAK_TAU1)
    return tuple(sorted(chosen))
