"""Monte Carlo on a graphics processor from the command line, and what it says without one."""

import shlex

import pytest

from circuits.programs import gpu
from system.cli.command_line import main
from tests.circuits.programs.stand_in import COMPILER, stand_in
from tests.system.conftest import RunJson

COUNTED = "--measure 'n = spikes(spike)'"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (f"high-threshold-neuron {COUNTED}", "device: gpu, needs CuPy; install noctule[gpu]"),
        (f"onset-neuron {COUNTED}", "device: gpu, no run of onset_neuron goes there"),
        (f"high-threshold-neuron {COUNTED} --engine ngspice", "device: gpu, of the native engine"),
        ("approach", "--device: gpu, of blocks and chips, not of approach; leave it out"),
    ],
)
def test_what_cannot_go_there_is_refused(
    words: str, told: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(gpu, "_imported", lambda: None)
    assert main(["montecarlo", *shlex.split(words), "--samples", "4", "--device", "gpu"]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1


@pytest.mark.skipif(COMPILER is None, reason="no C++ compiler, which stands in for a graphics processor")
def test_a_study_has_the_classes_of_one_on_the_processor(
    run_json: RunJson, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gpu, "cupy", stand_in)
    words = shlex.split(f"montecarlo high-threshold-neuron --samples 12 --threads 1 {COUNTED}")
    there, here = (run_json(*words, "--device", device) for device in ("gpu", "cpu"))
    assert (there["device"], here["device"]) == ("gpu", "cpu")
    assert there["classes"] == here["classes"]
    assert there["values"] == here["values"]
