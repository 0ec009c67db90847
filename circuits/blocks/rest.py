"""Testbenches that start near a block's state of rest.

Outside simulators do not always find that state from 0 V at every node.
"""

from __future__ import annotations

from dataclasses import replace

from circuits.circuit import Circuit
from circuits.devices.source import Source
from circuits.silicon.process import AMI_1500_IDEAL, Process
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


def rested(
    title: str, circuit: Circuit, sources: tuple[Source, ...], stop: float,
    process: Process = AMI_1500_IDEAL, watch: tuple[str, ...] = (),
) -> Testbench:  # fmt: skip
    """A testbench of these parts, started as by `started_at_rest`.

    Parameters
    ----------
    title, circuit, sources, watch
        As those of a `Testbench`.
    stop
        Length of its runs, s.
    process
        Process whose nominal die is at rest at the start.
    """
    return started_at_rest(Testbench(title, circuit, sources, stop, watch=watch), process)
