"""A user's own code, `my_circuit.py:follower`: a name of a file that is run where the user names that file.

What is run is what was read and hashed. Its prints go to stderr, so that a JSON document stays one. An error
of it is a line with its file and line.
"""

from __future__ import annotations

import hashlib
import re
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from functools import lru_cache, wraps
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any, ParamSpec, TypeVar

from circuits.errors import CircuitError, DataError, ParameterError, unknown_name
from circuits.silicon.process import AMI_1500, Process

P = ParamSpec("P")
T = TypeVar("T")

_FILE = re.compile(r"(?P<path>.+\.py)(?::(?P<name>.*))?", re.DOTALL)
_TURN = RLock()  # stdout is the process's: one thread at a time runs code of users


@dataclass(frozen=True, slots=True)
class Code:
    """A name in a user's file.

    path : the file.
    name : what is meant in it; empty where the user has named the file alone.
    """

    path: Path
    name: str

    def __str__(self) -> str:
        return f"{self.path}:{self.name}"


def code_of(text: str) -> Code | None:
    """Give the file and the name of a text `FILE.py:NAME`; None for another text."""
    found = _FILE.fullmatch(text)
    return None if found is None else Code(Path(found["path"]), found["name"] or "")


def read_code(code: Code) -> bytes:
    """Read the file; raises `DataError` where there is none."""
    try:
        return code.path.read_bytes()
    except OSError as error:
        raise DataError(
            f"{code.path}: {error.strerror}; name a file of Python, as my_circuit.py:follower"
        ) from None


def hash_of(data: bytes) -> str:
    """Give the SHA-256 digest by which a file's contents are known."""
    return hashlib.sha256(data).hexdigest()


def load_code(code: Code) -> Any:
    """Run the file, and give what has the name in it.

    Raises `DataError` for a file that is not there, `ParameterError` for one that fails, and
    `UnknownNameError` for a name that it does not have.
    """
    module = _module(code.path, read_code(code))
    found = vars(module).get(code.name)
    if code.name and found is not None:
        return found
    known = [name for name, value in vars(module).items() if _is_own(module, name, value)]
    if not code.name:
        names = ", ".join(known) or "none"
        raise ParameterError(f"{code.path}: which name, must follow as {code.path}:NAME; it has {names}")
    raise unknown_name(f"{code.path}: name", code.name, known)


def load_as(text: str, kind: type[T]) -> T | None:
    """Give what a text `FILE.py:NAME` names, which must be of a kind; None for another text.

    Raises as `load_code`, and `ParameterError` for something else.
    """
    code = code_of(text)
    if code is None:
        return None
    found = load_code(code)
    if not isinstance(found, kind):
        raise ParameterError(f"{code}: is of type {type(found).__name__}, must be a {kind.__name__}")
    return found


def process_of(code: Code) -> Process:
    """Give the `PROCESS` that the file says its sizes are drawn for, `AMI_1500` unless it says one."""
    found = vars(_module(code.path, read_code(code))).get("PROCESS", AMI_1500)
    if not isinstance(found, Process):
        raise ParameterError(f"{code.path}: PROCESS is of type {type(found).__name__}, must be a Process")
    return found


def _is_own(module: ModuleType, name: str, value: object) -> bool:
    """Whether a name is of what the file makes, not of what it imports."""
    if name.startswith("_") or isinstance(value, ModuleType | type):
        return False
    return not callable(value) or getattr(value, "__module__", "") == module.__name__


@lru_cache(maxsize=32)
def _module(path: Path, data: bytes) -> ModuleType:
    """Run a file that was read. It can import files beside it, which take no library's place later."""
    module = ModuleType(f"{path.stem}_{hash_of(data)[:8]}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module  # where dataclasses look for their types
    folder = str(path.resolve().parent)
    sys.path.insert(0, folder)
    try:
        with told_in_a_line(path):
            exec(compile(data, str(path), "exec", dont_inherit=True), vars(module))  # noqa: S102
    except BaseException:
        del sys.modules[module.__name__]
        raise
    finally:
        sys.path.remove(folder)
        if sys.path[-1] != folder:
            sys.path.append(folder)
    return module


@contextmanager
def told_in_a_line(path: Path) -> Iterator[None]:
    """Inside, code of a user's file runs: what it prints goes to stderr, and an error tells file and line.

    Raises `ParameterError` for whatever it raises.
    """
    with _TURN, redirect_stdout(sys.stderr):
        try:
            yield
        except SyntaxError as error:
            raise ParameterError(f"{error.filename}:{error.lineno}: {error.msg}; mend the file") from None
        except (Exception, SystemExit) as error:
            raise ParameterError(_told(error, path)) from error


def guarded(function: Callable[P, T], path: Path) -> Callable[P, T]:
    """Give a function of a user's file whose errors tell file and line."""

    @wraps(function)
    def call(*values: P.args, **named: P.kwargs) -> T:
        with told_in_a_line(path):
            return function(*values, **named)

    return call


def _told(error: BaseException, path: Path) -> str:
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    where = f"{path}:{frames[-1].lineno}" if frames else str(path)
    text = " ".join(str(error).split())
    if isinstance(error, CircuitError):  # one that a function of the file has told already stays as it is
        return text if text.startswith(f"{path}:") else f"{where}: {text}"
    return f"{where}: {type(error).__name__}{f': {text}' if text else ''}; mend the file"
