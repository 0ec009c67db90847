"""Published current-mode forms of ROLLS' synapse and neuron against the transistor circuits: how far off.

No figure of a paper. Software models print forms that differ (`chips.rolls.synapse.forms`): the synapse with
its -I_th, without, and as a jump at each spike; the neuron with a sigmoid, a power or the circuit's own law
as positive feedback, with and without -I_th, with I_ahp counted once and twice. The transistors of a synapse
are run over levels and rates of events, those of a neuron over input currents, and mean currents and rates
are compared with those of each form. Each form is given the circuit's capacitances, bias
currents, pulse and refractory period; what the circuit has no counterpart of (the sigmoid's constants) is as
published. The transistor circuit, nominal, 27 degC, default biases, decides. In these rows `paper` is what a
form gives and the rule tells how far it is off. A published form claims no accuracy, so that its rows have no
verdict; nor have those of ours that the statements below sum up.

The forms with both kappas, ours, follow from the circuit in weak inversion and have rules, written after a
first run: the synapse's is nearer to the circuit than every published one over the box (rms of the logarithm
of the mean current); the neuron's rates are within 10 % from 50 to 500 Hz. With I_ahp the form that counts it
once has to be nearer than the one that counts it twice, and so has the decay with the output's kappa to be
than that with the mean of both.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chips.rolls.circuit import Params
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import level_current
from chips.rolls.synapse import forms
from chips.rolls.synapse.forms import NeuronForm, SynapseForm
from chips.rolls.tables import prepare
from circuits.arrays import F64
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current
from circuits.solver.transient import Result, simulate
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, DASHES, INK
from system.rule import Measured, below, unjudged, within
from system.statement import Statement

LEVELS = (1, 2, 4)
TRAINS = ((10.0, 3), (100.0, 10), (1000.0, 60))  # Hz, events; ours
CURRENTS = (0.13e-9, 0.156e-9, 0.228e-9, 0.415e-9, 1.22e-9, 4e-9)  # A into the neuron; ours
AHP_AT, AHP = 0.415e-9, 30e-12  # A, ours: the input, and what is drawn from the membrane
LENGTH = 80e-3  # s, of the neuron's runs
NEURON_ALLOWED, JUDGED = 0.1, (50.0, 500.0)  # and Hz
OURS = "both kappas"
PUBLISHED = "a published form, which claims no accuracy"
OURS_LOOK = 4  # of colours and dashes; those before it are the others'

Train = Callable[[SynapseForm, float, float, int], float]
SYNAPSES: Mapping[str, Train] = {
    "full": lambda s, w, f, n: forms.synapse_train(s, forms.synapse_full, w, f, n)[1],
    "linear": lambda s, w, f, n: forms.synapse_train(s, forms.synapse_linear, w, f, n)[1],
    "jump": lambda s, _, f, n: forms.synapse_jumps(s, f, n)[1],
    OURS: lambda s, w, f, n: forms.synapse_train(s, forms.synapse_pair, w, f, n)[1],
}
NEURONS: Mapping[str, Callable[[NeuronForm, float], forms.Growth]] = {
    "sigmoid feedback": lambda n, i: forms.neuron_published(n, forms.feedback_sigmoid(n), i),
    "power feedback": lambda n, i: forms.neuron_published(n, forms.feedback_power(n), i),
    "linear feedback": lambda n, i: forms.neuron_published(n, forms.feedback_linear(n), i),
    "no I_th": lambda n, i: forms.neuron_without_threshold(n, forms.feedback_linear(n), i),
    OURS: lambda n, i: forms.neuron_pair(n, forms.feedback_linear(n), i),
}


def run(progress: Progress) -> Report:
    """Measure a synapse over levels and rates, and a neuron over currents into and out of its membrane."""
    means, trains, decay = _synapses(progress)
    rates, curves, refractory = _neurons(progress)
    rows = [
        _beside(
            f"synapse_mean_{name}_level{level}_{rate:g}Hz_A",
            found[k],
            float(means[k]),
            "judged over the box" if name == OURS else PUBLISHED,
        )
        for name, found in trains.items()
        for k, (level, rate) in enumerate((a, b) for a in LEVELS for b, _ in TRAINS)
    ]
    rows.append(_nearest(means, trains))
    capacitance = prepare(Params(), ROLLS_180_IDEAL).filters[0][0]
    filter_ = forms.circuit_synapse(1.0, capacitance)
    both = 0.5 * (ROLLS_180_IDEAL.n.kappa + ROLLS_180_IDEAL.p.kappa)
    mean = filter_.tau * ROLLS_180_IDEAL.p.kappa / both
    nearer = below(abs(mean - decay), "nearer than the mean kappa's").beside(_off(filter_.tau, decay))
    rows.append(_beside("synapse_decay_mean_kappa_s", mean, decay))
    ours = Measured(abs(filter_.tau - decay), decay)
    rows.append(Statement("synapse_decay_output_kappa_s", filter_.tau, ours, nearer))
    for name, found in curves.items():
        for current, ours, theirs in zip(CURRENTS, rates, found, strict=True):
            rows.append(_rate_row(name, current, float(ours), float(theirs)))
    own = "the rates take the circuit's own"
    rows.append(_beside("neuron_refractory_period_s", _neuron_form().refractory, refractory, own))
    rows += _ahp_rows()
    progress(1.0)
    notes = ("`paper` is what a form gives with the circuit's own parameters; `ours` is the circuit.",)
    return Report(tuple(rows), lambda figure: _draw(means, trains, rates, curves, figure), notes)


def _silicon() -> Silicon:
    return Silicon(ROLLS_180_IDEAL)


def _synapses(progress: Progress) -> tuple[F64, dict[str, F64], float]:
    """Mean currents of the circuit and of each form over the box, A, and the circuit's decay, s."""
    capacitance = prepare(Params(), ROLLS_180_IDEAL).filters[0][0]
    means, found, decay = [], [], 0.0
    for level in LEVELS:
        form = forms.circuit_synapse(level_current(default_biases(), level), capacitance)
        for rate, events in TRAINS:
            result = _train(level, rate, events)
            last = result.time >= dpi_synapse.FIRST_EVENT + (events - 1) / rate
            current = np.abs(drain_current(result, "excitatory.md5"))
            means.append(rate * float(np.trapezoid(current[last], result.time[last])))
            measured = dpi_synapse.measures(result)
            width = measured["pulse_width_s"] or 0.0
            found.append([train(form, width, rate, events) for train in SYNAPSES.values()])
            # of the largest current that leaves the output in weak inversion
            decay = measured["decay_s"] or decay if level == LEVELS[0] else decay
        progress(0.2 * len(means) / len(TRAINS))
    return np.array(means), dict(zip(SYNAPSES, np.array(found).T, strict=True)), decay


