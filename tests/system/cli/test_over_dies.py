"""What `worst`, `corners` and `match` refuse, each in a line, and files of dies that keep apart."""

from pathlib import Path

from tests.refusals import command_refusals
from tests.system.conftest import Run

test_what_worst_cannot_find = command_refusals(
    "worst",
    rows=[
        ("differential-pair --spec 'class is balanced'", '--spec: "class is balanced", must limit a metric'),
        ("differential-pair --spec offset_V", '--spec: "offset_V", must limit a metric'),
        (
            "differential-pair --spec 'offset_V in :5mV' --check 3",
            "--check: 3, must be 0 or at least 50 dies",
        ),
        ("approach --spec x", "worst: approach is a system"),
    ],
)
test_what_corners_cannot_find = command_refusals(
    "corners",
    rows=[
        ("differential-pair --metric offset_V --no-mismatch --no-process-variation", "nothing that varies"),
        ("differential-pair --metric offset_V -o pyproject.toml", "pyproject.toml, cannot be a folder"),
    ],
)
test_what_cannot_be_matched = command_refusals(
    "match",
    rows=[
        (
            "differential-pair --metric offset_V --spread 10%",
            "10% of offset_V, which is 0 on the nominal die",
        ),
        ("differential-pair --metric offset_V --heal '*'", "offset_V, is moved by nothing that varies"),
    ],
)


def test_a_spread_that_least_areas_do_not_reach_is_told(run: Run) -> None:
    _, told, _ = run("match", "differential-pair", "--metric", "offset_V", "--spread", "1V")
    assert "wanted spread 1V, 14.2758mV by least areas" in told


def test_dies_of_two_limits_of_a_metric_are_two_files(run: Run, tmp_path: Path) -> None:
    limits = ("--spec", "offset_V in -5mV:", "--spec", "offset_V in -3mV:")
    run("worst", "differential-pair", *limits, "-o", str(tmp_path))
    first, second = (tmp_path / f"offset_V-below{n}.toml" for n in ("", "-2"))
    assert first.read_text() != second.read_text()


def test_a_die_of_another_circuit_alone_is_refused(run: Run) -> None:
    status, _, told = run("op", "differential-pair", "--deviate", "rebound_neuron.inhibition.mi5.v_t0=5mV")
    assert status == 2
    assert "is of another circuit, as all of them; take a die of differential_pair" in told
