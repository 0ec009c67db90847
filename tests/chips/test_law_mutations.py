"""A law that is changed in its source makes all records and codes of chips refuse by name, before any run.

A mutation is a text of a module and what stands there instead. The changed module is executed, and the code
of its functions takes the place of theirs; constants are replaced wherever they were imported. Machine code
cannot be changed so: the kernels of the transistor run as the Python that they are written in, which a
test holds against the machine code. `softplus`, whose Python has no meaning, is left out.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, NamedTuple

import pytest

from chips import law_lattice, record
from chips.codes import Codes
from chips.law_lattice import changed, key_changed, law_key, law_of
from chips.measured.table_record import _kept
from chips.model import MODELS
from chips.ranging.chip import shipped_model
from chips.record import kept_record, read_record
from chips.record_file import shipped_file
from circuits.compiled import Kernel
from circuits.devices import transistor
from circuits.errors import DataError
from circuits.generator.voltage import (
    joined_network,
    line_network,
    lines_at_rest,
    masters_at_rest,
    masters_network,
    resistor_of,
    voltages_known,
)
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.cli.command_line import main
from system.codes import find
from system.codes.file import read_codes
from system.registry import calibration_names, load_calibration
from system.system import DRAWN


class Mutation(NamedTuple):
    """What is changed: a module's text, what stands there instead, and the families that move at least.

    spares: names of processes whose full law it leaves as it is, and so the codes of their chips.
    """

    module: str
    text: str
    instead: str
    moves: tuple[str, ...]
    spares: tuple[str, ...] = ()


JUNCTION, BIAS = ("junction",), ("bias",)
FAR = ("rolls-180",)  # whose supply forward biases no junction of the lattice by 20 U_T
BENT = ("ami-1500", "rolls-180")  # kappa is not constant
GENERATOR = "circuits.generator.circuit"
TRANSISTOR, PROCESS, DIE = "circuits.devices.transistor", "circuits.silicon.process", "circuits.silicon.die"
OVERLAP = Mutation(
    TRANSISTOR,
    "model.overlap_capacitance * w, model.junction_capacitance * w",
    "2.0 * model.overlap_capacitance * w, 4.0 * model.junction_capacitance * w",
    ("capacitance",),
)
MUTATIONS = (
    OVERLAP,
    Mutation(TRANSISTOR, "gate_bulk = model", "gate_bulk = 1.01 * model", ("capacitance",)),
    Mutation(TRANSISTOR, "(ff + fr), 2.0", "(ff + 1.001 * fr), 2.0", ("current",)),
    Mutation(TRANSISTOR, "channel = a.specific", "channel = 1.001 * a.specific", ("current",), BENT),
    Mutation(TRANSISTOR, "w.kappa[i] * by_pinch", "by_pinch", ("slope",)),
    Mutation(TRANSISTOR, "- e * max(-y - FORWARD, 0.0)", "", JUNCTION, FAR),
    Mutation(TRANSISTOR, "-scale * mobility", "-scale", ("slope",)),
    Mutation(TRANSISTOR, "induced * a.induced_per_volt[i]", "induced", ("junction_slope",)),
    Mutation(TRANSISTOR, "v_t0=law.v_t0 + delta_v_t", "v_t0=law.v_t0 - delta_v_t", ("current",)),
    Mutation(PROCESS, "ratio**model", "ratio**1.01**model", ("temperature", "current")),
    Mutation(PROCESS, "v_t0_drift * rise", "v_t0_drift * (rise + 0.1)", ("temperature",)),
    Mutation(PROCESS, "2.0 ** (rise", "2.1 ** (rise", ("temperature", "junction")),
    Mutation(PROCESS, "(1.0 / self.kappa - 1.0)", "(1.0 / self.kappa)", ("temperature",)),
    Mutation(PROCESS, "= 1.380649e-23  # J/K", "= 1.3806e-23", ("temperature", "current")),
    Mutation(PROCESS, "= 273.15", "= 273.0", ("temperature", "bias")),
    Mutation(DIE, "np.sqrt(2.0 * np.asarray(area))", "np.sqrt(np.asarray(area))", ("mismatch",)),
    Mutation(DIE, 'person=b"noctule-die"', 'person=b"die"', ("mismatch", "bias")),
    Mutation(DIE, "v_t0 * variation", "1.1 * v_t0 * variation", ("mismatch", "bias")),
    Mutation("circuits.silicon.silicon", "pair_a_vt / root", "pair_a_vt / area", ("mismatch",)),
    Mutation("circuits.devices.channel", "dtype=np.float64) / law.kappa", "dtype=np.float64)", BIAS, BENT),
    Mutation("circuits.bias", "kelvin(silicon.temperature_c) / kelvin(reference)", "1.0", ("bias",)),
    Mutation("circuits.devices.ekv", "0.5 * np.asarray(u,", "0.51 * np.asarray(u,", ("closed_form",)),
    Mutation("circuits.devices.pinch_off", "* height)", "+ height)", ("closed_form",)),
    Mutation("circuits.event", "WIDTH = 10e-6", "WIDTH = 11e-6", ("event",)),
    Mutation("circuits.units", '"f": -15', '"f": -16', ("unit",)),
    Mutation(GENERATOR, "ratio = tap * sum", "ratio = 1.0001 * tap * sum", ("generator",)),
    Mutation(GENERATOR, "MASTER_CURRENT = 0.4e-6", "MASTER_CURRENT = 0.4001e-6", ("generator",)),
    Mutation(GENERATOR, "_CORE_P, total)", "_CORE_P, 1.0001 * total)", ("generator",)),
    Mutation(GENERATOR, '"mfe1", "n", ("vdd", "vdd"', '"mfe1", "n", ("vdd", "0"', ("generator",)),
)  # fmt: skip


@pytest.fixture(scope="module")
def shipped() -> dict[Path, record.Record]:
    """Shipped records, which are read from their files once."""
    paths = [shipped_file(name, process) for name in MODELS for process in (AMI_1500, AMI_1500_IDEAL)]
    return {path: read_record(path) for path in paths}


@pytest.fixture(scope="module")
def coded() -> dict[tuple[str, Silicon], Codes]:
    """Shipped codes by chip and silicon, which are read from their files once."""
    chips = [name for name in calibration_names() if name != "pushbot-modified"]  # whose codes do not ship
    wanted = [
        (name, Silicon(load_calibration(name).process, die=Die(number=number)))
        for name in chips
        for number in (None, DRAWN)
    ]
    found = {each: read_codes(find.shipped_file(*each)) for each in wanted}
    for _, silicon in found:
        law_key(silicon.process)  # the generator's machine code, which stays, is that of the law as it is
    return found


@pytest.fixture
def in_python(
    shipped: dict[Path, record.Record],
    coded: dict[tuple[str, Silicon], Codes],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> Iterator[None]:
    """The law is evaluated by Python, nothing of it is remembered, and records and codes come from memory."""
    files = {find.shipped_file(*each): codes for each, codes in coded.items()}
    monkeypatch.setattr(find, "read_codes", files.__getitem__)
    monkeypatch.setattr(find, "cached_file", lambda *_: tmp_path / "none")
    monkeypatch.setattr(record, "read_record", shipped.__getitem__)
    monkeypatch.setattr(law_lattice, "drain_currents", _python(transistor.drain_currents))
    for name in ("_bend", "_channels", "_affected_channels", "_junction_currents", "_induce"):
        monkeypatch.setattr(transistor, name, _python(getattr(transistor, name)))
    caches = (
        law_of, law_key, kept_record, _kept, shipped_model, find._usable,
        line_network, joined_network, lines_at_rest, masters_at_rest, masters_network, resistor_of,
        voltages_known,
    )  # fmt: skip
    for each in caches:
        each.cache_clear()
    yield
    for each in caches:
        each.cache_clear()


@pytest.mark.usefixtures("in_python")
def test_the_law_in_python_is_that_of_the_machine_code(coded: dict[tuple[str, Silicon], Codes]) -> None:
    for (_, silicon), codes in coded.items():
        assert key_changed(codes.law, silicon.process) == ""
    for name in MODELS:
        law = kept_record(name.replace("-", "_")).law
        assert law is not None
        assert changed(law) == ""


@pytest.mark.usefixtures("in_python")
@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda m: f"{m.module}: {m.text}")
def test_a_mutation_makes_every_record_and_all_codes_stale(
    mutation: Mutation, coded: dict[tuple[str, Silicon], Codes], monkeypatch: pytest.MonkeyPatch
) -> None:
    mutate(mutation, monkeypatch)
    for name, silicon in coded:
        if silicon.process.name in mutation.spares:
            find.codes_on(name, silicon, "generator")
            continue
        with pytest.raises(DataError, match=f"codes of {name}, .* of another law of ") as told:
            find.codes_on(name, silicon, "generator")
        assert set(mutation.moves) <= set(families_of(told.value))
        die = "" if silicon.die.number is None else f" die={DRAWN}"
        assert str(told.value).endswith(f"; run noctule calibrate {name}{die}")
    for name in MODELS if mutation.module != GENERATOR else ():  # by whose circuit no record is measured
        block = name.replace("-", "_")
        with pytest.raises(
            DataError, match=f"{block}: its record is of another law of .*run noctule"
        ) as told:
            kept_record(block)
        assert set(mutation.moves) <= set(families_of(told.value))
        assert str(told.value).endswith(f"characterise {name}")


@pytest.mark.usefixtures("in_python")
def test_a_mutation_is_told_before_a_run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    mutate(OVERLAP, monkeypatch)
    assert main(["run", "approach", "--level", "behavioural", "--codes", "default", "--json"]) == 2
    out, err = capsys.readouterr()
    assert "another law of capacitance; run noctule characterise" in err
    assert not out
    assert main(["run", "forest", "--ranges", "exact", "--codes", "default", "--json"]) == 2
    # a closed form, whose errors are kept
    assert "winner_take_all_full: its record is of another law of capacitance" in capsys.readouterr().err
    assert main(["run", "rolls", "--json"]) == 2  # a closed form, which has no record
    out, err = capsys.readouterr()
    said = "codes of rolls, die A/1000: of another law of capacitance; run noctule calibrate rolls"
    assert err.endswith(f"{said} --die 1000 --update-package\n")
    assert not out


def families_of(error: DataError) -> list[str]:
    """What an error says of which there is another law."""
    return str(error).partition("another law of ")[2].partition(";")[0].split(", ")


def mutate(mutation: Mutation, monkeypatch: pytest.MonkeyPatch) -> None:
    """Put a mutation in force until the test ends."""
    module = import_module(mutation.module)
    source = Path(str(module.__file__)).read_text(encoding="utf-8")
    assert source.count(mutation.text) == 1, "the mutation's text is to be found once in its module"
    new = {"__name__": mutation.module, "__file__": module.__file__}
    exec(compile(source.replace(mutation.text, mutation.instead), str(module.__file__), "exec"), new)  # noqa: S102
    replaced = list(_replaced(vars(module), new, monkeypatch))
    assert replaced, "the mutation changes something"


def _replaced(old: dict[str, Any], new: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Replace the code of functions, those of classes too, and constants; yield the names of both."""
    for name, value in list(old.items()):
        other = new.get(name)
        if isinstance(value, type) and value.__module__ == old.get("__name__"):
            yield from _replaced(dict(vars(value)), dict(vars(other)), monkeypatch)
        elif isinstance(value, property):
            yield from _code(name, value.fget, other.fget, monkeypatch)  # type: ignore[union-attr]
        elif isinstance(value, FunctionType | Kernel):
            yield from _code(name, _python(value), _python(other), monkeypatch)
        elif isinstance(value, float | dict) and not name.startswith("__") and value != other:
            for each in _ours():
                if vars(each).get(name) is value:
                    monkeypatch.setattr(each, name, other)
            yield name


def _code(name: str, old: Any, new: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    if old.__module__ == new.__module__ and old.__code__ != new.__code__:
        monkeypatch.setattr(old, "__code__", new.__code__)
        yield name


def _python(function: Any) -> Callable[..., Any]:
    found: Callable[..., Any] = getattr(function, "py_func", function)
    return found


def _ours() -> list[ModuleType]:
    return [module for name, module in sys.modules.items() if name.startswith(("circuits.", "chips."))]