def _train(level: int, rate: float, events: int) -> Result:
    values = dpi_synapse.BLOCK.defaults | {
        "level": float(level), "events": float(events), "rate": rate,
        "duration": dpi_synapse.FIRST_EVENT + events / rate,
    }  # fmt: skip
    bench = dpi_synapse.testbench(dpi_synapse.build(), values, ROLLS_180_IDEAL.v_dd)
    return simulate(bench, _silicon(), rtol=1e-6)


def _neuron_form() -> NeuronForm:
    return forms.circuit_neuron(float(prepare(Params(), ROLLS_180_IDEAL).neuron[0, 0]))


def _neurons(progress: Progress) -> tuple[F64, dict[str, F64], float]:
    """Rates of the circuit and of each form, Hz, and the circuit's refractory period, s."""
    form = _neuron_form()
    rates, period = [], 0.0
    for k, current in enumerate(CURRENTS):
        result = _neuron(current, 0.0)
        rates.append(_rate(result))
        period = _reset(result) if rates[-1] else period
        progress(0.6 + 0.3 * (k + 1) / len(CURRENTS))
    # the circuit's own period, so that the curves differ by the membrane alone
    own = replace(form, refractory=period)
    curves = {
        name: np.array([forms.rate_of(own, growth(own, i)) for i in CURRENTS])
        for name, growth in NEURONS.items()
    }
    return np.array(rates), curves, period


def _neuron(current: float, drawn: float) -> Result:
    values = rolls_neuron.BLOCK.defaults | {
        "current": current,
        "duration": LENGTH,
    }
    bench = rolls_neuron.testbench(rolls_neuron.build(), values, ROLLS_180_IDEAL.v_dd)
    if drawn:
        source = Source("i_ahp", "v_mem", Constant(-drawn), "current")
        bench = replace(bench, sources=(*bench.sources, source))
    return simulate(bench, _silicon(), rtol=1e-7)


def _rate(result: Result) -> float:
    spikes = result.spikes["spike"]
    return 1.0 / float(spikes[-1] - spikes[-2]) if spikes.size > 1 else 0.0


def _reset(result: Result) -> float:
    """From the first spike to where the membrane is let go, s."""
    spike = float(result.spikes["spike"][0])
    after = result.time > spike
    held = result["reset.k2"][after] > 0.5 * ROLLS_180_IDEAL.v_dd
    first = int(held.argmax())
    return float(result.time[after][first + int((~held[first:]).argmax())] - spike)


