"""Keys of `noctule view`."""

from __future__ import annotations

from system.meaning import meanings

VIEW = meanings("""
page   string    -  file that was written
bytes  integer   -  its size
runs   object[]  -  what it plays
runs.title       string  -  what ran, on what
runs.headline    string  -  whether it succeeded and why it ended
runs.duration_s  number  s  length of the run
""")
