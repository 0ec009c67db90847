"""Deviations that are put on single devices of a circuit by hand, to measure the gradients of a record."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.lowering.kernel import Machine

POLARITIES = ("n", "p")  # in the place of a device: all of a polarity


def perturbed(
    machine: Machine, device: str, threshold: float = 0.0, log_beta: float = 0.0, held: Sequence[str] = ()
) -> Machine:
    """Return the machine with a deviation of V_T0 (V) and of ln beta.

    device: instance path of the device that deviates, or `n` or `p` for all of a polarity but those that are
    `held`, whose currents are coordinates of the record.
    """
    t = machine.kernel.transistors
    names = np.array(machine.flat.labels(Transistor))
    chosen = names == device
    if device in POLARITIES:
        chosen = (t.sign == (1.0 if device == "n" else -1.0)) & ~np.isin(names, held)
    table = t._replace(
        v_t0=t.v_t0 + chosen * threshold, specific_current=t.specific_current * np.exp(chosen * log_beta)
    )
    return replace(machine, kernel=machine.kernel._replace(transistors=table))


def deviating(machine: Machine, parameter: str, amount: float, held: Sequence[str] = ()) -> Machine:
    """Return the machine with one deviation, an amount of `DEVICE.v_t0` (V) or of `DEVICE.beta` (ln beta)."""
    device, _, kind = parameter.rpartition(".")
    if kind == "v_t0":
        return perturbed(machine, device, threshold=amount, held=held)
    return perturbed(machine, device, log_beta=amount, held=held)


def deviations_of(devices: Sequence[str]) -> tuple[str, ...]:
    """Return the names of all deviations of devices, as `deviating` takes them: V_T0 and ln beta of each."""
    return tuple(f"{device}.{kind}" for device in devices for kind in ("v_t0", "beta"))


def slopes(
    value: Callable[[str, float], float], parameters: Sequence[str], steps: Mapping[str, float]
) -> F64:
    """Return central differences of a value by each deviation, float64[parameters], over V or over 1.

    value: of a deviation's name and its amount; steps: to both sides, of `v_t0` in V and of `beta` in ln
    beta.
    """
    found = []
    for parameter in parameters:
        h = steps[parameter.rpartition(".")[2]]
        found.append((value(parameter, h) - value(parameter, -h)) / (2.0 * h))
    return np.array(found)
