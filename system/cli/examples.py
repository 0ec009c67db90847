"""Examples that `--help` shows: for each command, and for each system of `run`, what to type.

An example is one command, or several of which the last reads what those before it write. All of them are run
by the test of the documents.
"""

from __future__ import annotations

from collections.abc import Sequence

EXAMPLES: dict[tuple[str, ...], tuple[str, ...]] = {
    ("list",): ("noctule list --json",),
    ("show",): ("noctule show nef-neuron --schematic neuron.svg --op",),
    ("op",): ("noctule op rebound-neuron --temperature 60 --csv devices.csv",),
    ("simulate",): ("noctule simulate rebound-neuron --die 7 --plot neuron.png",),
    ("sweep",): ("noctule sweep rebound-neuron --over v_rest=0V..5V:101 --plot sweep.png",),
    ("export",): ("noctule export rebound-neuron --die 7 --dialect spectre -o neuron.scs",),
    ("import",): (
        "noctule export rebound-neuron -o neuron.cir",
        "noctule import neuron.cir --json",
    ),
    ("compare",): (
        "noctule export rebound-neuron -o left.cir",
        "noctule export rebound-neuron --dialect cdl -o right.cdl",
        "noctule compare left.cir right.cdl",
    ),
    ("view",): (
        "noctule run pushbot --scene single-block -o drive.nc",
        "noctule view drive.nc -o drive.html",
    ),
    ("map",): ("noctule map examples/working-memory.toml --chip rolls -o program.toml",),
    ("montecarlo",): ("noctule montecarlo rebound-neuron -n 50 --metric best_delay --csv dies.csv",),
    ("gradient",): (
        'noctule gradient rebound-neuron --metric "spike_time(spike,0)" --die 1003',
        'noctule gradient photoreceptor --metric "bandwidth(v_sf,v_pd)"',
    ),
    ("match",): ("noctule match rebound-neuron --metric t_inh_s --spread 6ms",),
    ("worst",): ('noctule worst rebound-neuron --spec "t_inh_s in :8ms" --no-process-variation',),
    ("corners",): ("noctule corners rebound-neuron --metric t_inh_s --no-process-variation",),
    ("certify",): (
        "noctule certify PROGRAM --task digits.npz --dies 20 -o silicon",
        "noctule certify PROGRAM --task CartPole-v1 --reach 1,1.5,0.2,2",
    ),
    ("train",): ("noctule train NETWORK --task digits-training.npz -o trained.toml",),
    ("mission",): ("noctule mission approach --dies 8 --worlds 1 -o mission",),
    ("merge",): (
        "noctule mission approach --dies 2 --chunk 1 --shard 1/2 -o one",
        "noctule mission approach --dies 2 --chunk 1 --shard 2/2 -o two",
        "noctule merge one two -o whole",
    ),
    ("replay",): (
        "noctule montecarlo rebound-neuron -n 50 -o dies",
        "noctule replay dies --die 1000 --plot die.png",
    ),
    ("centre",): ('noctule centre rebound-neuron --spec "class is works"',),
    ("size",): ('noctule size differential-pair --spec "offset_V in -5mV:5mV" --yield 95%',),
    ("characterise",): ("noctule characterise lso-neuron -o lso.nc",),
    ("extract",): ("noctule extract --process gf180mcu -o mine.toml --plot fit.png",),
    ("identify",): ("noctule identify --fit coach --only 'ndp_*' --process rolls-180 -o die.toml",),
    ("predict",): (
        "noctule identify --fit coach --only 'ndp_*' --process rolls-180 -o die.toml",
        "noctule predict coach --process rolls-180 --die die.toml -o predicted",
    ),
    ("calibrate",): ("noctule calibrate latency-chip --die 1003 -o codes.toml",),
    ("reproduce",): ("noctule reproduce cheely2003-fig4 --plot fig4.png",),
    ("new",): ("noctule new block my-sink",),
    ("doctor",): ("noctule doctor",),
    ("blame",): ("noctule blame approach --codes default --die 1003 --report why.html",),
    ("blame", "approach"): ("noctule blame approach --bias-kind gate --die 1001 --report why.html",),
    ("blame", "rover"): ('noctule blame rover --codes default --die 1003 --success "frechet_m < 9"',),
    ("blame", "forest"): ("noctule blame forest --codes default --die 1003 --report why.html",),
    ("blame", "spiking-bat"): ("noctule blame spiking-bat --die 5004 --report why.html",),
    ("blame", "car"): ("noctule blame car --codes default --die 5003 --report why.html",),
    ("blame", "head"): ("noctule blame head --codes default --die 5002 --report why.html",),
    ("blame", "bug"): ("noctule blame bug --map bug-field --die 5001 --temperature 37",),
    ("blame", "pushbot"): ("noctule blame pushbot --codes default --die 1003 --plot why.png",),
    ("blame", "rolls"): ('noctule blame rolls --die 1003 --success "rate_cv < 0.05"',),
    ("run",): ("noctule run approach --level behavioural --plot approach.png",),
    ("run", "approach"): ("noctule run approach --level behavioural --die 1003 --plot approach.png",),
    ("run", "rover"): ("noctule run rover --map map2 --start 2,10 --goal 19,10 --plot way.png",),
    ("run", "forest"): ("noctule run forest --obstacles 1000 --seed 1000 --plot forest.png",),
    ("run", "spiking-bat"): ("noctule run spiking-bat --brain network --pings 600 --plot bat.png",),
    ("run", "car"): ("noctule run car --forest dense --seed 1000 --plot car.png",),
    ("run", "head"): ("noctule run head --motion sine --die 1003 --plot head.png",),
    ("run", "bug"): ("noctule run bug --agent bug2 --map bug-field --plot bug.png",),
    ("run", "pushbot"): ("noctule run pushbot --scene single-block --seed 1000 --plot drive.png",),
    ("serve",): ("noctule serve ranging-chip --die 1001 --pace real --port 0 --duration 1s",),
    ("labs",): ("noctule labs --students 2 -o class",),
    ("run", "bench"): ("noctule run bench examples/pair.toml --die 7 --plot pair.png",),
    ("run", "rolls"): ("noctule run rolls --die 1003 --plot rates.png",),
}


def example_of(*words: str) -> Sequence[str]:
    """Give the example of a command; that of a user's own system is its run in JSON."""
    return EXAMPLES.get(words, (f"noctule {' '.join(words)} --json",))


def epilog_of(*words: str) -> str:
    """Give the last lines of a command's help, laid out as they are printed."""
    return "\n".join(("\b", "Example:", *(f"  {line}" for line in example_of(*words))))
