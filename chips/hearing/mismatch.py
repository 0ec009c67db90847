"""Mismatch of the hearing's circuits: the deviations of devices that move its thresholds.

| device | what it moves |
|---|---|
| onset neuron's mh, mt | the step of the amplified envelope that the onset neuron asks for, 42 mV |
| comparators' mc1 to mc5 | the threshold of either neuron |
| onset comparator's mc1 to mc7 | whether `v_active` is low at rest; where it is high, no refractory ends |
| detector's mf, mr | the envelope's pedestal |

The other devices switch between the rails. A vector of deviations has the order of `PARAMETERS`.

At rest mc6, which copies mc1 through mc4, must carry more than mc7, which is a share of mc3. The rest margin,
in volts of v_level, bends with the logarithm of that ratio; so what these four (`RATIO`) add to it has one
common curvature: `x + bend x^2 / 2`.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from chips.measured.perturbation import deviations_of
from circuits.arrays import F64
from circuits.blocks.sonar import envelope_detector, high_threshold_neuron, onset_neuron
from circuits.circuit import Circuit
from circuits.lowering.on_die import on_die
from circuits.silicon.silicon import Silicon

_COMPARATOR = tuple(f"generator.comparator.mc{k}" for k in range(1, 8))
DEVICES: dict[str, tuple[str, ...]] = {
    "envelope_detector": ("mf", "mr"),
    "onset_neuron": ("mh", "mt", *_COMPARATOR),
    "high_threshold_neuron": _COMPARATOR[:5],
}
PARAMETERS = tuple(f"{circuit}/{x}" for circuit, names in DEVICES.items() for x in deviations_of(names))
RATIO = np.array(
    [p.startswith("onset") and p.rpartition(".")[0][-3:] in {"mc3", "mc4", "mc6", "mc7"} for p in PARAMETERS]
)

# V, v_level of the onset neuron as built, of which the record is
LEVEL = next(float(np.asarray(b.value)) for b in onset_neuron.BIASES if b.name == "v_level")
_AT_LEVEL = PARAMETERS.index("onset_neuron/mt.v_t0")  # whose gate v_level is


def deviations(silicon: Silicon, v_level: float = LEVEL) -> F64:
    """Return the deviations of all these devices on the silicon's die, V_T0 (V) and ln beta.

    The array is float64[parameters], in the order of `PARAMETERS`. v_level: of the onset neuron, V, whose
    difference from the one as built counts as a threshold of mt that is lower by as much.
    """
    names = [DEVICES[circuit.name] for circuit in _circuits()]
    each = [on_die(c, silicon, n).offset(*n) for c, n in zip(_circuits(), names, strict=True)]
    found = np.concatenate(each)
    found[_AT_LEVEL] -= v_level - LEVEL
    return found


@cache
def _circuits() -> tuple[Circuit, ...]:
    return envelope_detector.build(), onset_neuron.build(), high_threshold_neuron.build()
