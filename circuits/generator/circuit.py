"""The devices of a bias generator: what all lines of a chip share, and what each line has of its own.

Shared: a self-biased core, which makes the master current, the splitter of the eight coarse currents, and a
diode for each. Of a line: a copy of its coarse current's diode, a splitter of octaves whose switches the fine
code sets, a mirror, and the output device, whose gate is the line. The output device is diode-connected and
of the biased device's own size (ours), so that the code's current is that of the device; a pFET's is driven
over one more mirror.

    I_master = (U_T / R) ln M                           m1, m2 in weak inversion
    g_k / g_tap = sum(I_j, j > k) / (I_k - I_(k+1))     W/L between the coarse nodes k and k + 1
    I_out = I_coarse (b_7 / 2 + b_6 / 4 + ... + b_0 / 256)

In a process whose devices carry more than the least code at V_GS = 0, as those of 0.18 um do, a line of a
small coarse current has narrow and long devices (`line_sizes`), as the LowBias and HighBias flags of ROLLS'
control software choose between two outputs. What is left there is what the biased device carries itself at
V_GS = 0. The other output, which is cut off, is left out with what it leaks.

`circuits.blocks.bias.generator` is one generator with one line, as a block; its sizes are those of the AMI
1.5 um process. All are ours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from circuits.devices import Device, Resistor, Transistor
from circuits.generator.code import COARSE, CODES, FINE_BITS, REFERENCE_C
from circuits.silicon.process import POLARITIES, Polarity, Process, at_temperature

MASTER_CURRENT = 0.4e-6  # A at the reference temperature; ours
CORE_RATIO = 8.0  # M, size of m2 over that of m1; ours

_UM = 1e-6

# Sizes: (width, length) in um, all ours.
_CORE_N = (90.0, 3.0)  # m1; inversion coefficient 0.1 at the master current
_CORE_P = (24.0, 6.0)
_KICK_P, _KICK_N = (3.0, 60.0), (3.0, 3.0)  # each of the three diodes, and what they switch on
_COARSE_TAP = (24.0, 6.0)  # of the coarse splitter's branches and switches
_COARSE_SERIES_WIDTH = 6.0  # um; lengths follow from the currents


@dataclass(frozen=True, slots=True)
class LineSizes:
    """Sizes of a line's own devices, (width, length) in um.

    range_n : of the mirror between the splitters, whose diode is the coarse current's.
    fine : unit of the splitter of octaves.
    sum_p : of the mirror that turns its current round.
    copy : of diode-connected copies at the output.
    off_gate : node at the gates of switches that are off. With ground there, a gate induces leakage at their
        drains, which stand near the supply: 0.1 pA for each um of width in the 0.18 um process.
    """

    range_n: tuple[float, float]
    fine: tuple[float, float]
    sum_p: tuple[float, float]
    copy: tuple[float, float]
    off_gate: str


WIDE = LineSizes((24.0, 6.0), (12.0, 3.0), (48.0, 6.0), (6.0, 6.0), "0")
"""Sizes in the 1.5 um process, and for large coarse currents in any; copies are as the neuron's devices."""
_LONG = (1.0, 48.0)  # um; the area of a unit of WIDE, and an off current of I_0 / 48
NARROW = LineSizes(_LONG, _LONG, _LONG, _LONG, "kick_b")
"""Sizes for small coarse currents where devices that are off carry more than the least code."""
_NARROW_MOST = 10e-9  # A, coarse current up to which a line can be narrow: moderate inversion in it


def line_sizes(process: Process) -> tuple[LineSizes, ...]:
    """Sizes of the lines of each coarse code in a process.

    They are `NARROW` for small coarse currents where a square device at V_GS = 0 carries more than the least
    code, `I_0 = I_S e^(-kappa V_T0 / U_T)`, else `WIDE`.
    """
    laws = [at_temperature(process.model(p), process, REFERENCE_C) for p in POLARITIES]
    off = max(law.square_current * math.exp(-law.kappa * law.v_t0 / law.u_t) for law in laws)
    small = NARROW if off > COARSE[-1] / CODES else WIDE
    return tuple(small if current <= _NARROW_MOST else WIDE for current in COARSE)


def sized(
    name: str,
    polarity: Polarity,
    nodes: tuple[str, str, str],
    size: tuple[float, float],
    multiplicity: float = 1.0,
) -> Transistor:
    """A transistor of (drain, gate, source) nodes and (width, length) in um, its bulk at its supply."""
    bulk = "vdd" if polarity == "p" else "0"
    return Transistor(name, polarity, *nodes, bulk, size[0] * _UM, size[1] * _UM, multiplicity)


def core(resistance: float, ratio: float = CORE_RATIO) -> tuple[Device, ...]:
    """PTAT core (lines core_n and core_p), start-up, and the current into the coarse splitter.

    resistance: of its resistor, Ohm; ratio: M.
    """
    total = sum(COARSE) / MASTER_CURRENT
    return (
        sized("m1", "n", ("core_n", "core_n", "0"), _CORE_N),
        sized("m2", "n", ("core_p", "core_n", "core_r"), _CORE_N, ratio),
        Resistor("r", "core_r", "0", resistance),
        sized("m3", "p", ("core_n", "core_p", "vdd"), _CORE_P),
        sized("m4", "p", ("core_p", "core_p", "vdd"), _CORE_P),
        sized("mk1", "p", ("kick_a", "kick_a", "vdd"), _KICK_P),
        sized("mk2", "p", ("kick_b", "kick_b", "kick_a"), _KICK_P),
        sized("mk3", "p", ("kick", "kick", "kick_b"), _KICK_P),
        sized("mk4", "n", ("core_p", "kick", "0"), _KICK_N),
        sized("mk5", "n", ("kick", "core_n", "0"), _CORE_N),
        sized("mfeed", "p", ("c0", "core_p", "vdd"), _CORE_P, total),
    )


