"""The cards of a netlist that are about a run.

`.tran`, `.op`, `.dc`, `.ac`, `.noise`, `.step`, `.ic`, `.nodeset`, `.temp`, `.options` and `.measure` are
taken over; others are only noted.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from netlists.read.card import Card, ForeignError, arguments, shown
from netlists.read.expression.scope import Scope
from netlists.read.measure import Measured, Untranslated, measured_of
from netlists.read.note import Notes
from netlists.read.waveform import Span

_VOLTAGE = re.compile(r"v\s*\(\s*([^\s(),]+)\s*\)\s*=\s*('[^']*'|\{[^{}]*\}|[^\s,]+)")
_NOISE = re.compile(r"v\s*\(\s*(?P<node>[^\s(),]+)\s*(?:[\s,]\s*(?P<reference>[^\s(),]+)\s*)?\)")
_OUTPUT = {".save", ".print", ".plot", ".probe", ".four", ".width", ".post", ".graph", ".csparam", ".title"}
_OTHER = {".disto", ".pz", ".sens", ".tf", ".sp", ".pss", ".hb"}
VARIED = frozenset({".step", ".data", ".mc"})  # several circuits in one netlist; ngspice has none of them
_ONE_CIRCUIT = (
    "one netlist is one circuit, here and in ngspice: take the card out, and step sources, temperature,"
    " parameters or dies with noctule sweep"
)
_MEASURES = frozenset({".meas", ".measure"})
TEMPERATURE = "temp"  # what `.dc` and `.step` call it
_MOST_STEPS = 100_000  # values of a card; ours
# options about output, convergence and accuracy; any other is taken to be about the circuit
_NUMERICAL = {
    "acct", "noacct", "list", "nolist", "node", "nonode", "opts", "noopts", "page", "nopage", "nomod",
    "noinit", "noopiter", "brief", "post", "probe", "ingold", "captab", "statfl", "numdgt", "measdgt",
    "measform", "measfail", "co", "csdf", "unwrap", "search", "interp", "klu", "sparse", "savecurrents",
    "keepopinfo", "trytocompact", "autostop", "warn", "maxwarns", "seed", "reltol", "abstol", "vntol",
    "chgtol", "trtol", "pivrel", "pivtol", "gmin", "gmindc", "gminsteps", "srcsteps", "gramp", "dcon",
    "converge", "convstep", "cshdc", "itl1", "itl2", "itl3", "itl4", "itl5", "itl6", "limpts", "limtim",
    "cptime", "method", "maxord", "lvltim", "delmax", "rmin", "rmax", "imin", "imax", "ft", "absv", "absvar",
    "relv", "relvar", "absi", "reli", "relq", "absh", "relh", "absmos", "relmos", "fast", "accurate",
    "runlvl", "bypass", "dvdt", "dvtr", "mu", "xmu", "timeres", "tnom", "device", "timeint", "nonlin",
    "linsol", "output", "save", "rawfmt", "vabstol", "iabstol", "gmin_stepping", "errpreset",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Transient:
    """A transient that a netlist asks for: `.tran step stop [start [max_step]] [uic]`.

    step: interval of printed points, s. stop: end of the run, s. start: time from which points are kept, s.
    max_step: largest step of the solver, s; None where the card has none. uic: whether the run begins with
    given voltages instead of an operating point.
    """

    step: float
    stop: float
    start: float = 0.0
    max_step: float | None = None
    uic: bool = False


@dataclass(frozen=True, slots=True)
class OperatingPoint:
    """An operating point, `.op`."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """A sweep of one or two sources that a netlist asks for: `.dc source start stop step`.

    Attributes
    ----------
    sources : tuple of str
        Names of the sources, the innermost first.
    start, stop, step : tuple of float
        First value, last value and step of each source, V or A.
    """

    sources: tuple[str, ...]
    start: tuple[float, ...]
    stop: tuple[float, ...]
    step: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Stepped:
    """What a netlist steps: `.step [lin|dec|oct] [param] NAME FIRST LAST BY`, or `[param] NAME list A B ...`.

    Attributes
    ----------
    name : str
        Name of the source or parameter, or `temp`.
    values : tuple of float
        Its values, V, A, degC or in the parameter's unit.
    place : str
        `file:line` of the card.
    is_parameter : bool
        Whether it is a parameter.
    """

    name: str
    values: tuple[float, ...]
    place: str
    is_parameter: bool = False


@dataclass(frozen=True, slots=True)
class SmallSignals:
    """Small signals that a netlist asks for: `.ac dec|oct|lin points low high`.

    scale: `dec`, `oct` or `lin`. points: frequencies a decade, an octave, or in all. low, high: first and
    last frequency, Hz.
    """

    scale: str
    points: int
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class NoiseSpectrum:
    """Noise that a netlist asks for: `.noise v(output[, reference]) source dec|oct|lin points low high`.

    output, reference: nodes between which the noise is taken, as written, and of a netlist that has been read
    their paths; `0` is ground. source: name of the
    source that it is referred to. spectrum: its frequencies.
    """

    output: str
    reference: str
    source: str
    spectrum: SmallSignals


Given = dict[str, tuple[float, Card]]  # a voltage, V, and the card that states it, by the node's name
Analysis = Transient | OperatingPoint | Sweep | SmallSignals | NoiseSpectrum


@dataclass(slots=True)
class Controls:
    """What the cards about a run say.

    analyses, measures, steps: what is run, measured and stepped, each in the order of the cards. starts,
    held: voltages, V, of `.nodeset` and `.ic`, with their card, by the node's name as it is written.
    temperature_c, nominal_c: temperature, and the one that the figures of models belong to, degC; None where
    no card states it.
    """

    analyses: list[Analysis] = field(default_factory=list)
    measures: list[Measured] = field(default_factory=list)
    steps: list[Stepped] = field(default_factory=list)
    starts: Given = field(default_factory=dict)
    held: Given = field(default_factory=dict)
    temperature_c: float | None = None
    nominal_c: float | None = None

    @property
    def transient(self) -> Transient | None:
        """The first transient."""
        return next((each for each in self.analyses if isinstance(each, Transient)), None)

    @property
    def span(self) -> Span:
        """Of the first transient."""
        first = self.transient
        return Span() if first is None else Span(first.step, first.stop)

    @property
    def uic(self) -> bool:
        """Whether the first transient begins without an operating point."""
        first = self.transient
        return first is not None and first.uic


def read_controls(cards: Iterable[Card], scope: Scope, notes: Notes) -> Controls:
    """Read the cards about a run; raises `DataError` for one that nobody knows."""
    controls, measures = Controls(), list[Card]()
    for card in cards:
        if card.name() in _MEASURES:  # which follow the transient, wherever that stands
            measures.append(card)
            continue
        try:
            _read_control(controls, card, scope, notes)
        except ForeignError as error:
            notes.keep(card, error)
    begin = 0.0 if controls.transient is None else controls.transient.start
    for card in measures:
        _measure(controls, card, scope, notes, begin)
    return controls


def _read_control(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    word = card.name()
    if word in _READERS:
        _READERS[word](controls, card, scope, notes)
    elif word in _OUTPUT:
        notes.add(f"{word} card", card.place)
    elif word in _OTHER:
        notes.add(f"{word} analysis", card.place)
    elif word in VARIED:
        notes.leave_out(card, word, word, _ONE_CIRCUIT)
    else:
        raise card.error(
            f"{shown(word)}: unknown card; write one of {', '.join(sorted({*_READERS, *_MEASURES}))}"
        )


def _transient(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    words = [w for w in card.words()[1:] if w != "uic"]
    uic = len(words) + 1 < len(card.words())
    if not 2 <= len(words) <= 4:
        raise card.error(f".tran: {len(words)} numbers, must be 2 to 4; write .tran STEP STOP")
    values = [scope.number(card, ".tran", w) for w in words]
    if not min(values[:2]) > 0.0:
        raise card.error(f".tran: step {values[0]:g} s, stop {values[1]:g} s, must be > 0; correct them")
    times: dict[str, float] = dict(zip(("step", "stop", "start", "max_step"), values, strict=False))
    controls.analyses.append(Transient(**times, uic=uic))


def _operating_point(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    controls.analyses.append(OperatingPoint())


def _sweep(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    words = [w for w in card.words()[1:] if w not in {"(", ")"}]
    if len(words) not in {4, 8}:
        raise card.error(f".dc: {len(words)} words, must be 4 or 8; write .dc SOURCE START STOP STEP")
    columns = [[scope.number(card, ".dc", w) for w in words[k::4]] for k in (1, 2, 3)]
    start, stop, step = map(tuple, columns)
    controls.analyses.append(Sweep(tuple(words[0::4]), start, stop, step))


def _step(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    """A step of a source, the temperature or a parameter; one of anything else would be another circuit."""
    words = [w for w in card.words()[1:] if w not in {"(", ")"}]
    way = words.pop(0) if words[:1] and words[0] in {"lin", "dec", "oct"} else "lin"
    is_parameter = words[:1] == ["param"]
    words = words[is_parameter:]
    if not words or not (is_parameter or words[0] == TEMPERATURE or words[0][0] in "vi"):
        notes.leave_out(card, ".step", ".step of a device or a model", _ONE_CIRCUIT)
        return
    if ".step" in notes.drop:
        notes.leave_out(card, ".step", ".step", _ONE_CIRCUIT)
        return
    name, *rest = words
    if rest[:1] == ["list"]:
        values = [scope.number(card, ".step", w) for w in rest[1:]]
    elif len(rest) == 3:
        values = _stepped(card, way, *(scope.number(card, ".step", w) for w in rest))
    else:
        values = []
    if not values:
        raise card.error(".step: no values; write .step NAME FIRST LAST BY, or .step NAME list A B ...")
    controls.steps.append(Stepped(name, tuple(dict.fromkeys(values)), card.place, is_parameter))


def stepped_parameters(cards: Iterable[Card], scope: Scope) -> dict[str, float]:
    """The first value of each parameter that cards step, which it has where nothing else gives it one."""
    found = Controls()
    for card in cards:
        if card.name() == ".step" and "param" in card.words():
            _step(found, card, scope, Notes())
    return {step.name: step.values[0] for step in found.steps if step.is_parameter}


def _stepped(card: Card, way: str, first: float, last: float, by: float) -> list[float]:
    """Values of a step; of `dec` and `oct` the last number is how many there are a decade or octave."""
    base = {"dec": 10.0, "oct": 2.0}.get(way)
    if base is None:
        count = (last - first) / by if by else -1.0
    else:
        rises = first > 0.0 and last >= first and by >= 1.0
        count = by * math.log(last / first, base) if rises else -1.0
    if not 0.0 <= count < _MOST_STEPS:
        raise card.error(
            f".step: from {first:g} to {last:g} by {by:g}, must lead there in {_MOST_STEPS} steps; mend it"
        )
    places = range(int(count + 1e-9) + 1)
    return [first + k * by if base is None else first * base ** (k / by) for k in places]


def _spectrum(card: Card, word: str, words: list[str], scope: Scope) -> SmallSignals:
    if len(words) != 4 or words[0] not in {"dec", "oct", "lin"}:
        raise card.error(
            f"{word}: {shown(' '.join(words))}, must be dec, oct or lin, POINTS LOW HIGH; correct it"
        )
    points, low, high = (scope.number(card, word, w) for w in words[1:])
    if not (points >= 1.0 and 0.0 <= low <= high):
        raise card.error(
            f"{word}: {points:g} points from {low:g} to {high:g} Hz; give 1 or more, of rising ends"
        )
    return SmallSignals(words[0], int(points), low, high)


def _small_signals(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    controls.analyses.append(_spectrum(card, ".ac", card.words()[1:], scope))


def _noise(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    rest = card.text.lower().partition(" ")[2].strip()
    found = _NOISE.match(rest)
    words = rest[found.end() :].split() if found else []
    if found is None or len(words) not in {5, 6}:
        raise card.error(".noise: must be v(NODE) SOURCE dec POINTS LOW HIGH; correct it")
    spectrum = _spectrum(card, ".noise", words[1:5], scope)
    controls.analyses.append(NoiseSpectrum(found["node"], found["reference"] or "0", words[0], spectrum))


def _measure(controls: Controls, card: Card, scope: Scope, notes: Notes, begin: float) -> None:
    try:
        controls.measures.append(measured_of(card, scope, begin))
    except ForeignError as error:
        notes.keep(card, error)
    except Untranslated as why:
        notes.add(f"{card.name()} card that is not taken over, {why}", card.place)


def _voltages(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    into = controls.held if card.name() == ".ic" else controls.starts
    into |= voltages_of(card, scope)


def voltages_of(card: Card, scope: Scope) -> Given:
    """Voltages of a card `.ic` or `.nodeset`, V, by the node's name as it is written; raises `DataError`."""
    word, _, rest = card.text.lower().partition(" ")
    found = _VOLTAGE.findall(rest)
    if not found or _VOLTAGE.sub("", rest).strip(" ,\t"):
        raise card.foreign(f"{word}: must be v(node)=value ...; correct it")
    return {node: (scope.number(card, f"v({shown(node)})", value), card) for node, value in found}


