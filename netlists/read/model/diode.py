"""Diodes: a D card and its `.model` card of type D become a `Diode`, with a `Resistor` for RS.

    Dname anode cathode MODEL [area] [AREA=] [M=]
    .model MODEL d(IS N RS CJO VJ M FC TT BV IBV NBV EG XTI TNOM)

The names are ngspice's, with their other spellings (JS, CJ0, CJ, PB, MJ, VB, IB, NZ, TREF), as are their
defaults. M diodes are one of M times the area and M times IBV. RS stands before the junction, at a node
`NAME#internal`, and is divided by area and M. A parameter of another effect (high injection, sidewalls,
recombination, tunnelling, flicker noise, temperature coefficients) is refused by name, but for the value at
which the effect is off.
"""

from __future__ import annotations

from collections.abc import Callable

from circuits.devices import Diode, Resistor
from circuits.devices.diode import BREAKDOWN_CURRENT
from circuits.errors import ParameterError
from netlists.read.card import Arguments, Card, shown
from netlists.read.foreign import REMEDY
from netlists.read.note import Notes
from netlists.read.text.name import circuit_name
from netlists.read.text.section import Model

_FIGURES = {
    "saturation_current": ("is", "js"), "emission": ("n",), "junction_capacitance": ("cjo", "cj0", "cj"),
    "junction_potential": ("vj", "pb"), "grading": ("m", "mj"), "forward_coefficient": ("fc",),
    "transit_time": ("tt",), "breakdown_voltage": ("bv", "vb", "vrb"), "breakdown_current": ("ibv", "ib"),
    "breakdown_emission": ("nbv", "nz"), "energy_gap": ("eg",), "current_exponent": ("xti",),
    "nominal_temperature_c": ("tnom", "tref"),
}  # fmt: skip
_KNOWN = {word: name for name, words in _FIGURES.items() for word in words}
_OFF = {
    "level": 1.0, "area": 1.0,
    **dict.fromkeys((
        "tlev", "tlevc", "jsw", "isw", "rsw", "pj", "trs", "trs1", "trs2", "ttt1", "ttt2", "tm1", "tm2",
        "cjp", "cjsw", "ikf", "ik", "ikr", "ikp", "cta", "ctc", "ctp", "tpb", "tvj", "tphp", "jtun",
        "jtunsw", "kf", "tcv", "tbv1", "isr", "vp", "rth0",
    ), 0.0),
}  # fmt: skip
"""Parameters of effects that are not covered, and the value at which each does nothing."""
# what has an effect only beside one of those, or none at all: limits that are watched, and who made it
_IDLE = frozenset({
    "af", "nr", "ns", "php", "vjsw", "mjsw", "fcs", "ntun", "xtitun", "keg", "gap1", "gap2", "cth0",
    "fv_max", "bv_max", "id_max", "te_max", "pd_max", "mfg", "type", "vpk", "iave", "ipk",
})  # fmt: skip
LEAST_SATURATION = 1e-28  # A, below which ngspice takes no IS
_SERIES, _AREA, _COUNT = "rs", "area", "m"
_NOTED = {"off", "pj", "perim"}

Number = Callable[[Card, str, str], float]  # value of a word of a card, and what it is of


def diode_of(
    card: Card,
    name: str,
    words: Arguments,
    model: Model,
    numbers: tuple[Number, Number],
    nominal_c: float,
    notes: Notes,
) -> tuple[Diode, Resistor | None]:
    """The diode of a card whose nodes are the circuit's, and the resistor before it.

    Parameters
    ----------
    card, name, words
        The card, the diode's name as written, and what follows it: nodes, model, area, `name=value` pairs.
    model
        Its model.
    numbers
        Give the value of a word of the card, and of one of the model.
    nominal_c
        Temperature that the figures belong to, unless the model says it, degC.
    notes
        Collects what is not taken over.

    Raises
    ------
    ForeignError
        The card or its model has what is not covered.
    """
    anode, cathode, _, *rest = words.positional
    area, count = _area(card, name, rest, words, numbers[0])
    figures, series = _figures(card, name, model, numbers[1], notes)
    figures["breakdown_current"] = count * figures.get("breakdown_current", BREAKDOWN_CURRENT)
    for key in words.named:
        if key not in _NOTED:
            raise card.foreign(f"{shown(name)}.{shown(key)}: of a diode, not covered; {REMEDY}")
        notes.add(f"{key} of a diode", card.place)
    own = circuit_name(name)
    inner = circuit_name(f"{name}#internal") if series > 0.0 else anode
    try:
        diode = Diode(
            own, inner, cathode, area, **{"nominal_temperature_c": nominal_c, **figures},
            allow_implausible=True,
        )  # fmt: skip
        if series == 0.0:
            return diode, None
        return diode, Resistor(
            circuit_name(f"{name}#rs"), anode, inner, series / area, allow_implausible=True
        )
    except ParameterError as error:
        raise card.foreign(f"{error}; or {REMEDY}") from None


def _area(card: Card, name: str, rest: list[str], words: Arguments, number: Number) -> tuple[float, float]:
    """Area of all junctions of a card, which may state it without its name, and how many there are."""
    plain = [word for word in rest if word not in _NOTED]
    given = words.named.pop(_AREA, None)
    if len(plain) > 1 or (plain and given is not None):
        raise card.error(f"{shown(name)}: {shown(plain[-1])} is not understood; write Dname a c MODEL AREA=")
    texts = {_AREA: given or (plain[0] if plain else "1"), _COUNT: words.named.pop(_COUNT, "1")}
    found = []
    for key, text in texts.items():
        value = number(card, f"{shown(name)}.{key}", text)
        if not value > 0.0:
            raise card.foreign(f"{shown(name)}.{key}: {value:g}, must be > 0; correct it")
        found.append(value)
    return found[0] * found[1], found[1]


def _figures(
    card: Card, name: str, model: Model, number: Number, notes: Notes
) -> tuple[dict[str, float], float]:
    """Figures of a model by our names, and its series resistance, Ohm."""
    found: dict[str, float] = {}
    series = 0.0
    for word, text in model.parameters.items():
        what = f"model {shown(model.name)}.{shown(word)}"
        if word in _IDLE:
            notes.add(f"{shown(word)} of a diode's model, without effect here", model.card.place)
            continue
        if word not in _KNOWN and word not in _OFF and word != _SERIES:
            raise card.foreign(f"{shown(name)}: {what}: of a diode, not covered; {REMEDY}")
        value = number(model.card, what, text)
        if word == _SERIES:
            series = value
        elif word in _KNOWN:
            found[_KNOWN[word]] = value
        elif value != _OFF[word]:
            raise card.foreign(
                f"{shown(name)}: {what}: {value:g}, not covered but for {_OFF[word]:g}; {REMEDY}"
            )
    if series < 0.0 or ("breakdown_voltage" in found and not found["breakdown_voltage"] > 0.0):
        raise card.foreign(f"{shown(name)}: model {shown(model.name)}: rs or bv below 0; {REMEDY}")
    if 0.0 < found.get("saturation_current", LEAST_SATURATION) < LEAST_SATURATION:
        what = f"is of a diode's model below {LEAST_SATURATION:g} A, taken as that as in ngspice"
        notes.add(what, model.card.place)
        found["saturation_current"] = LEAST_SATURATION
    found.setdefault("breakdown_emission", found.get("emission", 1.0))
    return found, series
