"""The testbench by which a block is compared: its sizes, stimuli and biases, scaled to the silicon.

At a fixed gate voltage a weak current moves tenfold and more between -20 and 85 degC, and from one die to the
next; a delay that such a current sets moves with it. A run that is to show anything at another temperature
therefore gets its delays in the ratio of the block's own (`delay_ratio`), or the block has ideal
biases, whose currents follow the temperature alone (`Form.kind`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from circuits.bias import rebias
from circuits.blocks.block import Block
from circuits.circuit import GROUND, BiasKind, Circuit
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

_GLANCE = 1e-3  # share of a run that tells which measures a block has


@dataclass(frozen=True, slots=True)
class Form:
    """How a block is set up to be compared; as it stands, unless something else is said.

    Attributes
    ----------
    params
        Sizes and capacitors by name, in the units of the block's `Params`.
    stimuli
        Stimuli by name, in their own units; None is off.
    kind
        Kind of all current biases; None leaves each its own.
    stop
        The run ends at this time at the latest, s; None lets it run to the testbench's own end.
    """

    params: Mapping[str, float] = field(default_factory=dict)
    stimuli: Mapping[str, float | None] = field(default_factory=dict)
    kind: BiasKind | None = None
    stop: float | None = None


AS_IT_STANDS = Form()


def scaled_testbench(block: Block, silicon: Silicon, form: Form = AS_IT_STANDS) -> Testbench:
    """Make the testbench of a block, its delay scaled to the silicon.

    A block that measures `t_inh_s` has delays that follow it: `delay` is multiplied by `delay_ratio`, pulse
    widths stay, and the run gets longer by that ratio where it is above 1; so does the run of a block that
    measures its own `delay_s`. Other blocks keep their stimuli. `form` says how the block is set up.
    """
    circuit, v_dd = _circuit(block, form), silicon.process.v_dd
    stimuli = _stimuli(block, form)
    nominal = block.testbench(circuit, stimuli, v_dd)
    ratio = delay_ratio(block, silicon, form)
    if ratio != 1.0:
        if "delay" in stimuli:
            stimuli["delay"] = ratio * (stimuli["delay"] or 0.0)
        if ratio > 1.0:
            stimuli["duration"] = ratio * nominal.stop
        nominal = block.testbench(circuit, stimuli, v_dd)
    return nominal if form.stop is None else replace(nominal, stop=min(nominal.stop, form.stop))


def started(testbench: Testbench, silicon: Silicon) -> Testbench:
    """The testbench with the solver's rest state as ngspice's start, which saves it minutes on a chip.

    ngspice still solves for its own; that it is the same without the start is for `engine.operating_point`.
    """
    rest = operating_point(testbench, silicon, time=0.0).voltages()
    return replace(testbench, start={node: v for node, v in rest.items() if node != GROUND})


def delay_ratio(block: Block, silicon: Silicon, form: Form = AS_IT_STANDS) -> float:
    """Delay of a block on the silicon over that of the nominal block at 27 degC.

    The delay is the block's t_inh after a call alone, or its `delay_s`; 1 for a block that has neither.
    """
    nominal = _delay(block, Silicon(silicon.process), form)
    here = _delay(block, silicon, form)
    return 1.0 if nominal is None or here is None else here / nominal


def _delay(block: Block, silicon: Silicon, form: Form) -> float | None:
    """The block's delay, s, from the first of ever longer runs that has it; None without one."""
    stimuli = _stimuli(block, form)
    if "duration" not in stimuli:
        return None
    circuit, v_dd = _circuit(block, form), silicon.process.v_dd
    name = "t_inh_s" if "echo" in stimuli else "delay_s"
    if "echo" in stimuli:
        stimuli["echo"] = None
    bench = block.testbench(circuit, stimuli, v_dd)
    if name not in block.measures(simulate(replace(bench, stop=_GLANCE * bench.stop), silicon)):
        return None
    for factor in (1.0, 4.0, 16.0, 64.0):
        stimuli["duration"] = factor * bench.stop
        found = block.measures(simulate(block.testbench(circuit, stimuli, v_dd), silicon))[name]
        if found is not None:
            return found
    return None


def _circuit(block: Block, form: Form) -> Circuit:
    return rebias(block.build(block.params(**form.params)), kind=form.kind)


def _stimuli(block: Block, form: Form) -> dict[str, float | None]:
    return block.defaults | dict(form.stimuli)
