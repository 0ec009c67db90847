"""A ROLLS chip that learns with the mismatch of one group of its devices alone.

`of_group` takes the tables of a group from the die's chip and all others from the same die without mismatch.
A group's biases have the copies that are its own devices' on the die.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chips.rolls.plastic.tables import BuiltPlastic, zeta_at
from chips.rolls.tables import Built
from circuits.errors import ParameterError, unknown_name

GROUPS = ("neurons", "weights", "slow filters", "learning circuits", "teaching")
_WEIGHTS = ("up", "down", "rise", "fall", "middle", "charge")
_GATES = ("spike", "ratio", "threshold", "passed")
_SLOW, _CALCIUM = 0, 1


def of_group(group: str, plain: Built, die: Built) -> Built:
    """Tables with the mismatch of one of GROUPS alone.

    neurons; weights: plastic synapses and their columns' extenders; slow filters: of the plastic synapses;
    learning circuits: calcium, thresholds, extenders; teaching: virtual and non-plastic synapses with their
    filters. plain, die: of the same chip with a plastic array, without and with mismatch.

    Raises `UnknownNameError` for another group, `ParameterError` for a chip with depressed synapses.
    """
    if group not in GROUPS:
        raise unknown_name("mismatch group", group, GROUPS)
    if die.depression is not None:
        raise ParameterError("group: of a chip with depressed synapses, must be of one without; leave it out")
    if plain.plastic is None or die.plastic is None:
        raise TypeError(group)
    if group == "neurons":
        tables = plain.tables._replace(membranes=die.tables.membranes)
        own = plain.plastic.tables._replace(
            share=die.plastic.tables.share,
            membrane=zeta_at(plain.plastic.gates.membrane, die.tables.membranes),
        )
        plastic = replace(plain.plastic, tables=own)
        return replace(plain, tables=tables, neurons=die.neurons, plastic=plastic)
    if group == "teaching":
        tables = die.tables._replace(membranes=plain.tables.membranes)
        return replace(
            plain, tables=tables, filters=die.filters, loads=die.loads, shapes=die.shapes, levels=die.levels
        )
    return replace(plain, plastic=_plastic(group, plain, plain.plastic, die.plastic))


def _plastic(group: str, chip: Built, plain: BuiltPlastic, die: BuiltPlastic) -> BuiltPlastic:
    if group == "weights":
        changed = {name: getattr(die.tables, name) for name in _WEIGHTS}
        return replace(plain, tables=plain.tables._replace(**changed), cells=die.cells, lengths=die.lengths)
    if group == "slow filters":
        return _with_filter(_SLOW, plain, die)
    changed = {name: getattr(die.tables, name) for name in _GATES}
    changed["membrane"] = zeta_at(die.gates.membrane, chip.tables.membranes)
    found = _with_filter(_CALCIUM, plain, die)
    return replace(found, tables=found.tables._replace(**changed), gates=die.gates)


def _with_filter(which: int, plain: BuiltPlastic, die: BuiltPlastic) -> BuiltPlastic:
    """`plain` with one of its two filters from `die`."""
    chosen = (die, plain) if which == _SLOW else (plain, die)
    omega = np.stack([each.tables.omega[k] for k, each in enumerate(chosen)])
    banks = chosen[0].tables.banks[0], chosen[1].tables.banks[1]
    return replace(
        plain,
        tables=plain.tables._replace(omega=omega, banks=banks),
        filters=(chosen[0].filters[0], chosen[1].filters[1]),
        loads=(chosen[0].loads[0], chosen[1].loads[1]),
        shapes=(chosen[0].shapes[0], chosen[1].shapes[1]),
    )
