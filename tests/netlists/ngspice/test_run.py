"""ngspice runs: closed forms, failures in ngspice's own words, recovery, flat memory."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.errors import SimulatorError, UnknownNameError
from netlists.ngspice import library as ngspice_library
from netlists.ngspice import run as ngspice
from netlists.ngspice.library import _open, find_library
from tests.refusals import refusals

ACCURATE = ".options gmin=1e-15 abstol=1e-15 chgtol=1e-17 reltol=1e-4 method=gear"
RC = f"""step
v1 in 0 pulse(0 1 0 1e-9 1e-9 1 2)
r1 in OUT 1000.0
c1 out 0 1e-06
{ACCURATE}
.tran 1e-05 0.005 0 1e-05
.end
"""
DIVIDER = "divider\nv1 a 0 3\nr1 a 1 1000.0\nr2 1 0 2000.0\n{analysis}\n.end\n"
LONG_RC = RC.replace("0.005 0 1e-05", "100.0 0 1e-06")

pytestmark = pytest.mark.usefixtures("ngspice_library")


def test_rc_step_follows_the_closed_form() -> None:
    waveforms = ngspice.run(RC)
    time, out = waveforms.axis, waveforms.values["out"]
    assert (waveforms.analysis, waveforms.axis_name) == ("tran", "time")
    assert waveforms.steps == len(time) == len(out) > 500
    assert time[-1] == pytest.approx(5e-3)
    # Gear of order 2 with reltol 1e-4 and steps of a hundredth of the time constant: 1e-4 of the step.
    np.testing.assert_allclose(out, -np.expm1(-time / 1e-3), atol=1e-4)


def test_dc_sweep_has_an_axis_and_branch_currents() -> None:
    waveforms = ngspice.run(DIVIDER.format(analysis=".dc v1 0 3 0.5"))
    assert (waveforms.analysis, waveforms.axis_name, waveforms.steps) == ("dc", "v-sweep", 7)
    np.testing.assert_allclose(waveforms.axis, np.arange(0.0, 3.1, 0.5), atol=1e-12)
    np.testing.assert_allclose(waveforms.values["1"], waveforms.axis * 2 / 3, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(waveforms.values["v1#branch"], -waveforms.axis / 3000, rtol=1e-6, atol=1e-12)


def test_operating_point_has_no_axis() -> None:
    waveforms = ngspice.run(DIVIDER.format(analysis=".save all @r1[i]\n.op"))
    assert (waveforms.analysis, waveforms.axis_name, waveforms.steps) == ("op", "", 1)
    assert waveforms.axis.size == 0
    assert list(waveforms.values) == ["a", "1", "v1#branch", "@r1[i]"]
    assert waveforms.values["@r1[i]"] == pytest.approx([1e-3])


def test_only_the_vectors_asked_for_are_read() -> None:
    assert list(ngspice.run(RC, vectors=("out",)).values) == ["out"]
    with pytest.raises(UnknownNameError, match=r"vector nowhere: unknown; known are in, out, v1#branch"):
        ngspice.run(RC, vectors=("nowhere",))


def test_arrays_survive_later_runs() -> None:
    first = ngspice.run(RC)
    kept = first.values["out"].copy()
    ngspice.run(RC.replace("1000.0", "5000.0"))
    np.testing.assert_array_equal(first.values["out"], kept)


def test_an_empty_title_does_not_eat_the_first_element() -> None:
    deck = DIVIDER.format(analysis=".op").replace("divider", "")
    assert ngspice.run(deck).values["1"] == pytest.approx([2.0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("c1 out 0 1e-06", "c1 out 0 much"), r"line 4 .*unknown parameter \(much\)"),
        (("c1 out 0 1e-06", "x1 out nosuch"), "unknown subckt: x1 out nosuch"),
        (("c1 out 0 1e-06", "b1 out 0 i=nosuch(v(out))"), "no such function 'nosuch'"),
        (("c1 out 0 1e-06", "c1 out 0 {undefined}"), r"Undefined parameter \[undefined\]"),
        (("c1 out 0 1e-06", ".include /no/such/file"), "Could not find include file /no/such/file"),
        (("c1 out 0 1e-06", "v2 in 0 1"), r"singular matrix: check node v\d#branch"),
        (("c1 out 0 1e-06", "c1 out 0 1e-12\n.ic v(out)=1\nb1 out 0 i=-1e3*v(out)^3"), "Timestep too small"),
        (("c1 out 0 1e-06", "c1 out 0 1e-06\n.save nosuch"), "no data saved"),
    ],
)
def test_a_failing_deck_raises_in_one_line_and_the_library_recovers(
    change: tuple[str, str], message: str
) -> None:
    with pytest.raises(SimulatorError, match=message) as caught:
        ngspice.run(RC.replace(*change))
    assert "\n" not in str(caught.value)
    assert ngspice.run(RC).axis[-1] == pytest.approx(5e-3)


test_a_deck_that_cannot_be_checked_is_refused = refusals(
    SimulatorError,
    ngspice.run,
    [
        (RC.replace(".end", ""), "no .end"),
        (RC.replace(".tran 1e-05 0.005 0 1e-05\n", ""), "deck.analysis: none"),
        (RC.replace(".tran", ".op\n.tran"), r"deck.analysis: .op, .tran"),
        (RC.replace(".tran 1e-05 0.005 0 1e-05", ".ac dec 10 1 10"), "deck.analysis: .ac"),
        (RC.replace("0.005", "{stop}"), "stop time must be a number"),
        (RC.replace(".end", ".control\nquit\n.endc\n.end"), "deck.analysis: .tran, .control"),
    ],
)


@pytest.mark.parametrize(
    "card", [".tran 10u 5m 0 10u", ".TRAN 10us 5ms\n+ 0 1E-5 ; c", ".tran 1e-5 .005 $ c"]
)
def test_the_stop_time_is_read_as_spice_reads_it(card: str) -> None:
    waveforms = ngspice.run(RC.replace(".tran 1e-05 0.005 0 1e-05", card))
    assert waveforms.axis[-1] == pytest.approx(5e-3)


def test_a_missing_file_in_the_environment_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NGSPICE_LIBRARY_PATH", "/no/such/libngspice.so")
    with pytest.raises(SimulatorError, match=r"NGSPICE_LIBRARY_PATH: /no/such/libngspice.so, must be"):
        ngspice.run(RC)


def test_a_file_that_is_no_library_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "libngspice.so"
    file.write_text("no library")
    monkeypatch.setenv("NGSPICE_LIBRARY_PATH", str(file))
    with pytest.raises(SimulatorError, match=r"libngspice.so, cannot be loaded"):
        ngspice_library.version()


def test_without_a_library_the_remedy_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ngspice_library, "find_library", lambda: None)
    assert ngspice_library.version() is None
    with pytest.raises(SimulatorError, match=r"install Debian's libngspice0, or set NGSPICE_LIBRARY_PATH"):
        ngspice.run(RC)


def test_version_is_told_and_disturbs_nothing() -> None:
    before = ngspice.run(RC).values["out"]
    version = ngspice_library.version()
    assert version is not None
    assert version.split(".")[0].isdigit()
    np.testing.assert_array_equal(ngspice.run(RC).values["out"], before)


def test_fifty_runs_leave_nothing_behind() -> None:
    path = find_library()
    assert path is not None
    shared = _open(path)
    for _ in range(50):
        ngspice.run(RC)
        assert shared.plot_names == ["const"]


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="resident memory is read from /proc")
def test_memory_stays_flat() -> None:
    def grow(runs: int) -> int:
        for _ in range(runs):
            ngspice.run(RC)
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")

    warm = grow(20)
    # A run stores 3 vectors of 500 points, 12 kB: kept plots would add 1.2 MB, kept circuits more.
    assert grow(100) - warm < 600_000


def test_threads_queue() -> None:
    found: dict[int, float] = {}

    def work(ohms: int) -> None:
        deck = DIVIDER.format(analysis=".op").replace("2000.0", f"{ohms}.0")
        found[ohms] = float(ngspice.run(deck).values["1"][0])

    threads = [threading.Thread(target=work, args=(ohms,)) for ohms in range(1000, 9000, 1000)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == pytest.approx({ohms: 3 * ohms / (ohms + 1000) for ohms in range(1000, 9000, 1000)})


def test_a_deadline_halts_the_run() -> None:
    with pytest.raises(SimulatorError, match=r"not done after 0.2 s"):
        ngspice.run(LONG_RC, deadline_s=0.2)
    assert ngspice.run(RC).axis[-1] == pytest.approx(5e-3)


def test_ctrl_c_ends_the_run() -> None:
    # a shell starts what it puts into the background with Ctrl-C ignored
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            ngspice.run(LONG_RC, deadline_s=60.0)
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)
    assert ngspice.run(RC).axis[-1] == pytest.approx(5e-3)


def test_importing_leaves_pyspice_and_logging_alone() -> None:
    script = (
        "import logging, sys\n"
        "from netlists.ngspice import run\n"
        "assert 'PySpice' not in sys.modules\n"
        "before = logging.root.level, list(logging.root.handlers)\n"
        f"run.run({RC!r})\n"
        "assert (logging.root.level, logging.root.handlers) == before\n"
    )
    root = Path(ngspice.__file__).parents[2]
    # A fresh cache of bytecode, so that PySpice is compiled and would warn.
    fresh = [
        "-X",
        "pycache_prefix=/dev/null",
        "-W",
        "error::SyntaxWarning",
        "-W",
        "error::DeprecationWarning",
    ]
    done = subprocess.run(
        [sys.executable, *fresh, "-c", script], capture_output=True, text=True, cwd=root, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


# The transistor law of `circuits/devices/transistor.py`, with the nMOS values of the rebound neuron.
KAPPA, THRESHOLD, U_T, SPECIFIC_CURRENT = 0.70, 0.60, 0.02585, 2 * 72e-6 * 0.02585**2 / 0.70


def _softplus(x: str) -> str:
    """ln(1 + e^x), accurate at both ends: `ln(1+exp(-40))` is 0 in floating point."""
    return f"({x}<-12 ? exp({x})*(1-0.5*exp({x})) : ({x}>37 ? {x} : ln(1+exp({x}))))"


def _transistor(source: float) -> str:
    """Return the B-source card of an nMOS between node `d` and a source at `source` volts."""
    pinch_off = f"{KAPPA / (2 * U_T)!r}*v(g)-{KAPPA * THRESHOLD / (2 * U_T)!r}"
    forward = _softplus(f"({pinch_off}-{source / (2 * U_T)!r})")
    reverse = _softplus(f"({pinch_off}-{1 / (2 * U_T)!r}*v(d))")
    return f"b1 d 0 i={SPECIFIC_CURRENT!r}*({forward}^2-{reverse}^2)"


def _current(gate: F64, drain: float, source: float) -> F64:
    def half(voltage: float) -> F64:
        return np.logaddexp(0.0, (KAPPA * (gate - THRESHOLD) - voltage) / (2 * U_T)) ** 2

    return SPECIFIC_CURRENT * (half(source) - half(drain))


@pytest.mark.parametrize(("drain", "source"), [(5.0, 0.0), (0.05, 0.0), (1.5, 1.0), (0.0, 0.4)])
def test_ekv_transistor_from_weak_to_strong_inversion(drain: float, source: float) -> None:
    deck = f"ekv\nvg g 0 0\nvd d 0 {drain!r}\n{_transistor(source)}\n{ACCURATE}\n.dc vg 0 3 0.05\n.end\n"
    waveforms = ngspice.run(deck)
    expected = _current(waveforms.values["g"], drain, source)
    # ngspice ends its iteration within abstol 1e-15 A and reltol 1e-4, and mostly far below.
    np.testing.assert_allclose(-waveforms.values["vd#branch"], expected, rtol=1e-4, atol=2e-15)


def test_softplus_keeps_its_relative_accuracy() -> None:
    x = np.array([-60.0, -45.0, -36.0, -20.0, -12.01, -11.99, 0.0, 12.0, 36.99, 37.01, 100.0])
    cards = "".join(
        f"v{i} x{i} 0 {v!r}\nb{i} 0 y{i} i=1e20*{_softplus(f'v(x{i})')}\nr{i} y{i} 0 1\n"
        for i, v in enumerate(x.tolist())
    )
    values = ngspice.run(f"softplus\n{cards}.options reltol=1e-9\n.op\n.end\n").values
    found = np.array([values[f"y{i}"][0] for i in range(len(x))]) * 1e-20
    np.testing.assert_allclose(found, np.logaddexp(0.0, x), rtol=1e-10)