def coarse_splitter(code: int) -> list[Device]:
    """PFETs with their gates at ground; the branch of `code` ends in the mirror, the others at ground."""
    devices: list[Device] = []
    for k in range(len(COARSE)):
        devices.append(_branch(k))
        on, off = ("0", "vdd") if k == code else ("vdd", "0")
        devices.append(sized(f"mcs{k}", "p", ("range_n", on, f"ct{k}"), _COARSE_TAP))
        devices.append(sized(f"mcd{k}", "p", ("0", off, f"ct{k}"), _COARSE_TAP))
        devices += _series(k)
    return devices


def masters(resistance: float, sizes: Sequence[LineSizes]) -> tuple[Device, ...]:
    """What all lines share: the core, the coarse splitter, and the diode `range_k` of each coarse current.

    resistance: of the core's resistor, Ohm; sizes: of the lines of each coarse code.
    """
    devices: list[Device] = [*core(resistance)]
    for k in range(len(COARSE)):
        devices.append(_branch(k))
        devices.append(sized(f"mcs{k}", "p", (f"range_{k}", "0", f"ct{k}"), _COARSE_TAP))
        devices += _series(k)
        devices.append(sized(f"mr1_{k}", "n", (f"range_{k}", f"range_{k}", "0"), sizes[k].range_n))
    return tuple(devices)


def _branch(k: int) -> Transistor:
    return sized(f"mc{k}", "p", (f"ct{k}", "0", f"c{k}"), _COARSE_TAP)


def _series(k: int) -> list[Device]:
    """What stands between the coarse nodes k and k + 1."""
    if k + 1 == len(COARSE):
        return []
    tap = 0.5 * _COARSE_TAP[0] / _COARSE_TAP[1]  # a branch and its switch in series
    ratio = tap * sum(COARSE[k + 1 :]) / (COARSE[k] - COARSE[k + 1])
    size = (_COARSE_SERIES_WIDTH, _COARSE_SERIES_WIDTH / ratio)
    return [sized(f"mch{k}", "p", (f"c{k + 1}", "0", f"c{k}"), size)]


def range_diode() -> Transistor:
    """The diode of the coarse current that goes into a lone line."""
    return sized("mr1", "n", ("range_n", "range_n", "0"), WIDE.range_n)


def fine_splitter(code: int, sizes: LineSizes = WIDE) -> list[Device]:
    """Copy of the coarse current, and nFETs with their gates at the supply; the first branch is bit 7."""
    devices: list[Device] = [sized("mr2", "n", ("f0", "range_n", "0"), sizes.range_n)]
    for k in range(FINE_BITS):
        devices.append(sized(f"mf{k}", "n", (f"ft{k}", "vdd", f"f{k}"), sizes.fine))
        gates = ("vdd", sizes.off_gate)
        on, off = gates if code >> (FINE_BITS - 1 - k) & 1 else gates[::-1]
        devices.append(sized(f"mfs{k}", "n", ("sum", on, f"ft{k}"), sizes.fine))
        devices.append(sized(f"mfd{k}", "n", ("vdd", off, f"ft{k}"), sizes.fine))
        if k + 1 < FINE_BITS:
            devices.append(sized(f"mfh{k}", "n", (f"f{k + 1}", "vdd", f"f{k}"), sizes.fine))
    last = f"f{FINE_BITS - 1}"
    devices.append(sized("mfe0", "n", ("fe", "vdd", last), sizes.fine))
    devices.append(sized("mfe1", "n", ("vdd", "vdd", "fe"), sizes.fine))
    return devices


def sum_mirror(sizes: LineSizes = WIDE) -> tuple[Device, ...]:
    """The mirror that turns the fine splitter's current round."""
    return (
        sized("mo1", "p", ("sum", "sum", "vdd"), sizes.sum_p),
        sized("mo2", "p", ("v_n", "sum", "vdd"), sizes.sum_p),
    )


def n_diode(sizes: LineSizes = WIDE) -> Transistor:
    """The nFET whose gate `v_n` is that of nFETs."""
    return sized("mdn", "n", ("v_n", "v_n", "0"), sizes.copy)


def p_copy(sizes: LineSizes = WIDE) -> Transistor:
    """The nFET that drives the output device of a pFET's line."""
    return sized("mp", "n", ("v_p", "v_n", "0"), sizes.copy)


def p_diode(sizes: LineSizes = WIDE) -> Transistor:
    """The pFET whose gate `v_p` is that of pFETs."""
    return sized("mdp", "p", ("v_p", "v_p", "vdd"), sizes.copy)


def line(fine: int, device: Transistor, sizes: LineSizes = WIDE) -> tuple[Device, ...]:
    """A line of fine code `fine` for biased devices like `device`; `range_n` is the coarse diode."""
    if device.polarity == "n":
        output: tuple[Device, ...] = (_as_large(n_diode(sizes), device),)
    else:
        output = (n_diode(sizes), p_copy(sizes), _as_large(p_diode(sizes), device))
    return (*fine_splitter(fine, sizes), *sum_mirror(sizes), *output)


def _as_large(diode: Transistor, device: Transistor) -> Transistor:
    return replace(diode, width=device.width, length=device.length, multiplicity=device.multiplicity)
