"""The verb `noctule export rolls --at row[5] --program FILE`: a neuron of a die with its latched synapses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from chips.rolls.cut import Cut, cut_row, silicon_of
from chips.rolls.cut import testbench as bench_of
from circuits.blocks.block import Stimulus
from circuits.blocks.rest import started_at_rest
from circuits.circuit import split_reference
from circuits.count import pulse_count
from circuits.devices.source import Waveform
from circuits.errors import ParameterError, SolverError, TopologyError
from circuits.event import pulse
from circuits.lowering.flatten import flatten
from circuits.silicon.process import ROLLS_180, Process
from circuits.testbench import Testbench
from netlists.registry import load_dialect
from system.cli.netlist_output import leave_netlist, settings_of
from system.cli.rolls_program_file import read_program
from system.cli.verbs import Export
from system.mapping.network_file import SUFFIX
from system.options.block import describe_silicon, read_stimuli
from system.rolls.options import NAME, bias_table, refuse_block_options
from system.rolls.options import silicon_of as silicon_of_chip

FIRST = 1e-3  # s, of the first event; ours
STIMULI = (
    Stimulus("rate", "Hz", 100.0, "events of each column and virtual synapse, one after another"),
    Stimulus("events", "", 2.0, "of each"),
    Stimulus("duration", "s", None, "length of the run", can_be_off=True),
)
AFTER = 10e-3  # s, of the run behind the last event; ours


def export_rolls(asked: Export) -> None:
    """Write the netlist of a row of ROLLS with its testbench.

    Raises `ParameterError` for options that a row does not take, and where no program or no row is named.
    """
    values, silicon, dialect = asked.values, asked.silicon, asked.dialect
    refuse_block_options(values.param, values.bias, values.bias_set)
    if asked.mapping is not None or asked.level != "transistor":
        option = "--mapping" if asked.mapping is not None else "--level"
        raise ParameterError(
            f"{option}: a row of rolls comes as transistors of its own process; leave it out"
        )
    if asked.program is None:
        raise ParameterError(
            "--program: which synapses are latched, must be a program, a CSV of post,pre,level or pushbot"
        )
    neuron = _neuron(silicon.at)
    written = load_dialect(dialect)
    edited = silicon.heal or silicon.only or silicon.deviate
    if written.drawing and (silicon.die is not None or edited):
        raise ParameterError(
            f"--die: {silicon.die}, {dialect} is the drawing, which no die changes; leave it out"
        )
    if asked.program.endswith(SUFFIX) and values.bias_file is not None:
        raise ParameterError(f"--bias-file: {asked.program} has its own biases; leave it out")
    program = read_program(asked.program, bias_table(values.bias_file))
    cut = cut_row(program, neuron, values.bias_kind or "generator")
    on_chip = silicon_of_chip(replace(silicon, at=None))
    bench, rests = row_testbench(cut, read_stimuli(STIMULI, asked.stimulus), on_chip.process)
    text = written.write(bench, silicon_of(cut, on_chip), settings_of(asked, cut.circuit))
    document = {
        "block": NAME, "at": f"row[{neuron}]", "dialect": dialect, "models": asked.models,
        **{k: v for k, v in describe_silicon(on_chip).items() if k != "at"},
        "synapses": [
            {"element": j, "column": c, "level": x}
            for j, (c, x) in enumerate(zip(cut.columns, cut.levels, strict=True))
        ],
        "virtual_excitatory": cut.virtual.excitatory, "virtual_inhibitory": cut.virtual.inhibitory,
        "slow_leak": cut.slow, "starts_at_rest": rests,
        "devices": sum(group.nodes.shape[1] for group in flatten(cut.circuit).groups),
    }  # fmt: skip
    leave_netlist(asked, text, document)


def row_testbench(
    cut: Cut, stimuli: Mapping[str, float | None], process: Process = ROLLS_180
) -> tuple[Testbench, bool]:
    """Give a testbench that applies regular events at every port of a row, one port after another.

    The second value tells whether the run starts at rest, which it does where the row has a rest state.
    Raises `ParameterError` for stimuli that make no run.
    """
    rate, count = stimuli["rate"] or 0.0, stimuli["events"] or 0.0
    events = pulse_count("events", count, rate)
    ports = [p for p in cut.circuit.ports if p.kind == "event" and p.direction == "in"]
    names = [name for p in ports for name in p.elements()]
    waves: dict[str, Waveform] = {}
    last = FIRST
    for k, name in enumerate(names):
        times = [FIRST + (j + k / len(names)) / rate for j in range(events)]
        waves[name], last = pulse(tuple(times), process.v_dd), max(last, times[-1])
    stop = stimuli["duration"] or last + AFTER
    if not stop > 0.0:
        raise ParameterError(f"duration: {stop:g} s, must be > 0; give a longer run")
    bench = bench_of(cut, waves, stop, process.v_dd)
    try:
        return started_at_rest(bench, process.ideal()), True
    except SolverError:
        # a neuron that fires by its bias has no rest to begin in
        return bench, False


def _neuron(at: str | None) -> int:
    """Number of `row[5]` or `rolls/row[5]`."""
    text = (at or "").removeprefix(f"{NAME}/")
    try:
        name, index = split_reference(text)
    except TopologyError:
        name, index = "", ()
    if name != "row" or len(index) != 1:
        raise ParameterError(f"--at: {at or 'nothing'}, must be row[NEURON]; name one of row[0] to row[255]")
    return index[0]
