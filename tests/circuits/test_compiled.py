"""Compiled functions: what is kept on disk goes stale with any file whose code or constants it holds."""

import errno
import fcntl
import gc
import importlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import pytest

from chips.ranging.kernel import on_call
from circuits.compiled import compiled, source_stamp
from circuits.machine_code.target import KINDS, PortableCodegen, kinds_here
from circuits.solver.integrate import integrate

ROOT = Path(__file__).resolve().parents[2]

CALLER = """from circuits.compiled import compiled
from {callee} import add
@compiled()
def twice(x):
    return add(x, x)
"""
CALLEE = """from circuits.compiled import compiled
import {numbers}
from {numbers} import offset_of, SHIFT
@compiled()
def add(x, y):
    return x + y + SHIFT + {numbers}.offset_of(x)
"""
NUMBERS = """from circuits.compiled import compiled
SHIFT = {shift}
@compiled()
def offset_of(x):
    return {offset}
"""


def load(folder: Path, shift: str = "1.0", offset: str = "0.0 * x") -> Any:
    """A module that calls another one, which calls a third; written anew, under names of their own."""
    kind = folder.name
    texts = {
        f"caller_{kind}": CALLER.format(callee=f"callee_{kind}"),
        f"callee_{kind}": CALLEE.format(numbers=f"numbers_{kind}"),
        f"numbers_{kind}": NUMBERS.format(shift=shift, offset=offset),
    }
    for name, text in texts.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
        sys.modules.pop(name, None)
    source_stamp.cache_clear()
    importlib.invalidate_caches()
    return importlib.import_module(f"caller_{kind}")


def stamp(function: Any) -> bytes:
    """The stamp that numba compares a file of its cache with."""
    return bytes(function.dispatcher._cache._cache_file._source_stamp)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # files of one second differ
    return tmp_path


def test_what_is_kept_follows_callees_of_callees_and_their_constants(folder: Path) -> None:
    assert load(folder).twice(2.0) == 5.0
    assert load(folder, shift="2.0").twice(2.0) == 6.0
    assert load(folder, offset="10.0 * x").twice(2.0) == 25.0
    assert load(folder).twice(2.0) == 5.0


def test_a_stamp_changes_with_contents_and_with_nothing_else(folder: Path) -> None:
    first = stamp(load(folder).twice)
    (folder / "unrelated.py").write_text("", encoding="utf-8")
    assert stamp(load(folder).twice) == first
    assert len({first, stamp(load(folder, shift="2.0").twice), stamp(load(folder, offset="x").twice)}) == 3


def test_an_imported_constant_counts_where_no_function_is_called(tmp_path: Path) -> None:
    path = tmp_path / "m.py"
    path.write_text("", encoding="utf-8")
    found = set()
    for value in (1.0, 2.0, (1.0, 2.0), (2.0, 1.0)):
        sys.modules["m"] = module = type(sys)("m")
        module.LIMIT = value  # type: ignore[attr-defined]
        source_stamp.cache_clear()
        found.add(source_stamp("m", str(path)))
    del sys.modules["m"]
    assert len(found) == 4


def test_kernels_of_chips_and_solver_carry_their_stamps() -> None:
    source_stamp.cache_clear()
    functions: tuple[Any, ...] = (integrate, on_call)
    for function in functions:
        python = function.py_func
        assert stamp(function) == source_stamp(python.__module__, python.__code__.co_filename)


def test_a_compiled_function_computes() -> None:
    @compiled()
    def twice(x: float) -> float:
        return 2.0 * x

    assert twice(1.5) == 3.0
    assert gc.isenabled()


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of kernels in which one program's are kept."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))  # of processes, and of this one
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "kept"))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.syspath_prepend(tmp_path)
    text = "from circuits.compiled import compiled\n@compiled()\ndef twice(x):\n    return 2.0 * x\n"
    (tmp_path / "small_kernel.py").write_text(text)
    assert doubled() == (42.0, 1)
    assert doubled() == (42.0, 0)
    return tmp_path / "kept"


def doubled() -> tuple[float, int]:
    """What a small kernel says that was not loaded before, and how often it was compiled for that."""
    sys.modules.pop("small_kernel", None)
    importlib.invalidate_caches()
    twice = importlib.import_module("small_kernel").twice
    return twice(21.0), sum(twice.dispatcher.stats.cache_misses.values())


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("spoil", ["garbage", "truncated", "flipped", "empty"])
def test_spoiled_machine_code_is_compiled_again(kept: Path, suffix: str, spoil: str) -> None:
    files = list(kept.rglob(f"*.{suffix}"))
    assert files
    for path in files:
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 0xFF
        spoilt = {"garbage": b"no", "truncated": bytes(data[:90]), "flipped": bytes(data), "empty": b""}
        path.write_bytes(spoilt[spoil])
    assert doubled() == (42.0, 1)


