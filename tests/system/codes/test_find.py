"""Codes of a chip are found once, kept by all that they depend on, and found anew after a change."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Event
from time import sleep

import pytest

from chips.codes import Calibration, Codes, codes_begun
from circuits.circuit import BiasKind
from circuits.errors import DataError, ParameterError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.codes import find
from system.codes.file import write_codes
from system.registry import calibration_line, calibration_names, load_calibration


@dataclass
class Bench:
    """A bench that counts its chips."""

    chips: list[tuple[Silicon, BiasKind, object]] = field(default_factory=list)
    failed: str = ""

    def __call__(self, silicon: Silicon, kind: BiasKind, setup: object) -> Codes:
        self.chips.append((silicon, kind, setup))
        codes = codes_begun("mine", silicon, kind, setup)  # type: ignore[arg-type]
        return replace(codes, biases={"i_one": ((5, 128),)}, failed=self.failed)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Bench:
    made = Bench()

    calibration = Calibration("mine", "a chip", AMI_1500, made, "usual")
    monkeypatch.setattr(find, "load_calibration", lambda _: calibration)
    monkeypatch.setattr(find, "codes_folder", lambda: tmp_path)
    find._usable.cache_clear()
    return made


SILICON = Silicon(die=Die(number=1003))


def test_a_chip_is_calibrated_once_a_machine(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    first = find.codes_on("mine", SILICON, "generator")
    find._usable.cache_clear()  # another process
    assert find.codes_on("mine", SILICON, "generator") == first
    assert bench.chips == [(SILICON, "generator", "usual")]
    assert capsys.readouterr().err == "noctule: calibrating mine on die A/1003 at 27 degC, once\n"


def test_a_chip_that_is_asked_for_by_several_at_once_is_calibrated_once(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inside = Event()

    def slow(*asked: object) -> Codes:
        inside.set()
        sleep(0.1)  # s, in which the others come to wait
        return bench(*asked)  # type: ignore[arg-type]

    monkeypatch.setattr(find, "load_calibration", lambda _: Calibration("mine", "a chip", AMI_1500, slow))
    with ThreadPoolExecutor(3) as executor:
        first = executor.submit(find.codes_on, "mine", SILICON, "generator")
        assert inside.wait(10.0)
        others = [executor.submit(find.codes_on, "mine", SILICON, "generator") for _ in range(2)]
    assert all(each.result() == first.result() for each in others)
    assert len(bench.chips) == 1
    assert [path.suffix for path in tmp_path.iterdir()] == [".toml"]


def test_another_die_temperature_kind_or_setup_is_calibrated_by_itself(bench: Bench) -> None:
    find.codes_on("mine", SILICON, "generator")
    find.codes_on("mine", replace(SILICON, die=Die(number=1004)), "generator")
    find.codes_on("mine", replace(SILICON, temperature_c=30.0), "generator")
    find.codes_on("mine", SILICON, "ideal")
    find.codes_on("mine", SILICON, "generator", "another")
    assert len(bench.chips) == 5


def test_shipped_codes_of_another_law_are_refused_until_the_die_is_calibrated_anew(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    shipped = tmp_path / "shipped.toml"
    monkeypatch.setattr(find, "shipped_file", lambda *_: shipped)
    codes = find.calibrated_anew("mine", SILICON, "generator")
    write_codes(shipped, codes)
    assert find.codes_on("mine", SILICON, "generator") == codes
    write_codes(shipped, replace(codes, law={**codes.law, "generator": (0.0, 0.0)}))
    find._usable.cache_clear()
    says = "mine, die A/1003: of another law of generator; run noctule calibrate mine die=1003$"
    with pytest.raises(DataError, match=says):
        find.codes_on("mine", SILICON, "generator")
    assert find.kept_anew("mine", SILICON, "generator") == find.codes_on("mine", SILICON, "generator")


def test_a_chip_that_cannot_be_calibrated_is_refused_and_tried_each_time(bench: Bench) -> None:
    """Where its box is not asked to refuse, or its circuit has changed, the same chip may work."""
    bench.failed = "it is deaf"
    for _ in range(2):
        with pytest.raises(ParameterError, match="could not be calibrated, it is deaf"):
            find.codes_on("mine", SILICON, "generator")
    bench.failed = ""
    assert find.codes_on("mine", SILICON, "generator").failed == ""
    assert len(bench.chips) == 3


def test_every_calibration_is_listed_with_its_own_summary() -> None:
    for name in calibration_names():
        found = load_calibration(name)
        assert (found.name, found.summary) == (name, calibration_line(name))


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="latency-chip"):
        load_calibration("latency-chp")