def _temperature(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    words = card.words()
    if len(words) != 2:
        error = card.error if len(words) < 2 else card.foreign
        raise error(f".temp: {len(words) - 1} numbers, must be one; write .temp DEGC")
    controls.temperature_c = scope.number(card, ".temp", words[1])


def _options(controls: Controls, card: Card, scope: Scope, notes: Notes) -> None:
    given = arguments(card, card.words()[1:])
    if "temp" in given.named:
        controls.temperature_c = scope.number(card, "temp", given.named["temp"])
    if "tnom" in given.named:
        controls.nominal_c = scope.number(card, "tnom", given.named["tnom"])
    for name in (*given.positional, *(n for n in given.named if n != "temp")):
        try:
            read_option(name, card, notes)
        except ForeignError as error:
            notes.keep(card, error)


def read_option(name: str, card: Card, notes: Notes) -> None:
    """Note an option of the run; raises `DataError` for one about the circuit unless it may go."""
    if name in _NUMERICAL:
        notes.add(f"option {shown(name)}", card.place)
    else:
        notes.leave_out(card, name, f"option {shown(name)}", "write what it sets into the elements")


_Reader = Callable[[Controls, Card, Scope, Notes], None]
_READERS: Mapping[str, _Reader] = {
    ".tran": _transient, ".op": _operating_point, ".dc": _sweep, ".ic": _voltages, ".nodeset": _voltages,
    ".ac": _small_signals, ".noise": _noise, ".temp": _temperature,
    ".step": _step, ".options": _options, ".option": _options, ".opt": _options,
}  # fmt: skip
