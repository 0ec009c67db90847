"""Verilog-A modules of the laws: parameters, and, with a compiler at hand, currents and charges."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Source, Transistor
from circuits.devices.diode import Diode, diode_arrays, diode_currents
from circuits.devices.noise import resistor_noise
from circuits.devices.source import Constant
from circuits.devices.transistor import capacitances, drain_current
from circuits.silicon.process import (
    AMI_1500,
    AMI_1500_IDEAL,
    POLARITIES,
    ROLLS_180,
    Polarity,
    Process,
    kelvin,
)
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.analysis import noise_sources
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench
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


SIZE = {"w": WIDTH, "l": LENGTH, "m": MULTIPLICITY}


def compiled_residuals(
    text: str, v: Mapping[str, float], parameters: Mapping[str, float], temperature_c: float, folder: Path
) -> list[tuple[float, float]]:
    """Residuals (current, charge) of a module's nodes, by the compiler, at voltages of its nodes."""
    compiler = pytest.importorskip("openvaf_py", reason="no Verilog-A compiler: pip install openvaf-py")
    path = folder / "law.va"
    path.write_text('`include "disciplines.vams"\n' + text)
    (module,) = compiler.compile_va(str(path))
    branches = {
        name: v[name[2]] - (v[name[4]] if "," in name else 0.0)
        for name, kind in zip(module.param_names, module.param_kinds, strict=True)
        if kind == "voltage"
    }
    given = {"mfactor": 1.0, "$temperature": temperature_c + 273.15}
    found: list[tuple[float, float]] = module.run_init_eval(
        module.get_param_defaults() | branches | dict(parameters) | given
    )[0]
    return found


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
    assert float(given["temperature_c"]) < -273.15  # the simulator's holds
    assert text == module_text(TRANSISTORS[polarity], Silicon(PROCESSES["ekv-gamma"], 80.0))
    assert "parameter real gamma = 0.0;" in module_text(TRANSISTORS[polarity], Silicon(AMI_1500_IDEAL))


@pytest.mark.parametrize("voltage", VOLTAGES)
@pytest.mark.parametrize("process", PROCESSES)
@pytest.mark.parametrize("polarity", POLARITIES)
def test_compiled_modules_have_our_currents_and_charges(
    polarity: Polarity, process: str, voltage: tuple[float, ...], tmp_path: Path
) -> None:
    """OpenVAF's residuals: currents into d, g, s, b and their charges. Digits: ln(1 + y) loses 2e-11."""
    silicon = Silicon(PROCESSES[process], 40.0)
    sign = 1.0 if polarity == "n" else -1.0
    v = dict(zip("dgsb", (sign * x for x in voltage), strict=True))
    own = {"delta_v_t0": 0.01, "delta_beta": -0.1}
    text = module_text(TRANSISTORS[polarity], silicon)
    residuals = compiled_residuals(text, v, SIZE | own, 40.0, tmp_path)
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


@pytest.mark.parametrize("degrees", [-20.0, 27.0, 85.0])
@pytest.mark.parametrize("voltage", VOLTAGES)
@pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500, ROLLS_180], ids=["ideal", "ami", "rolls"])
@pytest.mark.parametrize("polarity", POLARITIES)
def test_noise_is_the_solver_s_at_the_simulator_s_temperature(
    polarity: Polarity, process: Process, voltage: tuple[float, ...], degrees: float, tmp_path: Path
) -> None:
    """The compiler names noise and does not evaluate it: each density contributes as a current instead."""
    sign, top = (1.0 if polarity == "n" else -1.0), process.v_dd / 5.0
    v = dict(zip("dgsb", (sign * top * x for x in voltage), strict=True))
    device = Transistor("m", polarity, *"dgsb", WIDTH, LENGTH, MULTIPLICITY)
    ports = tuple(Port(n, "analog") for n in "dgsb")
    bench = Testbench(
        "t", Circuit("lone", ports, (device,)), tuple(Source(n, n, Constant(x)) for n, x in v.items()), 1e-3
    )
    found = noise_sources(operating_point(bench, Silicon(process, degrees)))
    expected = [*found.white.tolist(), found.flicker[0]]
    text = module_text(TRANSISTORS[polarity], Silicon(process))
    names = ["white", "shot_d", "shot_s"][: len(found.white)]
    for name, density in zip([*names, "flicker"], expected, strict=True):
        alone, count = re.subn(rf"<\+ \w+_noise\({name}\b[^;]*;", f"<+  {name};", text)
        assert count == 1
        alone = re.sub(r"\n    I\(\w, \w\) <\+ [^ ][^;]*;", "", alone)
        into_d, _, into_s, _ = (r for r, _ in compiled_residuals(alone, v, SIZE, degrees, tmp_path))
        assert (into_s if name == "shot_s" else into_d) == pytest.approx(density, rel=1e-6, abs=0.0)
    assert expected[0] > 0.0


@pytest.mark.parametrize("voltage", [-7.0, -2.0, 0.2, 0.6])
def test_a_diode_has_our_current_and_charge(voltage: float, tmp_path: Path) -> None:
    diode = Diode(
        "d", "a", "c", 2.0, 7e-9, 1.8, 10e-12, 0.7, 0.42, 0.5, 100e-9, 6.2, 5e-3, 1.3, 1.06, 5.0, 40.0,
    )  # fmt: skip
    text = module_text("noctule_diode", Silicon(AMI_1500)).replace("anode", "a").replace("cathode", "c")
    v = {"a": voltage, "c": 0.0}
    (current, charge), back = compiled_residuals(text, v, diode.parameters(), 85.0, tmp_path)
    one = {name: np.array([value]) for name, value in diode.parameters().items()}
    at = diode_arrays(np.array([[0], [1]]), np.array([0]), one, 85.0)
    found, slope = np.zeros((2, 1)), np.zeros((2, 1))
    diode_currents(at, np.array([voltage, 0.0]), found, slope)
    assert (current, charge) == pytest.approx(tuple(found[:, 0]), rel=1e-9, abs=0.0)
    assert back == pytest.approx((-current, -charge), rel=1e-12, abs=0.0)


def test_a_resistor_makes_its_noise(tmp_path: Path) -> None:
    text = (
        module_text("noctule_resistor", Silicon(AMI_1500))
        .replace("I(a, b) <+ white_noise(", "I(a, b) <+ (")
        .replace(', "thermal")', ")")
    )
    (into_a, _), (into_b, _) = compiled_residuals(text, {"a": 0.0, "b": 0.0}, {"r": 2e6}, 85.0, tmp_path)
    assert into_a == pytest.approx(resistor_noise(np.array(2e6), kelvin(85.0)), rel=1e-9, abs=0.0)
    assert into_b == -into_a


def test_both_polarities_have_a_module() -> None:
    assert set(TRANSISTORS) == set(POLARITIES)
    assert set(TRANSISTORS.values()) < MODULES
