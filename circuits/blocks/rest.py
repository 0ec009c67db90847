"""Testbenches that start near a block's state of rest.

Outside simulators do not always find that state from 0 V at every node.
"""

from __future__ import annotations

from dataclasses import replace

from circuits.devices.source import Source
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

REFERENCE_C = 27.0  # degC


def started_at_rest(bench: Testbench, process: Process, held: tuple[Source, ...] = ()) -> Testbench:
    """`bench` with the operating point of the nominal die at 27 degC as its start, rounded to 1 mV.

    held: sources that choose one of several states of rest and are not there in the run. A state that is
    found without the start is still reported beside.
    """
    driven = {"0", *(source.node for source in bench.sources)}
    choosing = replace(bench, sources=(*bench.sources, *held))
    voltages = operating_point(choosing, Silicon(process, REFERENCE_C)).voltages()
    return replace(bench, start={node: round(v, 3) for node, v in voltages.items() if node not in driven})
