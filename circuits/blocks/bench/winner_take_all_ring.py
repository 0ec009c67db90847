"""Winner-take-all of 16 cells in a ring, with neighbours that excite or inhibit, and hysteresis.

A cell is that of Lazzaro et al. (1989) between mirrors. A pFET makes the input's current, `m1` takes it under
the control of `v_c`, and `m2`, at the output `v_out`, carries the cell's part of the tail currents from v_c.
All v_c are one node where `v_inh` is high: then the cell of the greatest current takes all tails, and the
others' v_out fall to ground. At a lower `v_inh` a cell inhibits its neighbours alone, in part. At `v_ex`
neighbours' v_out are joined, so that a cell lifts those beside it.

    I_out of the winner = N I_b
    dv_out = (U_T / kappa) ln(N)     by which the winner's v_out is above that of equal cells

Hysteresis: `m5` returns a copy of the cell's part of the tail to its own input. Its source is no supply but
the line `v_gain`, which the generator puts a gate voltage of a pFET below the supply. So the copy is

    I_fb = I_out e^(-(v_dd - v_gain) / U_T)

and what has won keeps that much: a rival must bring as much more. The switch `me` is on at 0 V of `enable`.

`i_all` copies what `m1` takes, `i_out` the cell's part of the tail, for the converters.

Source: topology and sizes, and the codes of the biases, are the laboratory's. Where the currents are read is
ours. Lazzaro, Ryckebusch, Mahowald & Mead, "Winner-take-all networks of O(N) complexity" (1989).
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import crossing, ramp, within_supply
from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import Wave, powered
from circuits.blocks.mos import current_mirror, mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, bias_ports
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit, Node, Port
from circuits.devices import Transistor
from circuits.devices.source import PiecewiseLinear
from circuits.silicon.process import ROLLS_180
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

POINTS = 100  # of a sweep, each way
FEWEST = 3  # cells of a ring


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Number of cells, and sizes, um."""

    cells: int = quantity(16, "", least=FEWEST)
    n_width: float = um(1.0)
    n_length: float = um(1.0)
    p_width: float = um(3.4)
    p_length: float = um(1.0)


def cell(params: Params = Params()) -> Circuit:
    """One cell: ports v_in, v_out, v_c, i_out, i_all, v_tail, v_gain, enable, the supply; params: sizes."""
    n, p = params.sizes("n", "p")
    outputs = analog_out("v_out", "v_c", "i_out", "i_all")
    return Circuit(
        "ring_cell",
        (SUPPLY, *analog_in("v_in"), *outputs, *bias_in("v_tail", "v_gain", "enable")),
        (
            mos("mi", "p", "v_out", "v_in", "vdd", *p),
            mos("m1", "n", "v_out", "v_c", "v_m", *n),
            *current_mirror("m6", "m7", "n", "v_m", "i_all", n),
            mos("m2", "n", "v_p", "v_out", "v_c", *n),
            mos("mb", "n", "v_c", "v_tail", "0", *n),
            *current_mirror("m3", "m4", "p", "v_p", "i_out", p),
            mos("m5", "p", "v_out", "v_p", "v_f", *p),
            mos("me", "p", "v_f", "enable", "v_gain", *p),
        ),
    )


BIASES = (
    coded_bias("tail", MASTERS[3], 100, "cell.mb", (1.0, 1.0)),
    coded_bias("gain", MASTERS[3], 2, "cell.m5", (3.4, 1.0)),
    coded_bias("ex", MASTERS[3], 50, "mx0", (1.0, 1.0)),
    Bias("v_inh", "v_inh", "voltage", 1.8),
    Bias("v_enable", "enable", "voltage", 0.0),
)


