"""Where a ROLLS chip's model holds: within what its parts were held against their transistors.

| part | at | error |
|---|---|---|
| synapse, mean current, 5 dies, all levels | 0, 27, 60 degC, 1 Hz to 1 kHz | 2.1 % |
| neuron, rate, 20 dies | 0, 27, 60 degC | 0.8 % |
| sum of a filter's inputs, levels up to `STRONGEST` | 0, 27, 60 degC | 4 % |
| depression, charge of an event, 5 dies | 0, 27, 60 degC, steps up to `DEEPEST` | 0.4 % |
| spikes at steps of 0.4 ms, direct currents, die 1000 | 34 to 1220 Hz | 0.3 % |
| spikes at steps of 0.4 ms, bursts of the default drive, die 1000 | less than a step between | 0.5 % |
| plastic array, its weights | 0, 27, 50 degC | 10 mV rms, 115 mV where leaks shift its drift |

Spikes at a step are held against those at 0.01 and 0.005 ms. Single synapses and neurons are as near
further out (ours: three dies, both kinds of biases, within 1.5 % and 0.4 % from -20 to 85 degC), but whole
filters were not looked at there.
"""

from __future__ import annotations

from chips.rolls.depression.state import DEEPEST_MEASURED, LEAST_MEASURED
from chips.rolls.program.bias_file import DIRECT_CURRENT
from chips.rolls.program.program import Program
from chips.rolls.tables import Built
from chips.validity import require_inside
from circuits.arrays import Bools
from circuits.silicon.process import ROLLS_180_IDEAL, Process
from circuits.silicon.silicon import Silicon

PATH = "rolls_chip"
TEMPERATURES = (0.0, 60.0)  # degC
LEARNING_TEMPERATURES = (0.0, 50.0)  # degC, of a chip with a plastic array
STRONGEST = 0.2  # inversion coefficient of a filter's pair up to which errors stay below 4 %
FASTEST_INPUT = 1e3  # Hz, of events at a synapse
_NO_OTHER = "stay within"


def require_temperature(silicon: Silicon) -> None:
    """Raise `ParameterError`, as `chips.validity` says, for silicon outside the box of every program."""
    require_inside(f"{PATH}.temperature", silicon.temperature_c, TEMPERATURES, "degC", _NO_OTHER)


def check_temperature_of(program: Program, temperature_c: float) -> None:
    """Raise `ParameterError`, as `chips.validity` says, for a temperature (degC) outside the box."""
    limits = TEMPERATURES if program.plastic is None else LEARNING_TEMPERATURES
    require_inside(f"{PATH}.temperature", temperature_c, limits, "degC", _NO_OTHER)


def check_box(built: Built) -> None:
    """Raise `ParameterError`, as `chips.validity` says, for a program whose tables are outside the box."""
    for level in built.levels:
        strength = inversion(built, level)
        side = f"{PATH}.synapse.level[{level}].inversion"
        require_inside(side, strength, (0.0, STRONGEST), "", "take a smaller weight")
    if built.depression is None:
        return
    deepest = float(built.depression.step.max() / built.depression.u_t)
    remedy = "lower the step of the depression"
    require_inside(f"{PATH}.depression.step", deepest, (0.0, DEEPEST_MEASURED), "U_T", remedy)
    for level, current in built.levels.items():
        if level > 0 and current > 0.0:
            side = f"{PATH}.depression.level[{level}]"
            require_inside(side, current, (LEAST_MEASURED, float("inf")), "A", "raise the weight")


def check_supply(process: Process) -> None:
    """Raise `ParameterError`, as `chips.validity` says, for another supply than that of the comparison."""
    require_inside(f"{PATH}.supply", process.v_dd, (ROLLS_180_IDEAL.v_dd,), "V", _NO_OTHER)


def check_rate(rate: float) -> None:
    """Raise `ParameterError`, as `chips.validity` says, for events faster than any that were held.

    rate: of the events at one synapse, Hz.
    """
    require_inside(f"{PATH}.input_rate", rate, (0.0, FASTEST_INPUT), "Hz", _NO_OTHER)


def inversion(built: Built, level: int) -> float:
    """Return the mean current of a level over the specific current of its filter's pair."""
    return built.levels[level] / float(built.filters[0 if level > 0 else 1].pair.mean())


def restless_cautions(restless: Bools) -> tuple[str, ...]:
    """Return a sentence on the neurons that fire without input, bool[256], if there are any."""
    if not restless.any():
        return ()
    count = f"{int(restless.sum())} of {restless.size}"
    remedy = f"turn {DIRECT_CURRENT} down, fine code 0 is off, or raise the leaks IF_TAU1_N and IF_TAU2_N"
    return (f"neurons: {count} fire without any input; {remedy}",)


def cautions_of(built: Built, step: float) -> tuple[str, ...]:
    """Return, in sentences, where tables are outside of what steps of `step` s were measured for."""
    found = []
    longest = float(built.lengths.max())
    if longest > step:
        found.append(
            f"extender: pulses of up to {longest:.3g} s are longer than a step of {step:g} s, and taken at"
            " once; raise NPA_PWLK_P, or the step"
        )
    for level, current in built.levels.items():
        strength = inversion(built, level)
        if strength > STRONGEST:
            found.append(
                f"synapse: level {level} draws {current:.3g} A, {strength:.2g} of its pair's specific"
                f" current; measured up to {STRONGEST:g}; take a smaller weight"
            )
    return tuple(found)
