"""Calibration of the ranging chip: codes by which windows overlap and stand where the design has them.

| what is moved | until |
|---|---|
| i_rslope | the median neuron, which spikes by a call alone from some code on, is well below that |
| v_ex_max, a pad | it is a little below the highest at which all neurons but one answer some delay |
| i_rtau | the median window is as wide as wanted; then the two above once more |
| i_inh_tau[k] | the middle of each window is at the neuron's best delay |

A neuron that still answers a call alone, an echo alone, or no window of a useful width is switched off by its
address: its spikes reach no board. Look-up tables are trimmed to the middles that were measured.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chips.codes import Calibration, Codes, Measured, codes_begun, codes_near
from chips.measured.search import narrowed, narrowed_by_share
from chips.ranging import circuit as ranging_chip
from chips.ranging.calibration import setting
from chips.ranging.calibration.bench import PERIOD, Bench, Values
from chips.ranging.calibration.found import NAME, PADS
from chips.ranging.model import ReboundModel, check_box, model_of
from chips.ranging.record import record_of
from chips.validity import require_area, require_inside
from circuits.arrays import F64, I64, Bools
from circuits.bias import rebias
from circuits.circuit import BiasKind
from circuits.generator.code import nearest_currents
from circuits.silicon.process import AMI_1500, Process
from circuits.silicon.silicon import Silicon

STEP, LAST = 0.25e-3, 0.5 * PERIOD  # s, between delays that are tried, and the last; ours
SPARSE = 4  # steps between delays where only an answer is looked for, in windows of 2 ms and more; ours
LATEST = 70e-3  # s, up to which it is looked for: inhibitions of some dies are twice as long; ours
SHORTER = 1.5  # by which an inhibition is made that is longer than all delays that are tried; ours
ROUNDS, INHIBITION_ROUNDS = 4, 8  # at most; ours
CURRENTS = 50e-12, 2e-9  # A, between which i_rslope is looked for; ours
CURRENT_WITHIN = 0.03  # share
LEVEL_WITHIN = 8e-3  # V, of v_ex_max
SURE = 8  # calls or echoes alone that a neuron must leave without an answer; ours


class Windows(NamedTuple):
    """Delays that neurons answer: width and middle (NaN without any) of each one's, s, float64[n]."""

    width: F64
    middle: F64


def delays() -> F64:
    """Return the delays that are tried, s."""
    return np.asarray(np.arange(STEP, LAST, STEP))


def windows(answers: I64, tried: F64) -> Windows:
    """Return the windows of spikes by delay, int64[delays, n]; tried: the delays, `STEP` apart, s."""
    hit = answers > 0
    count = hit.sum(axis=0)
    middle = np.divide(tried @ hit, count, out=np.full(count.size, np.nan), where=count > 0)
    return Windows(STEP * count, middle)


def calibrate(silicon: Silicon, kind: BiasKind, setup: float | None = None) -> Codes:
    """Calibrate the ranging chip on a silicon, at its temperature.

    Raises `ParameterError` outside the box of the chip's model (`chips.validity`).

    Parameters
    ----------
    silicon
        Process, temperature of the bench, and die.
    kind
        Kind of the biases.
    setup
        Area of its devices against mismatch over the circuit's, a ratio; the circuit's own for None.
    """
    model = _model(silicon.process, kind)
    if setup is not None:
        require_area("ranging_chip", setup, 0.0)  # what smaller devices deviate by is a side of the box
    drawn = silicon if setup is None else silicon.of_area(setup)
    check_box(model, drawn, "ranging_chip")
    bench = Bench(model, drawn)
    before = windows(bench.answers({}, delays()), delays())
    shared = _shared(bench)
    found: Values = {**shared, "i_inh_tau": _inhibitions(bench, shared)}
    after = windows(bench.answers(found, delays()), delays())
    bad = _useless(bench, found, after)
    working = len(bad) <= ranging_chip.NEURONS - setting.LEAST
    return replace(
        codes_begun(NAME, silicon, kind, setup),
        biases=codes_near({name: i for name, i in found.items() if name not in PADS}),
        off={"neuron": tuple(bad)} if bad else {},
        trims={name: tuple(np.ravel(found[name]).tolist()) for name in PADS} | {"delays": _lookup(after)},
        measured=tuple(_measured(before, after)),
        bench_s=bench.seconds,
        unmended=tuple(f"neuron[{k}]: {why}, switched off" for k, why in bad.items()),
        failed="" if working else f"{len(bad)} of {ranging_chip.NEURONS} neurons cannot be used",
    )