def _ahp_rows() -> list[Statement]:
    """Rates with I_ahp drawn from the membrane: circuit, form that counts it once, and twice."""
    ours = _rate(_neuron(AHP_AT, AHP))
    form = replace(_neuron_form(), refractory=_reset(_neuron(AHP_AT, 0.0)))
    feedback = forms.feedback_linear(form)
    once = forms.rate_of(form, forms.neuron_pair(form, feedback, AHP_AT, AHP))
    twice = forms.rate_of(form, forms.neuron_pair(form, feedback, AHP_AT - AHP, AHP))
    rule = below(abs(twice - ours), "nearer than the form that counts it twice").beside(_off(once, ours))
    return [
        Statement("neuron_rate_ahp_once_Hz", once, Measured(abs(once - ours), ours), rule),
        _beside("neuron_rate_ahp_twice_Hz", twice, ours),
    ]


def _beside(name: str, form: float, circuit: float, why: str = PUBLISHED) -> Statement:
    """A form's value beside the circuit's; nothing is judged, and `why` tells the reason."""
    return Statement(name.replace(" ", "_"), float(form), circuit, unjudged(f"{_off(form, circuit)}; {why}"))


def _off(form: float, circuit: float) -> str:
    if not circuit:
        return "silent" if form else "both silent"
    return f"off by {100.0 * (form / circuit - 1.0):+.3g} %"


def _rate_row(name: str, current: float, circuit: float, form: float) -> Statement:
    label = f"neuron_rate_{name}_{1e9 * current:.3g}nA_Hz"
    if name != OURS or not JUDGED[0] <= circuit <= JUDGED[1]:
        why = f"outside {JUDGED[0]:g} to {JUDGED[1]:g} Hz" if name == OURS else PUBLISHED
        return _beside(label, form, circuit, why)
    rule = within(NEURON_ALLOWED, f"{_off(form, circuit)}; within {{percent:g}} %", of=1.0)
    return Statement(label.replace(" ", "_"), form, Measured(form / circuit, circuit), rule)


def _nearest(means: F64, trains: Mapping[str, F64]) -> Statement:
    error = {name: float(np.sqrt(np.mean(np.log(x / means) ** 2))) for name, x in trains.items()}
    best = min(v for name, v in error.items() if name != OURS)
    rule = below(best, "rms of ln over the box, below the best published form's {limit:.3g}")
    return Statement("synapse_rms_of_both_kappas", None, error[OURS], rule)


def _draw(
    means: F64, trains: Mapping[str, F64], rates: F64, curves: Mapping[str, F64], figure: Figure
) -> None:
    """Mean output of the synapse, a panel a level, and rate of the neuron."""
    figure.set_size_inches(8.4, 6.6)
    grid, count = figure.add_gridspec(2, len(LEVELS)), len(TRAINS)
    at, panels = [rate for rate, _ in TRAINS], [figure.add_subplot(grid[0, j]) for j in range(len(LEVELS))]
    for j, (ax, level) in enumerate(zip(panels, LEVELS, strict=True)):
        part = slice(j * count, (j + 1) * count)
        ax.sharey(panels[0])
        _forms(at, means[part], {name: found[part] for name, found in trains.items()}, ax)
        ax.set(xscale="log", yscale="log", xlabel="events (Hz)")
        ax.set_title(f"synapse, level {level}", fontsize=9)
        ax.set_ylabel("" if j else "mean output (A)")
        ax.tick_params(axis="y", labelleft=not j)
    panels[-1].legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), fontsize=8)
    ax = figure.add_subplot(grid[1, :])
    _forms(1e9 * np.array(CURRENTS), rates, curves, ax)
    ax.set(xscale="log", xlabel="input current (nA)", ylabel="rate (Hz)")
    ax.set_title("neuron", fontsize=9)
    ax.set_xticks((0.2, 0.5, 1.0, 2.0, 4.0), ("0.2", "0.5", "1", "2", "4"))
    ax.minorticks_off()
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8)


def _forms(at: Sequence[float] | F64, circuit: F64, found: Mapping[str, F64], ax: Axes) -> None:
    """Forms as lines, ours in one colour wherever it stands, and the circuit as marks over them."""
    for number, (name, values) in enumerate(found.items()):
        k = OURS_LOOK if name == OURS else number
        ax.plot(at, values, color=COLOURS[k], linestyle=DASHES[k % len(DASHES)], label=name, linewidth=1.4)
    ax.plot(at, circuit, color=INK, marker="o", markersize=5, linestyle="", label="circuit")


EXPERIMENT = Experiment("rolls-forms", "published forms of ROLLS' circuits, and by how much each is off", run)
