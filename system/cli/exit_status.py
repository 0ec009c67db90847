"""Exit statuses of the command line: what a script learns without reading the output.

A command that did what was asked for returns `DONE`; one that did it and has to say no returns `NO`, after a
line on stderr that says what: an experiment disagrees, netlists differ, no die of a study or of a condition
could be measured, no die passes, a sample is not the one that was kept, a piece of the installation is
missing or cannot be loaded. Whatever raises an error ends with `BAD_INPUT`. How well a robot fares is no
status: its run was made, and its summary says.
"""

from __future__ import annotations

DONE = 0
NO = 1  # also where the output's reader goes away
BAD_INPUT = 2  # or a file, simulator or solver that fails
INTERRUPTED = 130
