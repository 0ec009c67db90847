"""Our transistor law on a foundry's silicon: a process whose numbers are fitted to the foundry's cards.

ngspice makes the curves of devices of several sizes from the cards: drain current over the gate, at a low and
a high drain, with the source at the bulk and above it, at three temperatures. `circuits.extraction.fit` fits
our law to them from 100 pA to 10 uA. Beside the fit:

- junctions: leakage between drain and bulk of a wide device that is off, and the rise that doubles it, from
  ngspice; capacitances from the cards' own figures of oxide, overlap and junction.
- mismatch: our law has one coefficient for both polarities and the drawn area, so that the foundry's is taken
  in the mean over sizes and polarities; how far single sizes are off is told.
- what a die shares: each of the foundry's draws is moved by one sigma either way, and the shifts of V_T and
  beta of a device of 6 um by 3 um are added as squares.

Sizes are in three classes: those that are fitted, and five a polarity that are not, by which the law is
judged. All are ours.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.errors import ParameterError
from circuits.extraction.extraction import Extraction, extract_from
from circuits.extraction.points import Points, joined
from circuits.silicon.die import Die
from circuits.silicon.process import (
    POLARITIES,
    PROCESSES,
    ROLLS_180,
    Polarity,
    Process,
    TransistorModel,
    Variation,
)
from circuits.silicon.sampling import Sampling
from netlists.foundry.deck import bulk_current, sweep_gate
from netlists.foundry.die import FOUNDRY, draws, law_of
from netlists.foundry.process import DeviceMapping, choose_cards, read_cards

TEMPERATURES_C = (-20.0, 27.0, 85.0)
"""Temperatures of the curves, degC."""
SOURCES = (0.0, 0.3)
"""Voltages of the source to the bulk, V."""
DRAINS = (0.1, 1.65)
"""Voltages of the drain to the source, V; the higher one is at most half a volt below the supply."""
RANGE = (1e-10, 1e-5)
"""Currents that are fitted, A."""
_UM = 1e-6
FITTED_UM = (
    (0.5, 0.5), (0.5, 2.0), (0.5, 10.0), (1.0, 0.4), (1.0, 1.0), (2.0, 0.5), (2.0, 2.0), (2.0, 10.0),
    (3.0, 25.0), (6.0, 0.4), (6.0, 1.0), (6.0, 3.0), (6.0, 8.0), (20.0, 0.5), (20.0, 2.0), (20.0, 10.0),
    (30.0, 50.0), (90.0, 1.5), (90.0, 25.0),
)  # fmt: skip
"""Sizes that are fitted, width and length, um."""
HELD_OUT_UM = ((0.7, 0.7), (1.5, 4.0), (3.0, 1.2), (8.0, 6.0), (12.0, 0.6))
"""Sizes by which a law is judged, width and length, um; none is fitted."""
_STEP = 0.02  # V, of the gate
_PROBE = (6.0 * _UM, 3.0 * _UM)  # of the draws that a die shares
_WEAK, _STRONG = 1e-8, 1e-5  # A, where V_T and beta are read of that device
_TOP_PROBE = 1.6  # V, of the gate, above where that current flows


def extract(mapping: DeviceMapping, name: str) -> Extraction:
    """Fit our law to a foundry's cards, in ngspice.

    Parameters
    ----------
    mapping
        The foundry's process.
    name
        Name of the process that is made.

    Raises
    ------
    DataError
        The package is not installed.
    SimulatorError
        ngspice is missing or fails.
    ParameterError
        A size that no card holds for.
    """
    points = {p: curves(mapping, p, FITTED_UM).between(*RANGE) for p in POLARITIES}
    held_out = {p: curves(mapping, p, HELD_OUT_UM).between(*RANGE) for p in POLARITIES}
    base = _begun(mapping, name)
    threshold, gain, note = _mismatch(mapping)
    base = replace(base, pair_a_vt=threshold, pair_a_beta=gain, variation=_variation(mapping))
    found = extract_from(points, base, held_out)
    return replace(found, notes=(note, *found.notes))


def curves(mapping: DeviceMapping, polarity: Polarity, sizes_um: Sequence[tuple[float, float]]) -> Points:
    """Drain currents of a foundry's devices over gate, drain, source and temperature, in ngspice.

    Parameters
    ----------
    mapping
        The foundry's process.
    polarity
        `n` or `p`.
    sizes_um
        Width and length of each device, um.

    Raises
    ------
    ParameterError
        A size that no card holds for.
    """
    devices = [_device(polarity, w * _UM, length * _UM) for w, length in sizes_um]
    return joined(
        _swept(devices, mapping, celsius, source, drain)
        for celsius, source, drain in itertools.product(TEMPERATURES_C, SOURCES, DRAINS)
    )


def _swept(
    devices: Sequence[Transistor], mapping: DeviceMapping, celsius: float, source: float, drain: float
) -> Points:
    top = min(mapping.v_dd, 2.4)
    above = source + min(drain, mapping.v_dd - 0.5)
    gate, current = sweep_gate(devices, mapping, (0.0, top, _STEP), celsius, source, above)
    count, n = current.shape
    width, length = (np.repeat([getattr(d, side) for d in devices], n) for side in ("width", "length"))
    same = (np.full(count * n, x) for x in (celsius, above, source))
    temperature, v_d, v_s = same
    found = np.maximum(current.ravel(), 1e-30)
    return Points(devices[0].polarity, width, length, temperature, v_d, np.tile(gate, count), v_s, found)


def _device(polarity: Polarity, width: float, length: float) -> Transistor:
    return Transistor("m", polarity, "d", "g", "s", "b", width, length)


def _begun(mapping: DeviceMapping, name: str) -> Process:
    """The process before the fit: the cards' capacitances, and ngspice's leakage."""
    models = {}
    for polarity in POLARITIES:
        card = _figures(mapping, polarity)
        leakage, doubling = _leakage(mapping, polarity)
        models[polarity] = TransistorModel(
            v_t0=0.7, kappa=0.75, mu_cox=250e-6 if polarity == "n" else 60e-6, law="ekv-gamma",
            surface_potential=0.8, early_field=1e7, early_rise=0.13, mobility_reduction=0.2,
            oxide_capacitance=3.453133e-11 / card["toxe"],
            overlap_capacitance=card["cgso"] + card["cgsl"],
            junction_capacitance=card["cjs"] * mapping.sizes.diffusion + 2.0 * card["cjsws"],
            junction_leakage=leakage, leakage_doubling=doubling,
        )  # fmt: skip
    return Process(name, models["n"], models["p"], mapping.v_dd, 0.0, 0.0)


def _figures(mapping: DeviceMapping, polarity: Polarity) -> dict[str, float]:
    """Figures of the card of a device of 6 um by 3 um; those that it lacks are 0."""
    text = choose_cards(read_cards(mapping, polarity), mapping, polarity, [_PROBE])
    found = dict(re.findall(r"\b(toxe|cgso|cgsl|cjs|cjsws)\s*=\s*([-+.0-9eE]+)", text, re.IGNORECASE))
    figures = {key.lower(): float(value) for key, value in found.items()}
    if "toxe" not in figures:
        raise ParameterError(f"{mapping.name}: its card states no toxe; extract needs the oxide's thickness")
    return {key: figures.get(key, 0.0) for key in ("toxe", "cgso", "cgsl", "cjs", "cjsws")}


def _leakage(mapping: DeviceMapping, polarity: Polarity) -> tuple[float, float]:
    """Leakage of a junction for each width at 27 degC, A/m, and the rise that doubles it, K."""
    wide = _device(polarity, 20.0 * _UM, 2.0 * _UM)
    drain = min(DRAINS[1], mapping.v_dd - 0.5)
    cold, warm = (bulk_current(wide, mapping, drain, celsius) / wide.width for celsius in (27.0, 85.0))
    return cold, (85.0 - 27.0) / max(math.log2(max(warm / cold, 1.0 + 1e-9)), 1.0)


def _mismatch(mapping: DeviceMapping) -> tuple[float, float, str]:
    """Our coefficients of a pair, V m and m, and how far single sizes are off the foundry's."""
    pairs = []
    for polarity, (w, length) in itertools.product(POLARITIES, FITTED_UM):
        sigma = law_of(mapping, polarity).sigma(w * _UM, length * _UM)
        pairs.append([s * math.sqrt(2.0 * w * length) * _UM for s in sigma])
    table = np.array(pairs)
    mean = table.mean(axis=0)
    off = 100.0 * (mean[0] / table[:, 0] - 1.0)
    note = (
        f"mismatch: one A_VT of {1e9 * mean[0]:.2f} mV um for both polarities and the drawn area,"
        f" {off.min():+.0f}"
        f" to {off.max():+.0f} % of the sigma of single sizes; A_beta {1e8 * mean[1]:.2f} % um"
    )
    threshold, gain = (float(f"{x:.4g}") for x in mean)
    return threshold, gain, note


