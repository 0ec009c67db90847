"""What `noctule` says without arguments: three things to try, and where help is."""

from __future__ import annotations

from system.cli.examples import example_of

# Commands whose example is tried, for whom, and what it shows.
TRIED: dict[tuple[str, ...], tuple[str, str]] = {
    ("simulate",): ("Circuit designer", "a range-tuned neuron on die 7, its waveforms as a picture"),
    ("run", "car"): ("Roboticist", "a car with a sonar that drives through a forest, its way as a picture"),
    ("reproduce",): ("Lecturer", "a figure of a paper made again, each statement with its verdict"),
}
_HELP = (
    ("noctule list", "blocks, chips, systems, experiments, metrics and dialects"),
    ("noctule COMMAND --help", "options and an example; commands are in noctule --help"),
    ("noctule run SYSTEM --help", "options of a robot and its world"),
    ("noctule doctor", "what is installed, and what mends what is not"),
)


def guide() -> str:
    """Give the text, whose lines fit 100 columns."""
    lines = [
        "noctule models mixed-signal neuromorphic hardware, from transistors to robots.",
        "",
        "Three things to try:",
    ]
    for words, (who, what) in TRIED.items():
        lines += ["", f"  {who}: {what}", *(f"    {line}" for line in example_of(*words))]
    lines += [
        "",
        "Each takes seconds; the first run of each also compiles its kernels, once.",
        "",
        "Where help is:",
        "",
    ]
    lines += [f"  {command:27}{what}" for command, what in _HELP]
    return "\n".join(lines)
