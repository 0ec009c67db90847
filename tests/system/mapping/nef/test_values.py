"""Networks of values on the NEF chip: the nominal die decodes what is asked, what cannot be is refused."""

import json
from pathlib import Path

import numpy as np
import pytest

from chips.nef.chip import NefChip
from circuits.errors import CircuitError, DataError, ParameterError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.cli.command_line import main
from system.mapping.chips import map_on, read_any, read_any_program, write_any_program
from system.mapping.nef.mapped import MappedValues, codes_of
from system.mapping.nef.network import Connection, Ensemble, Probe, ValueNetwork
from system.mapping.nef.run import Row, equations, read_values, run_values
from system.mapping.network import Input

EXAMPLE = "examples/square-of-a-value.toml"
NET = ValueNetwork(
    (Ensemble("a", 60), Ensemble("b", 60)),
    (Input("in", 1),),
    (Connection("in", "a"), Connection("a", "b", "square", 0.8)),
    (Probe("out", "b"),),
    seed=3,
)
ROWS = (Row(0.0, 0.9), Row(0.2, -0.5))


@pytest.fixture(scope="module")
def mapped() -> MappedValues:
    """The square of a value on the NEF chip."""
    found = map_on("nef", NET)
    assert isinstance(found, MappedValues)
    return found


def test_the_nominal_die_does_what_was_asked_and_the_program_comes_back(
    mapped: MappedValues, tmp_path: Path
) -> None:
    path = str(tmp_path / "p.toml")
    write_any_program(path, "nef", mapped)
    back = read_any_program(path)
    assert isinstance(back, MappedValues)
    assert back.network == NET
    assert back.findings == mapped.findings
    for name, codes in codes_of(back).items():
        assert np.array_equal(codes, codes_of(mapped)[name])
    run = run_values(back, ROWS, Silicon(ROLLS_180), 0.5, codes="default")
    # 5 % of the largest value: ripple of 60 neurons' spikes through 20 ms, which ideal neurons have as well
    assert 0.0 < run.from_asked["out"] < 0.05
    assert 0.0 < run.ideal_from_asked["out"] < 0.05
    assert run.from_ideal["out"] > 0.0
    assert (run.counters["dropped"], run.counters["clipped"]) == (0, 0)


def test_every_finding_has_a_number_and_synapses_have_their_limit() -> None:
    far = ValueNetwork(
        (Ensemble("a", 20, radius=0.2), Ensemble("b", 20)),
        connections=(Connection("b", "a", synapse=0.0), Connection("a", "b")),
    )
    findings = map_on("nef", far).findings
    found = {(f.where, f.what): f for f in findings}
    assert found["a", "reach"].asked == pytest.approx(1.0)
    assert found["a", "reach"].got == pytest.approx(0.4)
    fastest, usual = (f for f in findings if f.what == "synapse")
    assert fastest.got == pytest.approx(0.5e-3, rel=0.01)
    assert fastest.note == "of a filter, the fastest is 0.5 ms"
    assert usual.how == "exact"
    assert all(f.error for f in findings if f.how == "approximate")


def test_the_equations_are_low_passes_of_functions() -> None:
    seen = equations(NET, {"in": np.full((400, 1), 0.5)}, 400)["out"][:, 0]
    assert seen[-1] == pytest.approx(0.8 * 0.25, rel=1e-3)
    # three low-passes, of 5, 5 and 20 ms, come late by the sum of their time constants
    late = 1e-3 * float((1.0 - seen / seen[-1]).sum())
    assert 0.025 < late < 0.040


def test_a_program_at_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program, inputs = str(tmp_path / "p.toml"), tmp_path / "in.csv"
    (tmp_path / "n.toml").write_text(
        'ensemble = [{name = "a", neurons = 30}]\ninput = [{name = "in", size = 1}]\n'
        'connection = [{from = "in", to = "a"}]\nprobe = [{name = "out", ensemble = "a"}]\n'
    )
    inputs.write_text("time_s,value\n0,0.5\n")
    assert main(["map", str(tmp_path / "n.toml"), "--chip", "nef", "-o", program]) == 0
    assert main(["show", program, "--plot", str(tmp_path / "p.png")]) == 0
    capsys.readouterr()
    line = ["run", program, "--input", str(inputs), "--die", "nominal", "--duration", "0.2s"]
    assert main([*line, "--plot", str(tmp_path / "r.png"), "--json"]) == 0
    (out,) = json.loads(capsys.readouterr().out)["outputs"]
    assert 0.0 < out["from_asked"] < 0.2  # ripple of 30 neurons
    inputs.write_text("time_s,value\n0,0.5\n0.3,0.7\n0.4,0.9\n")
    assert main(line) == 0
    told = " ".join(capsys.readouterr().out.split())  # a long folder's name breaks lines
    assert "0.1 to 0.2 s" in told
    assert "rows of inputs not used, for times after the end of the run: 2" in told
    inputs.write_text("time_s,channel,value\n0,2,0.5\n")
    for more, told in (([], "channel 2, must be 0 to 0"), (["--temperature", "0s:27,1s:30"], "a course")):
        assert main([*line, *more]) == 2
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert told in error


