"""Power of ROLLS' cells of depression, at rest and an event, by the transistor-level solver.

    P = 256^2 P_rest + (events a second at exciting synapses) E_event

of a chip that has them at all its non-plastic synapses, three each. Both are what the depressing synapse of
`circuits.blocks.rolls.depressing_synapse` takes more than the plain one, weights off in both. P_rest is above
all I_std, which flows in every cell. E_event is the charge of the steps, which the recovery gives back, and
that of the switches' gates: the difference of runs with three and with one event, from which the cells
recover. What a depressed weight draws less is not in it, and I_rec is a bias like those of
`chips.rolls.power`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from chips.rolls.depression.program import STEP_BIAS, ShortTermDepression
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from circuits.bias import rebias
from circuits.blocks.rolls import depressing_synapse, dpi_synapse
from circuits.blocks.rolls.bias import OFF_CURRENT, current_of
from circuits.circuit import BiasKind, Circuit
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.event import pulse
from circuits.silicon.process import thermal_voltage
from circuits.silicon.silicon import Silicon
from circuits.solver.power import delivered_energy
from circuits.solver.transient import simulate

RTOL = 1e-5
COUNTS, RATE = (1, 3), 500.0  # events of two runs, and their rate, Hz; ours
REST = 10e-3  # s, of the run without events; ours
RECOVERED = 8.0  # time constants of a run behind its last event; ours


@dataclass(frozen=True, slots=True)
class DepressionEnergies:
    """rest: power of the cells of a synapse, W.

    event: their energy at an exciting event of a latched one, J.
    """

    rest: float
    event: float

    def power(self, events: float) -> float:
        """Return the power of all cells of a chip whose exciting synapses get `events` events a second, W."""
        return NEURONS * NEURONS * self.rest + events * self.event


def depression_energies(
    chosen: ShortTermDepression, table: BiasTable, silicon: Silicon, kind: BiasKind = "gate"
) -> DepressionEnergies:
    """Measure the cells of a synapse with the biases of `table`, on what the transistors of a die share."""
    on = replace(silicon, die=silicon.die.without_mismatch())
    off = {f"i_{name}": OFF_CURRENT for name in depressing_synapse.WEIGHTS}
    pulsed = off | {"i_pwlk": table.current("NPA_PWLK_P")}
    own = {"i_std": table.current(STEP_BIAS), "i_rec": current_of(chosen.recovery)}
    with_cells = rebias(depressing_synapse.build(chosen.cell), pulsed | own, kind)
    without = rebias(dpi_synapse.build(chosen.cell.synapse), pulsed, kind)
    longest = RECOVERED * _recovery(chosen, own["i_rec"], silicon)
    rest, event = (
        a - b
        for a, b in zip(_measured(with_cells, longest, on), _measured(without, longest, on), strict=True)
    )
    return DepressionEnergies(rest, event)


def _recovery(chosen: ShortTermDepression, current: float, silicon: Silicon) -> float:
    """Time constant of the recovery, s, at the process's nominal temperature."""
    u_t = thermal_voltage(silicon.process.nominal_temperature_c)
    return chosen.cell.weight_capacitance * u_t / (chosen.cell.ratio * current)


def _measured(circuit: Circuit, longest: float, silicon: Silicon) -> tuple[float, float]:
    """Power at rest, W, and energy of an event, J, of a latched exciting synapse."""
    few, many = (
        _energy(circuit, tuple(dpi_synapse.FIRST_EVENT + k / RATE for k in range(count)), longest, silicon)
        for count in COUNTS
    )
    return _energy(circuit, (), REST, silicon) / REST, (many - few) / (COUNTS[1] - COUNTS[0])


def _energy(circuit: Circuit, times: tuple[float, ...], duration: float, silicon: Silicon) -> float:
    """What all sources delivered, J."""
    v_dd = silicon.process.v_dd
    values: Mapping[str, float | None] = {"level": 1.0, "events": 1.0, "rate": RATE, "duration": duration}
    bench = dpi_synapse.testbench(circuit, values, v_dd)
    event = Source("event", "event", pulse(times, v_dd) if times else Constant(0.0))
    sources = tuple(event if s.name == "event" else s for s in bench.sources)
    return sum(delivered_energy(simulate(replace(bench, sources=sources), silicon, rtol=RTOL)).values())