def _variation(mapping: DeviceMapping) -> Variation:
    """Sigma of V_T and beta that a die's devices share, the root mean square of both polarities.

    V_T is read as the gate's shift at a weak current, beta as what the shift at a strong one is beyond that,
    times g_m / I_D there.
    """
    if mapping.statistics is None:
        return PROCESSES.get(mapping.statistics_of, ROLLS_180).variation
    names = [each.name for each in draws(mapping)]
    squares = np.zeros(2)
    for polarity in POLARITIES:
        steepness = _probe(mapping, polarity, names, "")[2]
        for name in names:
            low, high = (_probe(mapping, polarity, names, name, z) for z in (-1.0, 1.0))
            weak, strong = 0.5 * (high - low)[:2]
            squares += np.square([weak, steepness * (strong - weak)])
    threshold, gain = np.sqrt(squares / len(POLARITIES))
    return Variation(float(f"{threshold:.4g}"), float(f"{gain:.4g}"))


def _probe(
    mapping: DeviceMapping, polarity: Polarity, names: Sequence[str], moved: str, z: float = 0.0
) -> F64:
    """Gate voltages, V, at a weak and a strong current, and g_m / I_D, 1/V, at the strong one.

    names: of all draws, which are 0 but for that of `moved`, which is z.
    """
    columns = {f"process.{FOUNDRY}.shared.{name}": k for k, name in enumerate(names)}
    row = np.array([[z if name == moved else 0.0 for name in names]])
    die = Die(number=0, mismatch=False, sampling=Sampling("a draw", 0, columns, row))
    device = _device(polarity, *_PROBE)
    gate, current = sweep_gate([device], mapping, (0.2, _TOP_PROBE, 0.01), 27.0, 0.0, DRAINS[1], die)
    logarithm = np.log(np.maximum.accumulate(current[0]))
    at = np.interp(np.log([_WEAK, _STRONG]), logarithm, gate)
    return np.array([*at, np.interp(at[1], gate, np.gradient(logarithm, gate))])