def build(params: Params = Params()) -> Circuit:
    """The ring: ports v_in[N], v_out[N], i_out[N], i_all[N], biases and the supply; params: sizes.

    v_gain is a line that the generator drives; a source in its place is one that gives way nowhere.
    """
    shape = (int(params.cells),)
    arrays = (Port("v_in", "analog", "in", shape), Port("v_out", "analog", "out", shape))
    read = (Port("i_out", "analog", "out", shape), Port("i_all", "analog", "out", shape))
    return Circuit(
        "winner_take_all_ring",
        (SUPPLY, *arrays, *read, *bias_ports(BIASES)),
        tuple(joint for k in range(shape[0]) for joint in _joints(params, k)),
        (cell(params).array("cell", shape),),
        (Node("v_c", shape),),
        BIASES,
    )


def _joints(params: Params, k: int) -> tuple[Transistor, Transistor]:
    """What joins a cell to the next one: `mh` their common nodes, `mx` their outputs."""
    size, next_one = params.size("n"), (k + 1) % int(params.cells)
    return (
        mos(f"mh{k}", "n", f"v_c[{k}]", "v_inh", f"v_c[{next_one}]", *size),
        mos(f"mx{k}", "n", f"v_out[{k}]", "v_ex", f"v_out[{next_one}]", *size),
    )


STIMULI = (
    Stimulus("high", "V", 1.75, "v_in of cell 0 at the beginning and the end"),
    Stimulus("low", "V", 1.55, "v_in of cell 0 in the middle"),
    Stimulus("rival", "V", 1.65, "v_in of cell 1"),
    lasting(2.0, "length of the sweep there and back"),
)
PLOTTED = ("v_in[0]", "v_out[0]", "v_out[1]", "v_out[2]", "v_c[0]")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """v_in of cell 0 from `high` to `low` and back, that of cell 1 at `rival`, the others' at the supply.

    Raises `ParameterError` for a level that leaves the supply.
    """
    high, low, rival, duration = (stimuli[name] or 0.0 for name in ("high", "low", "rival", "duration"))
    within_supply("high", v_dd, high)
    within_supply("low", v_dd, low)
    within_supply("rival", v_dd, rival)
    half = 0.5 * duration
    down, up = ramp(0.0, half, high, low, POINTS), ramp(half, duration, low, high, POINTS)
    swept = PiecewiseLinear((*down.time, *up.time[1:]), (*down.value, *up.value[1:]))
    waves: dict[str, Wave] = dict.fromkeys(circuit.port("v_in").elements(), v_dd)
    waves |= {"v_in[0]": swept, "v_in[1]": rival}
    waves |= dict.fromkeys(circuit.port("i_out").elements(), OUT_AT)
    waves |= dict.fromkeys(circuit.port("i_all").elements(), ALL_AT)
    return rested("winner-take-all ring", circuit, powered(v_dd, waves), duration, ROLLS_180)


OUT_AT, ALL_AT = (
    0.6,
    1.2,
)  # V, at which the converters take a current that flows to them, and one from them; ours


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `switch_down_V`, `switch_up_V`, `hysteresis_V`, `winner_V` and `loser_V`.

    switch_down, switch_up: v_in of cell 0 at which its output passes that of cell 1, on the way down and on
    the way up; None where it does not. hysteresis: the way up less the way down. winner, loser: outputs of
    cells 0 and 1 at the lowest v_in.
    """
    v_in, lead = result["v_in[0]"], result["v_out[0]"] - result["v_out[1]"]
    turn = int(v_in.argmin())
    down, up = crossing(v_in[: turn + 1], lead[: turn + 1], 0.0), crossing(v_in[turn:], lead[turn:], 0.0)
    return {
        "switch_down_V": down,
        "switch_up_V": up,
        "hysteresis_V": None if down is None or up is None else up - down,
        "winner_V": float(result["v_out[0]"][turn]),
        "loser_V": float(result["v_out[1]"][turn]),
    }


def outcome(result: Result) -> str:
    """`switches` both ways, `keeps` the winner on the way back, or `stays` with the rival."""
    found = measures(result)
    if found["switch_down_V"] is None:
        return "stays"
    return "keeps" if found["switch_up_V"] is None else "switches"


BLOCK = catalogued("winner-take-all-ring", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
