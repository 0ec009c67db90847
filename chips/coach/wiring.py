"""Which circuits the teaching chip has, and at which pins and under which names of biases they are reached.

The pins of all circuits are shared: a multiplexer chooses one circuit at a time. Names are the laboratory's,
but those of the biases that its texts do not name: of the winner-take-all's neighbours and the adaptation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from circuits.blocks.bench import (
    adaptive_neuron,
    axon_hillock,
    bump_antibump,
    differential_pair,
    dpi_synapse,
    follower_integrator,
    transamp,
    transistor,
    wide_range_transamp,
    winner_take_all_ring,
)
from circuits.blocks.block import Block

CONVERTED_DOWN, CONVERTED_UP = 1.2, 0.6  # V, at which a converter takes a current to ground, and gives one

# A, of the chip's own source, which is not told and was about 1 pA on a real chip; ours: above what the
# reset's switch, which is off, leaks on most dies of this process
INTO_AHN = 8e-12


@dataclass(frozen=True, slots=True)
class Wiring:
    """A circuit on the chip.

    Attributes
    ----------
    block
        The circuit.
    inputs, outputs, ammeters
        Port that is driven, node that is read, and resistor whose current is read, by the name of the pin.
    counted
        Transistor whose current a converter counts, by the name of its channel.
    lines
        Port of a bias, by its name.
    held
        Voltages (V) at which ports stand.
    events
        Port at which events come in; empty where there is none.
    current
        Currents (A) that the chip's own sources give into nodes.
    """

    block: Block
    inputs: Mapping[str, str]
    lines: Mapping[str, str]
    outputs: Mapping[str, str] = field(default_factory=dict)
    ammeters: Mapping[str, str] = field(default_factory=dict)
    counted: Mapping[str, str] = field(default_factory=dict)
    held: Mapping[str, float] = field(default_factory=dict)
    events: str = ""
    current: Mapping[str, float] = field(default_factory=dict)


def _amplifier(block: Block, tag: str, pins: tuple[str, str, str], counted: Mapping[str, str]) -> Wiring:
    held = dict.fromkeys(("i_plus", "i_minus"), CONVERTED_DOWN) if counted else {}
    return Wiring(
        block,
        {pins[0]: "v_plus", pins[1]: "v_minus"},
        {tag: "v_tail"},
        {pins[2]: "v_out"},
        counted=counted,
        held=held,
    )


def _ring() -> Wiring:
    """The winner-take-all; a cell's output stands at the pin whose number is 15 less the cell's."""
    cells = range(16)
    down = {f"i_all[{k}]": CONVERTED_DOWN for k in cells}
    return Wiring(
        winner_take_all_ring.BLOCK,
        {f"AIN{k}": f"v_in[{k}]" for k in cells},
        {"WTA_VB_N": "v_tail", "WTA_VGAIN_P": "v_gain", "WTA_VEX_N": "v_ex", "WTA_VINH_N": "v_inh"},
        {f"ADC{15 - k}": f"v_out[{k}]" for k in cells},
        counted={
            **{f"C2F{k}": f"cell[{k}].m4" for k in cells},
            **{f"C2F{k}_ALL": f"cell[{k}].m7" for k in cells},
        },
        held={**down, **{f"i_out[{k}]": CONVERTED_UP for k in cells}, "enable": 0.0},
    )


_ADAPTATION = {
    "ACN_VADPW_N": "v_aw",
    "ACN_VADPTHR_N": "v_athr",
    "ACN_VADPTAU_P": "v_atau",
}
CIRCUITS: Mapping[str, Wiring] = {
    "NFET": Wiring(
        transistor.NFET,
        {"AIN0": "gate", "GO22": "drain", "GO20": "source"},
        {},
        ammeters={"GO22": "r_drain", "GO20": "r_source"},
    ),
    "PFET": Wiring(
        transistor.PFET,
        {"AIN0": "gate", "AIN1": "well", "GO23": "source", "GO21": "drain"},
        {},
        ammeters={"GO21": "r_drain", "GO23": "r_source"},
    ),
    "NDP": Wiring(
        differential_pair.BLOCK,
        {"AIN5": "v1", "AIN6": "v2"},
        {"NDP_VB_N": "v_tail"},
        counted={"C2F0": "m1", "C2F1": "m2"},
        held=dict.fromkeys(("i1", "i2"), CONVERTED_DOWN),
    ),
    "BAB": Wiring(
        bump_antibump.BLOCK,
        {"AIN12": "v1", "AIN13": "v2"},
        {"BAB_VB_N": "v_tail"},
        counted={"C2F5": "m1", "C2F6": "m2", "C2F7": "m4"},
        held=dict.fromkeys(("i1", "i2", "i_out"), CONVERTED_DOWN),
    ),
    "NTA": _amplifier(transamp.N, "NTA_VB_N", ("AIN3", "AIN4", "ADC13"), {"C2F11": "mp2", "C2F12": "mm4"}),
    "PTA": _amplifier(transamp.P, "PTA_VB_P", ("AIN7", "AIN8", "ADC12"), {"C2F13": "mp2", "C2F14": "mm4"}),
    "WRT": _amplifier(wide_range_transamp.BLOCK, "WRT_VB_N", ("AIN7", "AIN8", "ADC11"), {}),
    "FOI": Wiring(follower_integrator.BLOCK, {"AIN9": "v_in"}, {"FOI_VB_N": "v_tail"}, {"ADC10": "v_out"}),
    "WTA": _ring(),
    "DPI": Wiring(
        dpi_synapse.BLOCK,
        {},
        {
            "DPI_VTAU_P": "v_tau",
            "DPI_VTHR_N": "v_thr",
            "DPI_VWEIGHT_N": "v_weight",
            "PEX_VTAU_N": "v_pulse",
        },
        {"ADC14": "v_syn"},
        counted={"C2F9": "filter.md5"},
        held={"i_out": CONVERTED_UP},
        events="event",
    ),
    "AHN": Wiring(
        axon_hillock.BLOCK, {}, {"AHN_VPW_N": "v_pw"}, {"ADC11": "v_mem"}, current={"v_mem": INTO_AHN}
    ),
    "ACN": Wiring(
        adaptive_neuron.BLOCK,
        {},
        {
            "ACN_VDC_P": "v_dc",
            "ACN_VGAIN_N": "v_gain",
            "ACN_VLEAK_N": "v_leak",
            "ACN_VREFR_N": "v_ref",
            **_ADAPTATION,
        },
        {"ADC10": "v_mem"},
        held={"v_casc": 0.9, "dc_off": 0.0, "adapt": 0.0},
    ),
}
