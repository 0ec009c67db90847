"""ngspice's rawfile: a round trip, and the same numbers in ngspice itself and in spicelib."""

from pathlib import Path

import numpy as np
import pytest
from spicelib import RawRead

from circuits.circuit import Circuit, InstanceArray, Node, Port
from circuits.devices import Capacitor, Resistor, Source
from circuits.devices.source import PiecewiseLinear
from circuits.errors import DataError
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from netlists.ngspice import engine
from netlists.ngspice.library import _open, find_library
from netlists.ngspice.raw import RawFile, format_raw, read_raw, write_raw


def bench() -> Testbench:
    """Two low-passes in an array, so that arrays and inner nodes have names."""
    inner = Circuit(
        "stage",
        (Port("a", "analog"), Port("y", "analog", "out")),
        (Resistor("r1", "a", "mid", 1e3), Resistor("r2", "mid", "y", 1e3), Capacitor("c", "y", "0", 1e-9)),
    )
    array = InstanceArray("stage", inner, (2,), {"a": "a", "y": "y"})
    circuit = Circuit("pair", (Port("a", "analog"),), (), (array,), (Node("y", (2,)),))
    drive = Source("a", "a", PiecewiseLinear((1e-6, 1.1e-6), (0.0, 5.0)))
    return Testbench("a pair\nof stages", circuit, (drive,), 10e-6)


NAMES = ("time", "v(a)", "v(xpair.y#0)", "v(xpair.y#1)", "v(xpair.xstage#0.mid)", "v(xpair.xstage#1.mid)")


@pytest.fixture(scope="module")
def result() -> Result:
    return simulate(bench(), Silicon())


@pytest.fixture
def path(result: Result, tmp_path: Path) -> Path:
    write_raw(result, tmp_path / "pair.raw")
    return tmp_path / "pair.raw"


def test_round_trip_is_exact(result: Result, path: Path) -> None:
    found = read_raw(path)
    assert found.title == "a pair of stages"
    assert found.plot == "Transient Analysis"
    assert found.names == NAMES
    assert found.types == ("time", *["voltage"] * 5)
    np.testing.assert_array_equal(found["time"], result.time)
    np.testing.assert_array_equal(found["V(xpair.y#1)"], result["y[1]"])
    np.testing.assert_array_equal(found["v(xpair.xstage#0.mid)"], result["stage[0].mid"])
    with pytest.raises(DataError, match=r"no variable v\(b\)"):
        found["v(b)"]


def test_the_same_run_gives_the_same_bytes(path: Path, tmp_path: Path) -> None:
    write_raw(simulate(bench(), Silicon()), tmp_path / "again.raw")
    assert (tmp_path / "again.raw").read_bytes() == path.read_bytes()


def test_spicelib_reads_it_and_knows_whose_format_it_is(result: Result, path: Path) -> None:
    found = RawRead(path, verbose=False)
    assert found.dialect == "ngspice"
    assert tuple(found.get_trace_names()) == NAMES
    np.testing.assert_array_equal(found.get_trace("time").get_wave(), result.time)
    np.testing.assert_array_equal(found.get_trace("v(xpair.y#1)").get_wave(), result["y[1]"])


@pytest.mark.usefixtures("ngspice_library")
def test_ngspice_loads_it(result: Result, path: Path) -> None:
    library = _open(find_library())
    library.clear_output()
    library.command(f"load {path}")
    plot = library.current_plot()
    try:
        assert library.errors == []
        assert set(library.vector_names(plot)) == set(NAMES)
        np.testing.assert_array_equal(library.copy_vector(plot, "time"), result.time)
        np.testing.assert_array_equal(library.copy_vector(plot, "v(xpair.y#1)"), result["y[1]"])
    finally:
        library.command("destroy all")


@pytest.mark.usefixtures("ngspice_library")
def test_what_ngspice_writes_has_the_same_names(path: Path, tmp_path: Path) -> None:
    library = _open(find_library())
    library.command(f"load {path}")
    library.command(f"write {tmp_path / 'theirs.raw'}")
    library.command("destroy all")
    theirs, ours = read_raw(tmp_path / "theirs.raw"), read_raw(path)
    assert set(theirs.names) == set(ours.names)
    for name in NAMES:
        np.testing.assert_array_equal(theirs[name], ours[name])


@pytest.mark.usefixtures("ngspice_library")
def test_a_run_of_ngspice_is_written_too(tmp_path: Path) -> None:
    run = engine.simulate(bench(), Silicon())
    write_raw(run, tmp_path / "run.raw")
    found = read_raw(tmp_path / "run.raw")
    assert found.names == NAMES
    np.testing.assert_array_equal(found["v(xpair.y#0)"], run["y[0]"])


GOOD = format_raw(RawFile("t", "p", ("time", "v(a)"), ("time", "voltage"), np.zeros((3, 2))))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "no line Binary"),
        (GOOD[:-8], "40 bytes of points, must be 48"),
        (GOOD + GOOD, "more than one plot"),
        (GOOD.replace(b"Flags: real", b"Flags: complex"), "must be real"),
        (GOOD.replace(b"No. Points: 3", b"No. Points: many"), "no. points many"),
        (GOOD.replace(b"No. Variables: 2", b"No. Variables: 3"), "2 variables listed, must be 3"),
        (GOOD.replace(b"Variables:\n\t0", b"\t0"), "must be NAME: VALUE"),
        (b"Title: t\nFlags: real\nBinary:\n", "no line Variables"),
        (b"\xff\xfe\x00\nBinary:\n", "must be NAME: VALUE"),
    ],
)
def test_what_is_no_rawfile_is_refused_in_one_line(data: bytes, words: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.raw"
    path.write_bytes(data)
    with pytest.raises(DataError, match=words) as refused:
        read_raw(path)
    assert "\n" not in str(refused.value)
    assert str(path) in str(refused.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"none\.raw: cannot be read"):
        read_raw(tmp_path / "none.raw")
