"""The devices of a bias generator: what all lines of a chip share, and what each line has of its own.

Shared: a self-biased core, which makes the master current, the splitter of the eight coarse currents, and a
diode for each. Of a line: a copy of its coarse current's diode, a splitter of octaves whose switches the fine
code sets, a mirror, and the output device, whose gate is the line. The output device is diode-connected and
of the biased device's own size (ours), so that the code's current is that of the device; a pFET's is driven
over one more mirror.

    I_master = (U_T / R) ln M                           m1, m2 in weak inversion
    g_k / g_tap = sum(I_j, j > k) / (I_k - I_(k+1))     W/L between the coarse nodes k and k + 1
    I_out = I_coarse (b_7 / 2 + b_6 / 4 + ... + b_0 / 256)

`circuits.blocks.bias.generator` is one generator with one line, as a block; its sizes are these. All are
ours, in the AMI 1.5 um process.
"""

from __future__ import annotations

from dataclasses import replace

from circuits.devices import Device, Resistor, Transistor
from circuits.generator.code import COARSE, FINE_BITS
from circuits.silicon.process import Polarity

MASTER_CURRENT = 0.4e-6  # A at the reference temperature; ours
CORE_RATIO = 8.0  # M, size of m2 over that of m1; ours

_UM = 1e-6

# Sizes: (width, length) in um, all ours.
_CORE_N = (90.0, 3.0)  # m1; inversion coefficient 0.1 at the master current
_CORE_P = (24.0, 6.0)
_KICK_P, _KICK_N = (3.0, 60.0), (3.0, 3.0)  # each of the three diodes, and what they switch on
_COARSE_TAP = (24.0, 6.0)  # of the coarse splitter's branches and switches
_COARSE_SERIES_WIDTH = 6.0  # um; lengths follow from the currents
_RANGE_N = (24.0, 6.0)  # mirror between the splitters
_FINE = (12.0, 3.0)  # unit of the splitter of octaves
_SUM_P = (48.0, 6.0)
COPY = (6.0, 6.0)  # um; diode-connected copies at the output, the size of the neuron's biased devices


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


def masters(resistance: float) -> tuple[Device, ...]:
    """What all lines share: the core, the coarse splitter, and the diode `range_k` of each coarse current.

    resistance: of the core's resistor, Ohm.
    """
    devices: list[Device] = [*core(resistance)]
    for k in range(len(COARSE)):
        devices.append(_branch(k))
        devices.append(sized(f"mcs{k}", "p", (f"range_{k}", "0", f"ct{k}"), _COARSE_TAP))
        devices += _series(k)
        devices.append(sized(f"mr1_{k}", "n", (f"range_{k}", f"range_{k}", "0"), _RANGE_N))
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
    return sized("mr1", "n", ("range_n", "range_n", "0"), _RANGE_N)


def fine_splitter(code: int) -> list[Device]:
    """Copy of the coarse current, and nFETs with their gates at the supply; the first branch is bit 7."""
    devices: list[Device] = [sized("mr2", "n", ("f0", "range_n", "0"), _RANGE_N)]
    for k in range(FINE_BITS):
        devices.append(sized(f"mf{k}", "n", (f"ft{k}", "vdd", f"f{k}"), _FINE))
        on, off = ("vdd", "0") if code >> (FINE_BITS - 1 - k) & 1 else ("0", "vdd")
        devices.append(sized(f"mfs{k}", "n", ("sum", on, f"ft{k}"), _FINE))
        devices.append(sized(f"mfd{k}", "n", ("vdd", off, f"ft{k}"), _FINE))
        if k + 1 < FINE_BITS:
            devices.append(sized(f"mfh{k}", "n", (f"f{k + 1}", "vdd", f"f{k}"), _FINE))
    last = f"f{FINE_BITS - 1}"
    devices.append(sized("mfe0", "n", ("fe", "vdd", last), _FINE))
    devices.append(sized("mfe1", "n", ("vdd", "vdd", "fe"), _FINE))
    return devices


def sum_mirror() -> tuple[Device, ...]:
    """The mirror that turns the fine splitter's current round."""
    return (
        sized("mo1", "p", ("sum", "sum", "vdd"), _SUM_P),
        sized("mo2", "p", ("v_n", "sum", "vdd"), _SUM_P),
    )


def n_diode() -> Transistor:
    """The nFET whose gate `v_n` is that of nFETs."""
    return sized("mdn", "n", ("v_n", "v_n", "0"), COPY)


def p_copy() -> Transistor:
    """The nFET that drives the output device of a pFET's line."""
    return sized("mp", "n", ("v_p", "v_n", "0"), COPY)


def p_diode() -> Transistor:
    """The pFET whose gate `v_p` is that of pFETs."""
    return sized("mdp", "p", ("v_p", "v_p", "vdd"), COPY)


def line(fine: int, device: Transistor) -> tuple[Device, ...]:
    """A line of fine code `fine` for biased devices like `device`; `range_n` is the coarse diode."""
    if device.polarity == "n":
        output: tuple[Device, ...] = (_as_large(n_diode(), device),)
    else:
        output = (n_diode(), p_copy(), _as_large(p_diode(), device))
    return (*fine_splitter(fine), *sum_mirror(), *output)


def _as_large(diode: Transistor, device: Transistor) -> Transistor:
    return replace(diode, width=device.width, length=device.length, multiplicity=device.multiplicity)
