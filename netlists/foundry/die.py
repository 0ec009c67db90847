"""A die on a foundry's process: the foundry's own Monte Carlo, by the keys of `circuits.silicon.die`.

Each draw is a standard normal z of the die's key. A device's own (`v_t0` and `beta`, the keys of our process)
scale the foundry's mismatch, and come to the device as `delvto` and `mulu0`. gf180mcu draws

    sigma(delvto) = 0.7071 par_vth 1 um / sqrt(L' W'),    sigma(mulu0) = 0.7071 par_k 1 um / sqrt(L' W')
    L' = L - par_l,    W' = m (W - par_w)

with its figures in the sub-circuits of its section `fets_mm`, from where they are read here; its `par`, the
number of equal devices in parallel, is the device's multiplicity m. A positive z is a higher |V_T| or a
higher beta, as on our process. What a die shares are the foundry's numbers `mc_...` (`shared.mc_toxe` of
`foundry` in our keys), each `agauss(nominal, a, n)`, whose standard deviation is a / n; they stand in the
deck as numbers, and the foundry's own text makes the cards' parameters of them.

A package without statistics takes those of one of our processes: Pelgrom's law of a device's area, and one
shift of V_T0 and beta for each polarity, both as `delvto` and `mulu0`.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from circuits.devices import Transistor
from circuits.errors import DataError, ParameterError
from circuits.silicon.die import SHARED_PLACE, Die, shared, standard_normals
from circuits.silicon.process import POLARITIES, PROCESSES, Polarity, Process
from circuits.silicon.silicon import Deviation, Silicon
from netlists.foundry.process import DeviceMapping, section_text

FOUNDRY = "foundry"
"""What shares the foundry's numbers, in the keys and labels of their draws."""
_SHARED = "shared."
_FIGURES = ("par_vth", "par_k", "par_l", "par_w")
_LAW = ("var_k='0.7071*par_k*1e-06/p_sqrtarea'", "var_vth='0.7071*par_vth*1e-06/p_sqrtarea'",
        "p_sqrtarea='sqrt((par_leff)*(par_weff))'", "par_leff='l-par_l'", "par_weff='par*(w-par_w)'",
        "delvto='mis_vth*sw_stat_mismatch'")  # fmt: skip
