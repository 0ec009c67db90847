"""Devices of a neuron on a die, and what deviates in them, as a page shows them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from circuits.circuit import Circuit
from circuits.lowering.on_die import Fet, on_die, transistor_of
from circuits.silicon.die import Path
from circuits.silicon.silicon import Silicon
from system.view.film import Device

MOST = 40  # devices of a neuron that are listed; ours


def devices_of(circuit: Circuit, silicon: Silicon, place: Path = (), at: int = 0) -> tuple[Device, ...]:
    """Return the transistors of a circuit at one of its places on a chip, those that deviate most first.

    Parameters
    ----------
    circuit
        The circuit, as a neuron.
    silicon
        Process, temperature and die.
    place
        Where its copies stand: the chip, then the array with its shape, as `on_die` takes it.
    at
        Which of the copies, counted in the order of their places.
    """
    d = on_die(circuit, replace(silicon, place=place[:1] or None), place=place)
    below = "".join(f"{name}." if not shape else f"{name}[{at}]." for name, shape in place[1:])
    found = [_device(f"{below}{name}", name, fet, at, circuit, silicon) for name, fet in d.fet.items()]
    return tuple(sorted(found, key=lambda one: (-one.sigma, one.path))[:MOST])


def _device(path: str, name: str, fet: Fet, at: int, circuit: Circuit, silicon: Silicon) -> Device:
    width, length, volts, beta = (
        float(np.broadcast_to(x, fet.v_t0.shape).reshape(-1)[at])
        for x in (fet.width, fet.length, fet.v_t0, fet.beta)
    )
    root, process = math.sqrt(2.0 * width * length), silicon.process
    pairs = (volts, process.pair_a_vt), (beta, process.pair_a_beta)
    sigmas = [abs(value) * root / scale for value, scale in pairs if scale > 0.0]
    polarity = transistor_of(circuit, name).polarity
    return Device(
        path=path,
        what=f"{polarity}FET {1e6 * width:.3g}/{1e6 * length:.3g} um",
        deviation=f"V_T0 {1e3 * volts:+.2f} mV, beta {100.0 * beta:+.2f} %",
        sigma=max(sigmas, default=0.0),
    )
