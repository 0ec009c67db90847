"""Testbenches that start near a block's state of rest, for simulators that do not find it from 0 V."""

from __future__ import annotations

from dataclasses import replace

from circuits.devices.source import Source
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

REFERENCE_C = 27.0  # degC


def started_at_rest(bench: Testbench, process: Process, held: tuple[Source, ...] = ()) -> Testbench:
    """`bench` with the operating point of the nominal die at 27 degC as its start, to 1 mV.

    Not every simulator finds it from 0 V; a state that is found without this start is reported beside. held:
    sources that choose one of several states of rest and are gone in the run.
    """
    driven = {"0", *(source.node for source in bench.sources)}
    choosing = replace(bench, sources=(*bench.sources, *held))
    voltages = operating_point(choosing, Silicon(process, REFERENCE_C)).voltages()
    return replace(bench, start={node: round(v, 3) for node, v in voltages.items() if node not in driven})
