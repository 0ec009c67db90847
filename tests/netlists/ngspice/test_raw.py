"""ngspice's rawfile: the same numbers in spicelib and in ngspice itself."""

from pathlib import Path

import numpy as np
import pytest
from spicelib import RawRead

from circuits.arrays import F64
from circuits.circuit import Circuit, InstanceArray, Node, Port
from circuits.devices import Capacitor, Resistor, Source
from circuits.devices.source import PiecewiseLinear
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from netlists.ngspice import engine
from netlists.ngspice.library import _open, find_library
from netlists.ngspice.raw import write_raw


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


def wave(file: RawRead, name: str) -> F64:
    return file.get_trace(name).get_wave()


@pytest.fixture(scope="module")
def result() -> Result:
    return simulate(bench(), Silicon(AMI_1500_IDEAL))


@pytest.fixture
def path(result: Result, tmp_path: Path) -> Path:
    write_raw(result, tmp_path / "pair.raw")
    return tmp_path / "pair.raw"


def test_the_same_run_gives_the_same_bytes(path: Path, tmp_path: Path) -> None:
    write_raw(simulate(bench(), Silicon(AMI_1500_IDEAL)), tmp_path / "again.raw")
    assert (tmp_path / "again.raw").read_bytes() == path.read_bytes()


def test_spicelib_reads_it_and_knows_whose_format_it_is(result: Result, path: Path) -> None:
    found = RawRead(path, verbose=False)
    assert found.dialect == "ngspice"
    assert tuple(found.get_trace_names()) == NAMES
    properties = found.get_raw_properties()
    assert properties["Title"] == "a pair of stages"
    assert properties["Plotname"] == "Transient Analysis"
    np.testing.assert_array_equal(wave(found, "time"), result.time)
    np.testing.assert_array_equal(wave(found, "v(xpair.y#1)"), result["y[1]"])
    np.testing.assert_array_equal(wave(found, "v(xpair.xstage#0.mid)"), result["stage[0].mid"])


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
    theirs, ours = (
        RawRead(file, dialect="ngspice", verbose=False) for file in (tmp_path / "theirs.raw", path)
    )
    assert set(theirs.get_trace_names()) == set(ours.get_trace_names()) == set(NAMES)
    for name in NAMES:
        np.testing.assert_array_equal(wave(theirs, name), wave(ours, name))


@pytest.mark.usefixtures("ngspice_library")
def test_a_run_of_ngspice_is_written_too(tmp_path: Path) -> None:
    run = engine.simulate(bench(), Silicon(AMI_1500_IDEAL))
    write_raw(run, tmp_path / "run.raw")
    found = RawRead(tmp_path / "run.raw", verbose=False)
    assert tuple(found.get_trace_names()) == NAMES
    np.testing.assert_array_equal(wave(found, "v(xpair.y#0)"), run["y[0]"])