_NUMBER = r"([-+.0-9eE]+)"
_TERM = re.compile(r"(\w+)\s*=\s*('[^']*'|agauss\([^)]*\)|[^\s']+)", re.IGNORECASE)
_DRAW = re.compile(rf"agauss\(\s*{_NUMBER}\s*,\s*{_NUMBER}\s*,\s*{_NUMBER}\s*\)", re.IGNORECASE)
_NAME = re.compile(r"[a-z_]\w*", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Mismatch:
    """A foundry's law of a device's own deviations.

    threshold, gain: coefficients of V_T, V m, and of beta, m. length, width: what is taken off a device's
    length and width, m.
    """

    threshold: float
    gain: float
    length: float
    width: float

    def sigma(self, width: float, length: float, multiplicity: float = 1.0) -> tuple[float, float]:
        """Standard deviation of V_T, V, and relative one of beta, of a device of this size, m."""
        root = math.sqrt((length - self.length) * multiplicity * (width - self.width))
        return self.threshold / root, self.gain / root


@dataclass(frozen=True, slots=True)
class Draw:
    """A number that a die shares: `nominal + sigma z`, in the foundry's own unit."""

    name: str
    nominal: float
    sigma: float


def subcircuit(mapping: DeviceMapping, polarity: Polarity) -> str:
    """The foundry's own text of the sub-circuit that draws a device's deviations; empty where it has none."""
    if mapping.statistics is None:
        return ""
    return _body(section_text(mapping, mapping.statistics.mismatch), mapping.models[polarity][0])


def _body(text: str, model: str) -> str:
    """A sub-circuit of a section's text; empty where there is none of that name."""
    found = re.search(rf"\.subckt\s+{re.escape(model)}\s.*?\.ends", text, re.IGNORECASE | re.DOTALL)
    return "" if found is None else found[0]


@functools.lru_cache(maxsize=8)
def mismatch_of(text: str, model: str) -> Mismatch:
    """A foundry's law of mismatch, from the text of its section and the name of a sub-circuit in it.

    Raises `DataError` where the sub-circuit is missing or says another law.
    """
    body = _body(text, model)
    packed = re.sub(r"\s+", "", body).lower()
    figures = {name: re.search(rf"\b{name}\s*=\s*{_NUMBER}", body) for name in _FIGURES}
    if not all(law in packed for law in _LAW) or not all(figures.values()):
        raise DataError(f"{model}: another law of mismatch than is known here; install another release")
    par_vth, par_k, par_l, par_w = (float(figures[name][1]) for name in _FIGURES)  # type: ignore[index]
    return Mismatch(0.7071e-6 * par_vth, 0.7071e-6 * par_k, par_l, par_w)


def law_of(mapping: DeviceMapping, polarity: Polarity) -> Mismatch:
    """The law by which devices of a process differ: the foundry's, or that of our process in its place."""
    if mapping.statistics is not None:
        return mismatch_of(section_text(mapping, mapping.statistics.mismatch), mapping.models[polarity][0])
    ours = _ours(mapping)
    return Mismatch(ours.pair_a_vt / math.sqrt(2.0), ours.pair_a_beta / math.sqrt(2.0), 0.0, 0.0)


@functools.lru_cache(maxsize=8)
def _terms(text: str) -> Mapping[str, str]:
    """Names of a section's `.param` with their expressions, in order; comments dropped."""
    lines = (line for line in text.splitlines() if not line.lstrip().startswith("*"))
    return dict(_TERM.findall(" ".join(line.strip().lstrip("+") for line in lines)))


def expressions(mapping: DeviceMapping) -> dict[str, str]:
    """The foundry's parameters of the cards of statistics, with their own text, in its order."""
    if mapping.statistics is None:
        return {}
    prefixes = tuple(f"{model}_" for model, _ in mapping.models.values())
    terms = _terms(section_text(mapping, mapping.statistics.process))
    return {name: text for name, text in terms.items() if name.startswith(prefixes)}


def draws(mapping: DeviceMapping) -> tuple[Draw, ...]:
    """The numbers that the foundry's dies share, each with its law; none for a package without statistics."""
    if mapping.statistics is None:
        return ()
    terms = _terms(section_text(mapping, mapping.statistics.process))
    used = dict.fromkeys(name for text in expressions(mapping).values() for name in _NAME.findall(text))
    found = []
    for name in used:
        text = terms.get(name, "")
        law = _DRAW.fullmatch(terms.get(text, text))
        if law is not None:
            nominal, spread, sigmas = map(float, law.groups())
            found.append(Draw(name, nominal, spread / sigmas))
    return tuple(found)


def has_process(die: Die) -> bool:
    """Whether a die draws what its devices share."""
    return die.number is not None and die.process and die.corner == "random"


def process_terms(mapping: DeviceMapping) -> dict[str, str]:
    """The foundry's own text of the numbers that a die shares, their draws among them, in its order."""
    if mapping.statistics is None:
        return {}
    terms = _terms(section_text(mapping, mapping.statistics.process))
    wanted = {each.name for each in draws(mapping)}
    wanted |= {terms[name] for name in wanted if terms[name] in terms}
    return {name: text for name, text in terms.items() if name in wanted}


def shared_numbers(mapping: DeviceMapping, die: Die) -> dict[str, float]:
    """The foundry's numbers that a die shares, by name; none for a die whose process does not vary."""
    if not has_process(die):
        return {}
    return {each.name: each.nominal + each.sigma * shared_normal(die, each.name) for each in draws(mapping)}


def shared_normal(die: Die, name: str) -> float:
    """Standard normal of one of the foundry's numbers on a die."""
    return float(standard_normals(die, SHARED_PLACE, [((FOUNDRY, ()),)], _SHARED + name)[0])


def unit_silicon(silicon: Silicon) -> Silicon:
    """The silicon whose transistors deviate by their normals over the root of their area, in m."""
    root = math.sqrt(2.0)
    return replace(silicon, process=replace(silicon.process, pair_a_vt=root, pair_a_beta=root))


def own_deviation(mapping: DeviceMapping, silicon: Silicon, device: Transistor, unit: Deviation) -> Deviation:
    """Deviation of V_T (V, of the magnitude) and of beta (relative) of a transistor on a die.

    Parameters
    ----------
    mapping
        The foundry's process.
    silicon
        The silicon, with its die.
    device
        The transistor, with its size there.
    unit
        Its deviation on `unit_silicon`.
    """
    root = math.sqrt(device.width * device.length * device.multiplicity)
    z_v, z_b = (float(np.asarray(x)) * root for x in unit)
    sigma = law_of(mapping, device.polarity).sigma(device.width, device.length, device.multiplicity)
    common = Deviation(0.0, 0.0)
    if mapping.statistics is None and silicon.die.corner == "random":
        common = Deviation(*shared(silicon.die, _ours(mapping), device.polarity))
    return Deviation(common.v_t0 + sigma[0] * z_v, (1.0 + common.beta) * (1.0 + sigma[1] * z_b) - 1.0)


def statistics_text(mapping: DeviceMapping) -> str:
    """Whose statistics a process's dies have, in a line; raises `ParameterError` where there are none."""
    if mapping.statistics is not None:
        return f"the foundry's own, of {mapping.package}"
    return f"ours, of {_ours(mapping).name}: {mapping.package} has none"


def check_die(mapping: DeviceMapping, die: Die) -> None:
    """Raise `ParameterError` for a die that the process cannot have, and for a corner that it has not."""
    corner = die.corner
    if corner != "random" and corner not in mapping.corner_names:
        raise ParameterError(f"corner: {corner}, {mapping.name} has {', '.join(mapping.corner_names)}")
    if die.number is None:
        return
    statistics_text(mapping)
    if die.variation != "plain":
        raise ParameterError(
            f"variation: {die.variation}, the statistics of {mapping.name} have no lot, wafer or gradient;"
            " leave"
            " it plain"
        )


def _ours(mapping: DeviceMapping) -> Process:
    if mapping.statistics_of not in PROCESSES:
        raise ParameterError(
            f"die: {mapping.name} has no statistics; leave the die out, or name one of our processes in the"
            " mapping's statistics_of"
        )
    return PROCESSES[mapping.statistics_of]


def foundry_labels(mapping: DeviceMapping) -> tuple[tuple[str, str], ...]:
    """Key and parameter of each draw that a die shares, as our processes have `n` and `v_t0`."""
    if mapping.statistics is None:
        return tuple((polarity, name) for polarity in POLARITIES for name in ("v_t0", "beta"))
    return tuple((FOUNDRY, each.name) for each in draws(mapping))