@lru_cache(maxsize=8)
def _model(process: Process, kind: BiasKind) -> ReboundModel:
    return model_of(rebias(ranging_chip.build(), kind=kind), process)


def _shared(bench: Bench) -> dict[str, float]:
    """Values of the shared biases, A or V: of the round whose windows are nearest to what is wanted."""
    values, rounds = dict(setting.BEGIN), []
    for _ in range(ROUNDS):
        values["i_rslope"] = _slope(bench, values)
        values["v_ex_max"] = _excitation(bench, values)
        width = windows(bench.answers(values, delays()), delays()).width
        share = float(np.median(width)) / setting.WIDTH
        rounds.append((abs(share - 1.0), dict(values)))
        if abs(share - 1.0) <= setting.WIDTH_WITHIN or share == 0.0:
            break
        values["i_rtau"] *= share
    return min(rounds, key=lambda each: each[0])[1]


def _slope(bench: Bench, values: Values) -> float:
    """I_rslope, A, well below the one at which a call alone makes neurons spike."""

    def least(count: int) -> float:
        def enough(current: float) -> bool:
            return int(bench.call_alone({**values, "i_rslope": current}).sum()) >= count

        return narrowed_by_share(enough, *CURRENTS, CURRENT_WITHIN)[1]

    half = ranging_chip.NEURONS // 2 + 1
    return min(setting.MEDIAN_SHARE * least(half), setting.FIRST_SHARE * least(1))


def _excitation(bench: Bench, values: Values) -> float:
    """V_ex,max, V, a little below the highest at which all neurons but one answer."""
    v_dd = bench.silicon.process.v_dd
    sparse = np.arange(STEP, LATEST, SPARSE * STEP)

    def too_weak(level: float) -> bool:
        found = bench.answers({**values, "v_ex_max": level}, sparse)
        return int(found.any(axis=0).sum()) < ranging_chip.NEURONS - 1

    low = v_dd - bench.model.record.box.v_ex_max
    return narrowed(too_weak, low, v_dd, LEVEL_WITHIN)[0] - setting.BELOW


def _inhibitions(bench: Bench, values: Values) -> tuple[float, ...]:
    """I_inh_tau of each neuron, A, with which the middle of its window is nearest to its best delay.

    A line does not rise with every step of its code, so that each search keeps what it has tried. Where a
    line has no code near enough, the windows beside it are moved half of the way, so that none is missed.
    """
    search = _Search(bench, values, nearest_currents(), [{} for _ in ranging_chip.BEST_DELAYS])
    wanted = np.array(ranging_chip.BEST_DELAYS)
    found = _searched(search, [_nearest(search.codes, i) for i in ranging_chip.I_INH_TAU], wanted)
    off = np.array([search.tried[k].get(i, np.nan) for k, i in enumerate(found)]) - wanted
    far = np.where(np.abs(off) > setting.FAR, off, 0.0)
    if far.any():
        beside = np.concatenate([far[1:], [0.0]]) + np.concatenate([[0.0], far[:-1]])
        found = _searched(search, found, wanted + np.where(far == 0.0, 0.5 * beside, 0.0))
    return _at(search.codes, found)


class _Search(NamedTuple):
    """A search for the codes of all neurons at once; tried: of each, middles, s, by the index of a code."""

    bench: Bench
    values: Values
    codes: F64
    tried: list[dict[int, float]]


