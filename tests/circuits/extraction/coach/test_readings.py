"""Which readings may be fitted, what sweeps share, and that a sweep is solved as it is lowered."""

from __future__ import annotations

import math

import numpy as np

from circuits.blocks.bench.differential_pair import build
from circuits.blocks.drive import driven
from circuits.extraction.coach.bench import Bench, lowered, solved, swept
from circuits.extraction.coach.conditions import read_conditions
from circuits.extraction.coach.models import unknowns_of
from circuits.extraction.coach.readings import fet
from circuits.extraction.coach.readings.converter import bit_weights
from circuits.extraction.coach.table import read_folder
from circuits.extraction.coach.unknown import Theta, before
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench

KNOWN = read_conditions()
FIT = read_folder(None, "fit")
MEANS = before(unknowns_of(KNOWN, ROLLS_180)).values()


def test_a_floor_that_rises_above_the_dead_zone_is_no_current() -> None:
    for name, column, beyond in (("fet_p_ohmic_vg", "i_d_A", 0.85), ("fet_n_sat_vg", "i_s_A", 0.75)):
        condition, table = FIT[name]
        kept, gate = fet.usable(condition, table)[column], table["v_g_V"]
        sign = 1.0 if name.startswith("fet_n") else -1.0
        assert (sign * gate[kept] >= sign * beyond).all()
        # some reading beyond the threshold, where the floor is, reads more than the dead zone all the same
        assert (table[column][sign * gate < sign * beyond] > 3e-6).any()


def test_sweeps_of_an_ammeter_share_its_offset_and_lines_their_splitter() -> None:
    moved = Bench(Theta({**MEANS, "fet_n ammeter high": MEANS["fet_n ammeter high"] + 1e-6}), ROLLS_180)
    still = Bench(Theta(MEANS), ROLLS_180)
    for name, off in (("fet_n_ohmic_vg", 1e-6), ("fet_n_sat_vg", 1e-6), ("fet_n_sub_vg", 0.0)):
        one, other = (fet.predict(bench, *FIT[name])["i_s_A"] for bench in (moved, still))
        assert np.allclose(one - other, off, atol=1e-12)
    values = {**MEANS, "splitter bit 5": 0.94}
    assert all(bit_weights(values, line)[5] == 0.94 for line in ("NDP_VB_N", "WTA 460 pA"))


def test_a_sweep_that_is_kept_is_the_one_that_is_lowered() -> None:
    circuit, silicon = build(), Silicon(ROLLS_180, 40.0)
    sources = driven({"v1": 0.9, "v2": 0.9, "i1": 1.3, "i2": 1.3, "v_tail": 0.45})
    over = {"v1": np.linspace(0.85, 0.95, 5)}
    plain = swept(lowered(Testbench("pair", circuit, sources, math.inf), silicon), over)
    found = solved(circuit, sources, silicon, over)
    assert solved(circuit, sources, silicon, over) is found
    for name, current in plain.current.items():
        np.testing.assert_array_equal(found.current[name], current)