def test_what_has_no_room_is_refused_before_the_chip_is_calibrated(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object) -> None:
        raise AssertionError("calibrated")

    monkeypatch.setattr(NefChip, "at", never)
    many = tuple(Ensemble(f"e{k}", 5) for k in range(513))
    for ensembles, told in (
        (
            (Ensemble("a", 99, 64),),
            r"^a: 64 dimensions and 0 currents .* take 65 encoder columns, the chip has",
        ),
        (many, r"^nef-chip: 513 dimensions and currents into neurons, the chip has 512 lines; take fewer"),
    ):
        with pytest.raises(ParameterError, match=told):
            map_on("nef", ValueNetwork(ensembles))
    with pytest.raises(AssertionError, match="calibrated"):
        map_on("nef", ValueNetwork(many[:1]))


@pytest.mark.parametrize(
    ("network", "told"),
    [
        (lambda: ValueNetwork((Ensemble("a", 9000),)), "a: neurons up to number 9000, the chip has 8192"),
        (lambda: ValueNetwork((Ensemble("a", 9, radius=-1.0),)), "radius: -1, must be > 0"),
        (lambda: ValueNetwork((Ensemble("a", 9),), connections=(Connection("b", "a"),)), "b: unknown"),
        (
            lambda: ValueNetwork((Ensemble("a", 9),), probes=(Probe("p", "a", "cube"),)),
            "function cube: unknown",
        ),
        (
            lambda: ValueNetwork((Ensemble("a", 9),), (Input("i", 1),), (Connection("i", "a", "square"),)),
            "i->a.function: on a node, must be on an ensemble",
        ),
        (
            lambda: ValueNetwork((Ensemble("a", 9),), (Input("i", 1),), (Connection("a", "i"),)),
            r"^target of a->i i: unknown; known are a$",
        ),
        (
            lambda: ValueNetwork((Ensemble("a", 9),), (), (Connection("a", "a", synapse=100.0),)),
            r"^a->a\.synapse: 100 s, must be <= 0\.679 s, the slowest filter of the chip has 0\.509 s; ",
        ),
        (
            lambda: Connection("a", "b", transform=((1.0, 0.0), (0.0,))),
            r"a->b\.transform: rows must be as long",
        ),
        (lambda: Connection("a", "b", transform="x"), "transform: 'x', must be a number or a tuple of"),  # type: ignore[arg-type]
        (lambda: Ensemble("a", 9, max_rates=3.0), "max_rates: 3.0, must be a tuple of 2 numbers"),  # type: ignore[arg-type]
        (lambda: Ensemble("a", 9, intercepts=("x", "y")), "intercepts: .* must be a tuple of 2 numbers"),  # type: ignore[arg-type]
    ],
)
def test_what_cannot_be_is_refused(network: object, told: str) -> None:
    with pytest.raises(CircuitError, match=told):
        map_on("nef", network())  # type: ignore[operator]


def test_arrays_and_lists_are_taken_for_the_tuples_that_they_are() -> None:
    one = Connection("a", "b", transform=np.eye(2))  # type: ignore[arg-type]
    assert one == Connection("a", "b", transform=((1.0, 0.0), (0.0, 1.0)))
    assert Ensemble("a", 9, max_rates=[100.0, 200.0]).max_rates == (100.0, 200.0)  # type: ignore[arg-type]


def test_networks_go_to_their_chip_and_files_that_are_wrong_are_told(
    mapped: MappedValues, tmp_path: Path
) -> None:
    with pytest.raises(ParameterError, match="rolls, takes networks of populations, this one"):
        map_on("rolls", read_any(EXAMPLE))
    write_any_program(str(tmp_path / "p.toml"), "nef", mapped)
    np.savez(tmp_path / "p.npz", bias=np.zeros(3), stages=np.zeros(3), decoders=np.zeros(3))
    with pytest.raises(DataError, match=r"codes.bias: 3, must be 120; map the network again"):
        read_any_program(str(tmp_path / "p.toml"))
    (tmp_path / "in.csv").write_text("time_s,value\n0.5,1\n0.1,0\n")
    with pytest.raises(DataError, match="must not be before the row above"):
        read_values(str(tmp_path / "in.csv"), NET)