def _searched(search: _Search, own: list[int], wanted: F64) -> list[int]:
    """Indices of the codes whose middles are nearest to those wanted, s; own: where the search begins."""
    codes, tried = search.codes, search.tried
    for _ in range(INHIBITION_ROUNDS):
        values = {**search.values, "i_inh_tau": _at(codes, own)}
        found = windows(search.bench.answers(values, delays()), delays())
        for k, index in enumerate(own):
            tried[k][index] = float(found.middle[k])
        following = [_next(codes, tried[k], own[k], wanted[k]) for k in range(len(own))]
        if following == own:
            break
        own = following
    return [_best(tried[k], own[k], wanted[k]) for k in range(len(own))]


def _at(codes: F64, index: list[int]) -> tuple[float, ...]:
    return tuple(float(codes[i]) for i in index)


def _nearest(codes: F64, current: float) -> int:
    return int(np.argmin(np.abs(np.log(codes / current))))


def _best(tried: dict[int, float], own: int, wanted: float) -> int:
    """Index of the code whose window was nearest; the last one where none had a window."""
    known = {i: abs(middle - wanted) for i, middle in tried.items() if np.isfinite(middle)}
    return min(known, key=lambda i: known[i]) if known else own


def _next(codes: F64, tried: dict[int, float], own: int, wanted: float) -> int:
    """Index of the code to try next: where a delay in proportion to 1 / current would be right.

    Where that has been tried, or lies outside of two codes between which the delay is, half way between them.
    """
    best = _best(tried, own, wanted)
    middle = tried[best]
    if not np.isfinite(middle):
        return min(_nearest(codes, SHORTER * codes[own]), codes.size - 1)
    if abs(middle - wanted) <= setting.CENTRE_WITHIN:
        return best
    slower = [i for i, found in tried.items() if found > wanted]
    faster = [i for i, found in tried.items() if found < wanted]
    index = _nearest(codes, codes[best] * middle / wanted)
    if slower and faster and max(slower) < min(faster):
        low, high = max(slower), min(faster)
        return index if low < index < high else (low + high) // 2 if high - low > 1 else best
    side = 1 if middle > wanted else -1
    while index in tried and 0 < index < codes.size - 1:
        index += side
    return index


def _useless(bench: Bench, values: Values, found: Windows) -> dict[int, str]:
    """Neurons that cannot be used, and why."""
    narrow, wide = found.width < setting.NARROWEST, found.width > setting.WIDEST
    reasons: tuple[tuple[str, Bools], ...] = (
        ("it answers a call alone", bench.call_alone(values, SURE)),
        ("it answers an echo alone", bench.echo_alone(values, SURE)),
        (f"it answers echoes within less than {1e3 * setting.NARROWEST:g} ms", narrow),
        (f"it answers echoes within more than {1e3 * setting.WIDEST:g} ms", wide),
    )
    bad: dict[int, str] = {}
    for why, which in reasons:
        for k in np.flatnonzero(which).tolist():
            bad.setdefault(k, why)
    return dict(sorted(bad.items()))


def _lookup(found: Windows) -> tuple[float, ...]:
    """Delay for which each neuron stands, s: the middle of its window, of the design where it has none."""
    wanted = np.array(ranging_chip.BEST_DELAYS)
    return tuple(np.where(np.isfinite(found.middle), found.middle, wanted).tolist())


def _measured(before: Windows, after: Windows) -> Iterator[Measured]:
    for k, wanted in enumerate(ranging_chip.BEST_DELAYS):
        yield Measured(f"best_delay[{k}]", "s", wanted, float(before.middle[k]), float(after.middle[k]))
    for k in range(ranging_chip.NEURONS):
        yield Measured(f"window[{k}]", "s", setting.WIDTH, float(before.width[k]), float(after.width[k]))


def require_temperature(silicon: Silicon) -> None:
    """Raise `ParameterError`, as `chips.validity` says, at a temperature outside of the record's box."""
    known = record_of(silicon.process).grid.temperature
    require_inside("ranging_chip.temperature", silicon.temperature_c, known, "degC")


CALIBRATION = Calibration(
    NAME, "windows of the ranging chip's neurons: their width, and where they stand", AMI_1500, calibrate,
    require_temperature=require_temperature,
)  # fmt: skip
