"""How each block is compared with ngspice in the tests: its silicon, its form, and how fine ngspice runs.

A block's temperature and die are drawn from its name, so that a new block moves no other. It is biased from
the bias generator, as on its chip: at a fixed gate voltage its currents would move tenfold with the draw, and
most blocks would stay silent. `noctule reproduce agreement` has all blocks at their fixed gate voltages, at
three temperatures, and runs their whole testbenches.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass

from circuits.blocks.block import Block
from circuits.silicon.die import Die, Extent
from circuits.silicon.silicon import Silicon
from netlists.ngspice.agreement import USUAL, Allowance
from netlists.ngspice.form import Form

COLD, HOT = -20.0, 85.0  # degC
FIRST_DIE, DIES = 1000, 9000  # below 1000 are those on which parameters are chosen


ON_ITS_CHIP = Form(kind="ideal")


@dataclass(frozen=True, slots=True)
class Case:
    """How a block is compared.

    form: its testbench. reltol, points: ngspice's relative tolerance, and how many steps a run has at least:
    as fine as it takes for halving both to move ngspice by no more than a quarter of what may differ. begun:
    whether ngspice gets the solver's rest state as its guess (`.nodeset`), and solves from there. allowed:
    what may differ; the usual follows from the tolerances of both engines. coldest, hottest: between which
    temperatures it is drawn, degC. variation: which components its die has; what those beside the plain
    ones do must then be seen. why: reason of all that is not the usual.
    """

    form: Form = ON_ITS_CHIP
    reltol: float = 1e-4
    points: int = 500
    begun: bool = False
    allowed: Allowance = USUAL
    coldest: float = COLD
    hottest: float = HOT
    variation: Extent = "plain"
    why: str = ""


USUAL_CASE = Case()
_AT_REST = "nothing moves: what is left are the tolerances by which Newton's method stops, 1 uV (vntol)"
_AT_ONCE = Form(kind="ideal", stop=10e-6)
_ALL_COMPONENTS = "some neurons have a die with all components of variation"
_COARSER = "half as fine as usual is fine enough: there halving moves ngspice by"
_FILLED = (
    "without a guess ngspice calls its matrix singular while it looks for rest, and keeps what filled it then"
)
_REGENERATIVE = "a regenerative edge needs ngspice's steps short"
CASES: Mapping[str, Case] = {
    "axon-delay": Case(
        Form(kind="ideal", stop=0.9e-3),
        reltol=4e-5,
        points=275,
        why="the delay tells, and moves with ngspice's reltol",
    ),
    "bias-chain": Case(_AT_ONCE, points=5, allowed=Allowance(operating_point=1e-6), why=_AT_REST),
    "bias-generator": Case(_AT_ONCE, points=5, allowed=Allowance(operating_point=1e-6), why=_AT_REST),
    "calcium-gate": Case(
        Form(kind="ideal", stop=0.02),
        reltol=2e-4,
        points=165,
        why="its spikes, each a step of calcium, tell; later calcium can rest on a comparator's threshold,"
        " whose output then shows ngspice's own error many times larger: over the whole run 2.8 mV rms at"
        " reltol 1e-5, 2.0 mV at 1e-6, 0.8 mV at 1e-7",
    ),
    "centroid-board": Case(
        Form(kind="ideal", stop=0.06),
        reltol=6e-6,
        points=750,
        why="one call interval tells; its hold capacitors leak for long between two samples",
    ),
    "coincidence-detector": Case(
        Form(kind="ideal", stop=0.0035), reltol=2e-4, points=75, why="the spike of a coincidence tells"
    ),
    "conductance-neuron": Case(
        Form(kind="ideal", stop=0.0071),
        reltol=1e-5,
        points=2_000,
        coldest=20.0,
        why="two excitations, which just suffice at 27 degC and no longer at -20 degC: near the margin the"
        " spike's time hangs on ngspice's tolerances; its first spike tells",
    ),
    "delay-tap": Case(
        Form(kind="ideal", stop=0.0064),
        reltol=2e-4,
        points=180,
        why=f"both spikes tell; {_COARSER} 0.24 of what may differ",
    ),
    "depressing-synapse": Case(
        Form(kind="ideal", stop=0.0065),
        reltol=8e-4,
        points=50,
        why="two spikes tell, the second on a depressed weight",
    ),
    "dpi-synapse": Case(reltol=4e-4, points=125, why="short pulses and straight ramps need few steps"),
    "envelope-detector": Case(reltol=1e-5, points=2_000, why="100 periods of 40 kHz in the run"),
    "high-threshold-neuron": Case(begun=True, why=_FILLED),
    "latency-neuron": Case(
        Form(kind="ideal", stop=0.0095),
        reltol=2e-4,
        points=80,
        variation="full",
        why=f"the spike at its latency tells; {_ALL_COMPONENTS}",
    ),
    "latency-unit": Case(
        Form(
            {"membrane_capacitance": 0.5e-12, "timer_capacitance": 0.5e-12},
            {"first": 60e-6, "integrating": 1e-3, "reset": None},
            "ideal",
            80e-6,
        ),
        reltol=2e-4,
        points=200,
        why="the coincidence of A and B tells, quick by a tenth of the capacitors;"
        " two pings of a whole unit are `benchmarks/latency_unit.py`'s",
    ),
    "lso-neuron": Case(
        Form(kind="ideal", stop=0.00205), reltol=2e-4, points=125, why="the first spike tells"
    ),
    "onset-neuron": Case(
        begun=True,
        why="nothing but off currents holds the refractory circuit's nodes: without a guess ngspice calls its"
        " matrix singular",
    ),
    "plastic-synapse": Case(
        Form(kind="ideal", stop=0.012), reltol=4e-4, points=60, why="the first moves of the weight tell"
    ),
    "race-cell": Case(
        Form(kind="ideal", stop=0.0705), reltol=4e-4, points=110, why="its spike ends the race"
    ),
    "race-layer": Case(
        Form(
            {
                "membrane_capacitance": 0.1e-12,
                "timer_capacitance": 50e-15,
                "recurrent_capacitance": 50e-15,
                "cells": 1,
            },
            {"excite_0": None, "excite_1": None, "inhibit_1": None, "inhibit_2": None},
            "ideal",
            1.0e-3,
        ),
        reltol=5e-5,
        points=215,
        why="one cell's race and its spike tell, quick by a hundredth of the capacitors",
    ),
    "rebound-neuron": Case(
        Form(kind="ideal", stop=0.0093),
        reltol=1e-5,
        points=2_000,
        begun=True,
        why="the first rebound tells: some dies fire again and again, each time adding its error to the next;"
        f" {_FILLED}",
    ),
    "rolls-neuron": Case(
        Form(kind="ideal", stop=0.0065),
        reltol=1e-5,
        points=2_800,
        variation="full",
        why=f"{_REGENERATIVE}; two spikes and the adaptation between them tell; {_ALL_COMPONENTS}",
    ),
    "tonic-neuron": Case(
        Form(kind="ideal", stop=0.012),
        reltol=2e-4,
        points=100,
        variation="full",
        why=f"a spike and the beginning of its long silence tell; {_ALL_COMPONENTS}",
    ),
    "vocalization-controller": Case(
        Form(kind="ideal", stop=0.06), reltol=1.2e-6, points=4_000, why=_REGENERATIVE
    ),
    "adaptive-neuron": Case(
        Form(kind="ideal", stop=0.005),
        reltol=1e-5,
        points=2_000,
        why=f"{_REGENERATIVE}; its first spikes tell",
    ),
    "axon-hillock": Case(
        Form(kind="ideal", stop=2.2),
        reltol=4e-5,
        points=500,
        hottest=30.0,
        why="a spike and its end tell; hotter the switch of its reset leaks more than its input gives",
    ),
    "ddi-synapse": Case(
        Form(kind="ideal", stop=0.04),
        reltol=4e-5,
        points=650,
        why="a pulse of a millisecond in a long run, whose flank 510 points a run may miss",
    ),
    "wavefront-cell": Case(
        Form(kind="ideal", stop=25e-6),
        reltol=2e-4,
        points=125,
        why=f"its firing tells; {_COARSER} 0.24 of what may differ",
    ),
    "winner-take-all-ring": Case(
        Form({"cells": 4}, {"duration": 0.4}, "ideal"),
        points=600,
        why="four cells of the ring have all that sixteen have, and a regenerative switch each way tells",
    ),
}


def case_of(name: str) -> Case:
    """The case of a block, the usual one where the table has none."""
    return CASES.get(name, USUAL_CASE)


def silicon_of(block: Block) -> Silicon:
    """Process of a block, with the die and the temperature that its name draws."""
    drawn = hashlib.blake2b(block.name.encode(), digest_size=8).digest()
    case = case_of(block.name)
    share = int.from_bytes(drawn[:4]) / 2.0**32
    temperature_c = round(case.coldest + (case.hottest - case.coldest) * share)
    number = FIRST_DIE + int.from_bytes(drawn[4:]) % DIES
    return Silicon(block.process, float(temperature_c), Die(number=number, variation=case.variation))
