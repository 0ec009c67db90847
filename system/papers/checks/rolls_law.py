"""What the full law moves in a ROLLS chip: each effect by itself, and all together.

No figure of a paper. The nominal die at 27 degC with fixed gates, whose voltages are those that the currents
of the default codes need under the same law, by the chip's own tables (`chips.rolls.tables`). In these rows
`paper` is the number under the ideal law and the rule tells how far the full law moves it; none passes or
fails. The picture has each effect alone: body effect, Early effect, mobility reduction, and leakage.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from chips.rolls.chip import STEP
from chips.rolls.circuit import Params
from chips.rolls.portrait import nominal_neuron, rates, rheobase, weight_program, weights
from chips.rolls.program.bias_file import DIRECT_CURRENT, OFF, default_biases
from chips.rolls.tables import build_tables
from circuits.silicon.process import ROLLS_180_FULL
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report, with_progress
from system.papers.checks.second_order import EFFECTS, draw_shifts, percent, with_effects
from system.rule import unjudged
from system.statement import Statement

INPUTS = (0.2e-9, 1e-9, 5e-9)  # A, ours: into a neuron, whose rates are compared
LONG = 0.2  # s, of a run
_BIASES = default_biases().with_code(DIRECT_CURRENT, *OFF)


def run(progress: Progress) -> Report:
    """Build the chip under every effect by itself, and under all."""
    ideal, *others = [measured(fields) for fields in with_progress(((), *EFFECTS.values()), progress)]
    rows = [
        Statement(
            name, value, others[-1][name], unjudged(f"moved by {percent(value, others[-1][name]):+.3g} %")
        )
        for name, value in ideal.items()
    ]
    shifts = {name: [percent(value, found[name]) for found in others] for name, value in ideal.items()}

    def draw(figure: Figure) -> None:
        draw_shifts(shifts, figure)

    return Report(tuple(rows), draw)


def measured(fields: tuple[str, ...]) -> Mapping[str, float]:
    """Return what the nominal chip is like with some fields of its process's law, the others ideal."""
    return {**of_neuron(fields), **of_synapses(fields)}


def of_neuron(fields: tuple[str, ...]) -> Mapping[str, float]:
    """Return least current, refractory period and rates of the nominal neuron under some fields."""
    neuron = nominal_neuron(_BIASES, _nominal(fields), "gate", Params())
    found = {"least_current_A": float(rheobase(neuron)[0]), "refractory_s": float(neuron.refractory[0])}
    fired = rates(neuron, np.array(INPUTS)[:, None], np.full(len(INPUTS), LONG))[:, 0]
    return found | {f"rate_at_{1e9 * i:g}_nA_Hz": float(rate) for i, rate in zip(INPUTS, fired, strict=True)}


def of_synapses(fields: tuple[str, ...]) -> Mapping[str, float]:
    """Return the pulse, the filters' time constants and the weights' charges under some fields."""
    program = weight_program(_BIASES, ())
    built = build_tables(Params(), program, "gate", _nominal(fields), STEP)
    found = {"pulse_s": float(built.lengths[0])}
    found |= {
        f"{name}_tau_s": float(f.tau[0])
        for name, f in zip(("excitatory", "inhibitory"), built.filters, strict=False)
    }
    levels = weights(built, program)
    return found | {f"charge_of_level_{w.level}_C".replace("-", "minus_"): w.charge for w in levels}


def _nominal(fields: tuple[str, ...]) -> Silicon:
    return Silicon(with_effects(ROLLS_180_FULL, fields))


EXPERIMENT = Experiment("rolls-law", "what the full law moves in a ROLLS chip", run)
