"""Verilog-A modules of the laws: parameters, and, with a compiler at hand, currents and charges."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.devices.transistor import capacitances, drain_current
from circuits.silicon.process import AMI_1500_IDEAL, POLARITIES, Polarity, Process
from circuits.silicon.silicon import Silicon
from netlists.verilog_a.law import MODULES, TRANSISTORS, module_text

WIDTH, LENGTH, MULTIPLICITY = 3e-6, 1.5e-6, 2.0
VOLTAGES = [(5.0, 0.4, 0.0, 0.0), (0.02, 0.9, 0.1, 0.0), (1.0, 3.0, 4.0, 0.5), (-0.1, 0.3, 0.2, 0.0)]


def varied(**figures: object) -> Process:
    return replace(
        AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, **figures), p=replace(AMI_1500_IDEAL.p, **figures)
    )  # type: ignore[arg-type]


PROCESSES = {
    "ekv": AMI_1500_IDEAL,
    "ekv-gamma": varied(law="ekv-gamma"),
    "leaking": varied(early_field=5e6, junction_leakage=1e-6, leakage_doubling=8.0),
}


@pytest.mark.parametrize("name", sorted(MODULES))
def test_a_module_is_whole_and_uses_what_it_declares(name: str) -> None:
    text = module_text(name, Silicon(AMI_1500_IDEAL))
    assert text.startswith(f"module {name}(")
    assert text.endswith("endmodule\n")
    bare = re.sub(r"//.*", "", text)
    for opening, closing in (("begin", "end"), ("(", ")"), ("analog function", "endfunction")):
        pattern = re.escape(opening) if opening == "(" else rf"\b{opening}\b"
        other = re.escape(closing) if closing == ")" else rf"\b{closing}\b"
        assert len(re.findall(pattern, bare)) == len(re.findall(other, bare))
    for parameter in re.findall(r"parameter real (\w+)", bare):
        assert len(re.findall(rf"\b{parameter}\b", bare)) > 1, f"{parameter} is not used"
    assert text.isascii()
    assert "{" not in text


@pytest.mark.parametrize("polarity", POLARITIES)
def test_parameters_are_the_process_s(polarity: Polarity) -> None:
    text = module_text(TRANSISTORS[polarity], Silicon(PROCESSES["ekv-gamma"], 40.0))
    given = dict(re.findall(r"parameter real (\w+) = (\S+?);", text))
    model = PROCESSES["ekv-gamma"].model(polarity)
    assert float(given["v_t0"]) == model.v_t0
    assert float(given["gamma"]) == model.gamma
    assert float(given["temperature_c"]) == 40.0
    assert "parameter real gamma = 0.0;" in module_text(TRANSISTORS[polarity], Silicon(AMI_1500_IDEAL))


@pytest.mark.parametrize("voltage", VOLTAGES)
@pytest.mark.parametrize("process", PROCESSES)
@pytest.mark.parametrize("polarity", POLARITIES)
def test_compiled_modules_have_our_currents_and_charges(
    polarity: Polarity, process: str, voltage: tuple[float, ...], tmp_path: Path
) -> None:
    """OpenVAF's residuals: currents into d, g, s, b and their charges. Digits: ln(1 + y) loses 2e-11."""
    compiler = pytest.importorskip("openvaf_py", reason="no Verilog-A compiler: pip install openvaf-py")
    silicon = Silicon(PROCESSES[process], 40.0)
    path = tmp_path / "law.va"
    path.write_text('`include "disciplines.vams"\n' + module_text(TRANSISTORS[polarity], silicon))
    (module,) = compiler.compile_va(str(path))
    sign = 1.0 if polarity == "n" else -1.0
    v = dict(zip("dgsb", (sign * x for x in voltage), strict=True))
    branches = {
        name: v[name[2]] - v[name[4]]
        for name, kind in zip(module.param_names, module.param_kinds, strict=True)
        if kind == "voltage"
    }
    own = {"w": WIDTH, "l": LENGTH, "m": MULTIPLICITY, "delta_v_t0": 0.01, "delta_beta": -0.1, "mfactor": 1.0}
    residuals, _ = module.run_init_eval(module.get_param_defaults() | branches | own | {"$temperature": 1.0})
    law = silicon.law(polarity)
    law = replace(law, v_t0=law.v_t0 + 0.01, square_current=law.square_current * 0.9)
    into_d, into_s = (
        float(drain_current(law, polarity, WIDTH * MULTIPLICITY, LENGTH, v[a], v["g"], v[b], v["b"])[0])
        for a, b in (("d", "s"), ("s", "d"))
    )
    resist = [r for r, _ in residuals]
    assert resist[0] == pytest.approx(into_d, rel=1e-9)
    assert resist[2] == pytest.approx(into_s, rel=1e-9)
    assert resist[1] == 0.0
    assert sum(resist) == pytest.approx(0.0, abs=1e-9 * abs(into_d))
    size = [[x] for x in (WIDTH, LENGTH, MULTIPLICITY)]
    charge = [0.0] * 4
    for (i, j), c in capacitances(silicon.process.model(polarity), *map(np.array, size)).items():
        q = float(c[0]) * (v["dgsb"[i]] - v["dgsb"[j]])
        charge[i] += q
        charge[j] -= q
    assert [q for _, q in residuals] == pytest.approx(charge, rel=1e-12)


def test_both_polarities_have_a_module() -> None:
    assert set(TRANSISTORS) == set(POLARITIES)
    assert set(TRANSISTORS.values()) < MODULES
