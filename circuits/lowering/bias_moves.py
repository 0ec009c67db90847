"""Devices behind the biases of a circuit that stand on the die, and by how much each moves its lines.

A bias of kind `ideal` stands on a copy of its device, one of kind `generator` on a line of the chip's
generator. These devices deviate as those of the circuit do, and are none of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.bias import bias_voltages, copies_of, lines_of
from circuits.circuit import Bias, Circuit
from circuits.devices import Transistor
from circuits.generator.moves import Family, Moves, line_families, line_moves
from circuits.silicon.die import PARAMETERS
from circuits.silicon.process import Process
from circuits.silicon.sampling import labels
from circuits.silicon.silicon import Silicon

_RELATIVE = 1e-4  # step of a current; ours


def behind_bias(label: str) -> bool:
    """Whether a draw is of a device that a bias stands on; its name has a space, which no instance's has."""
    return " " in label


def bias_families(circuit: Circuit, silicon: Silicon) -> tuple[Family, ...]:
    """Devices behind all biases of a circuit that stand on the die, each once."""
    found = {
        (family.place, family.paths): family
        for bias in circuit.biases
        for family in _families(circuit, bias, silicon)
    }
    return tuple(found.values())


def bias_moves(circuit: Circuit, bias: Bias, silicon: Silicon) -> tuple[Moves, ...]:
    """What the devices behind a bias move the voltages of its port by; nothing where none stands on the die.

    circuit, bias, silicon, and what it raises: as of `circuits.bias.bias_voltages`.
    """
    if bias.kind == "generator":
        lines, current = lines_of(circuit, bias, silicon)
        return line_moves(lines, current, silicon)
    return tuple(_copy_moves(circuit, bias, each, silicon) for each in _families(circuit, bias, silicon))


def _families(circuit: Circuit, bias: Bias, silicon: Silicon) -> Iterable[Family]:
    device = None if bias.device is None else circuit.device(bias.device)
    if bias.kind not in {"ideal", "generator"} or not isinstance(device, Transistor):
        return ()
    if bias.kind == "generator":
        lines, current = lines_of(circuit, bias, silicon)
        return line_families(lines, current, silicon.process)
    shape = circuit.port(bias.port).shape
    place, path = copies_of(circuit.name, bias, device, shape, silicon)
    count = 1 if bias.place is not None else int(np.prod(shape))
    return (Family(place, (path,), np.full(count, device.gate_area)),)


def _copy_moves(circuit: Circuit, bias: Bias, family: Family, silicon: Silicon) -> Moves:
    """What an ideal bias's copies move its lines by: their thresholds wholly, the others as currents do."""
    device = circuit.device(bias.device or "")
    sign = -1.0 if isinstance(device, Transistor) and device.polarity == "p" else 1.0
    ends = [voltages_at(circuit, bias, 1.0 + s, silicon).ravel() for s in (_RELATIVE, -_RELATIVE)]
    there = replace(silicon, place=family.place)
    polarity = device.polarity if isinstance(device, Transistor) else None
    beta = there.deviations(circuit.name, family.paths, family.area, polarity and (polarity,)).beta
    by_beta = -(ends[0] - ends[1]) / (2.0 * _RELATIVE * (1.0 + np.asarray(beta)))
    each = np.eye(by_beta.size) if family.area.size == by_beta.size else np.ones((by_beta.size, 1))
    return Moves(family, sign * each, by_beta[:, None] * each)


def by_sigma(moves: Moves, process: Process) -> tuple[list[str], F64]:
    """Labels of a family's draws, and what one sigma of each moves lines by, V, float64[lines, labels]."""
    family, root = moves.family, np.sqrt(2.0 * moves.family.area)
    names = [label for name in PARAMETERS for label in labels(family.place, family.paths, name)]
    by_v_t0, by_beta = process.pair_a_vt * moves.by_v_t0, process.pair_a_beta * moves.by_beta
    return names, np.concatenate([by_v_t0 / root, by_beta / root], axis=1)


def voltages_at(circuit: Circuit, bias: Bias, scale: float, silicon: Silicon) -> F64:
    """Voltages of a bias's port at `scale` times its currents, V, as `bias_voltages` has them."""
    value = scale * np.broadcast_to(np.asarray(bias.value, np.float64), circuit.port(bias.port).shape)
    plain = float(value) if value.ndim == 0 else tuple(map(float, value.ravel()))
    return bias_voltages(circuit, replace(bias, value=plain), silicon)
