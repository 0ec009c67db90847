"""Processes that are watched until they have done something, and then killed."""

import os
import signal
import subprocess
import time
from collections.abc import Callable


def wait_until(done: Callable[[], bool], seconds: float = 120.0) -> None:
    """Wait until something is done; fail if it takes longer than so many seconds."""
    deadline = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def kill_when(child: subprocess.Popen[bytes], done: Callable[[], bool]) -> None:
    """Kill a process with signal 9 once something is done."""
    try:
        wait_until(done)
        os.kill(child.pid, signal.SIGKILL)
    finally:
        child.kill()
        child.wait()