def test_kept_machine_code_is_loaded_without_all_that_numba_can_compile(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> None:
        raise RuntimeError

    monkeypatch.setattr("numba.core.base.BaseContext.refresh", refused)
    assert doubled() == (42.0, 0)


def test_machine_code_that_needs_what_is_not_here_is_compiled_again(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("circuits.machine_code.machine.llvm.address_of_symbol", lambda _: None)
    assert doubled() == (42.0, 1)


def test_where_nothing_can_be_written_kernels_are_compiled_each_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("numba.core.caching.CacheImpl._locator_classes", [])
    assert compiled()(lambda x: 2.0 * x)(21.0) == 42.0


@pytest.fixture
def shipped(kept: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of kernels that came with a package, in which one is; nothing else is kept or can be."""
    monkeypatch.setattr("circuits.machine_code.cache.SHIPPED", kept.parent / "shipped")
    monkeypatch.setenv("NOCTULE_SHIP_KERNELS", "1")
    assert doubled() == (42.0, 0)
    monkeypatch.delenv("NOCTULE_SHIP_KERNELS")
    monkeypatch.setattr("numba.core.caching.CacheImpl._locator_classes", [])
    return kept.parent / "shipped"


def test_a_kernel_that_came_with_the_package_is_loaded(shipped: Path) -> None:
    assert [path.parent.name for path in shipped.rglob("*.nbc")] == ["small_kernel"]
    assert doubled() == (42.0, 0)


def test_a_kernel_that_came_with_another_processor_or_was_spoilt_is_compiled_and_stays_as_it_is(
    shipped: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as other:
        other.setattr("numba.core.codegen.CPUCodegen.magic_tuple", lambda _: ("another",))
        assert doubled() == (42.0, 1)
    for path in shipped.rglob("*.nbc"):
        path.write_bytes(b"no" + path.read_bytes())
    before = {path: path.read_bytes() for path in shipped.rglob("*.nb?")}
    assert doubled() == (42.0, 1)
    assert {path: path.read_bytes() for path in shipped.rglob("*") if path.is_file()} == before


def test_kernels_are_for_the_widest_kind_of_which_the_processor_has_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert PortableCodegen("test", "x86-64-v3").magic_tuple()[1:] == ("x86-64-v3", "")
    features = dict.fromkeys(KINDS["x86-64-v4"], True)
    monkeypatch.setattr("llvmlite.binding.get_host_cpu_features", lambda: features)
    assert kinds_here() == ["x86-64-v4", "x86-64-v3"]
    features["avx512dq"] = False
    assert kinds_here() == ["x86-64-v3"]
    features["fma"] = False
    assert not kinds_here()


def test_a_disk_that_takes_nothing_leaves_a_kernel_usable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))

    def full(*_: object, **__: object) -> object:
        raise OSError(errno.ENOSPC, "No space left on device")

    kernel = compiled()(lambda x: 3.0 * x)
    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile._open_for_write", full)
    assert kernel(14.0) == 42.0


SLOW = """import sys, time
from pathlib import Path
from small_kernel import twice
twice = twice.dispatcher
compiles = twice._compiler.compile
def slow(*signature):
    time.sleep(1.0)
    return compiles(*signature)
twice._compiler.compile = slow
Path(sys.argv[1]).touch()
while not all(Path(name).exists() for name in ("first", "second")):
    time.sleep(0.01)
twice(21.0)
print(sum(twice.stats.cache_misses.values()), sum(twice.stats.cache_hits.values()))
"""


def test_two_processes_that_miss_a_kernel_compile_it_once(kept: Path) -> None:
    for path in [*kept.rglob("*.nbi"), *kept.rglob("*.nbc")]:
        path.unlink()
    both = [
        subprocess.Popen([sys.executable, "-c", SLOW, n], cwd=kept.parent, stdout=subprocess.PIPE, text=True)
        for n in ("first", "second")
    ]
    assert sorted(process.communicate(timeout=120)[0].strip() for process in both) == ["0 1", "1 0"]


def test_what_cannot_be_compiled_leaves_nobody_waiting() -> None:
    kernel: Any = compiled()(lambda x: x.nothing)
    with pytest.raises(numba.TypingError):
        kernel(1.0)
    lock = kernel.dispatcher._cache.lock
    assert lock.depth == 0
    with lock._path.open("r+b") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_where_no_file_can_be_locked_a_kernel_is_compiled_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    kernel: Any = compiled()(lambda x: 5.0 * x)
    monkeypatch.setattr("circuits.machine_code.cache.fcntl.flock", refused)
    assert kernel(8.0) == 40.0
    assert kernel.dispatcher._cache.lock.depth == 0
