"""`noctule simulate --verilog-a`: models in the place of a deck's transistors."""

import json
from pathlib import Path

import pytest

from circuits.silicon.process import AMI_1500, POLARITIES
from circuits.silicon.silicon import Silicon
from netlists.verilog_a.law import TRANSISTORS, module_text
from system.cli.command_line import main

pytest.importorskip("openvaf_py", reason="no Verilog-A compiler: pip install openvaf-py")
DECK = """an inverter
.model n nmos
.model p pmos
vdd vdd 0 5
va a 0 pwl(0 0 10n 0 11n 5)
mn y a 0 0 n w=6u l=3u
mp y a vdd vdd p w=12u l=3u
c y 0 1p
.tran 1n 30n
"""
FALL = "t = cross(y, 2.5, fall) - cross(a, 2.5)"


def test_our_own_law_as_verilog_a_has_the_solver_s_delay(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for polarity in POLARITIES:
        text = '`include "disciplines.vams"\n' + module_text(TRANSISTORS[polarity], Silicon(AMI_1500))
        (tmp_path / f"{polarity}.va").write_text(text)
    models, deck = tmp_path / "models.toml", tmp_path / "inv.cir"
    models.write_text("".join(f'[{p}]\nfile = "{p}.va"\nmultiplicity = "m"\n' for p in POLARITIES))
    deck.write_text(DECK)
    found = []
    for more in ([], ["--verilog-a", str(models), "--rtol", "1e-4"]):
        assert main(["simulate", str(deck), "--measure", FALL, *more, "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert found[1]["engine"] == f"native, on {models}"
    assert found[1]["measured"][0]["value"] == pytest.approx(found[0]["measured"][0]["value"], rel=2e-3)
    for refused, says in (
        (["--engine", "ngspice"], "leave one out"),
        (["--die", "1000"], "have no dies here"),
    ):
        assert main(["simulate", str(deck), "--verilog-a", str(models), *refused]) == 2
        assert says in capsys.readouterr().err
