"""Networks as data: their files come back, and what does not fit is refused by name."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.errors import DataError, ParameterError, UnknownNameError
from system.mapping.network import Connection, Input, Network, Population, Probe, matrix_of
from system.mapping.network_file import INLINE, read_network, write_network
from system.mapping.program_file import check_program_path

LARGE = np.arange(40.0 * 30.0).reshape(40, 30) / 1e3
NETWORK = Network(
    (Population("a", 40, 13e-3, 1.7e-3, "constant"), Population("b", 40)),
    (Input("in", 30),),
    (
        Connection("in", "a", rule="matrix", matrix=LARGE, tau=0.1 / 3.0),  # type: ignore[arg-type]
        Connection("a", "b", -0.3, "one-to-one"),
        Connection("b", "b", 0.25, "random", probability=0.5, seed=3, to_itself=False),
    ),
    (Probe("out", "b", 30e-3),),
)


def test_a_network_comes_back_from_its_file_with_large_matrices_beside(tmp_path: Path) -> None:
    assert LARGE.size > INLINE
    write_network(tmp_path / "a.toml", NETWORK)
    assert read_network(tmp_path / "a.toml") == NETWORK
    assert "a.npz:connection0" in (tmp_path / "a.toml").read_text()


def test_numbers_of_arrays_are_written_as_numbers(tmp_path: Path) -> None:
    network = Network((Population("a", 2, np.float64(0.03)),))
    write_network(tmp_path / "a.toml", network)
    assert 'tau = "0.03s"' in (tmp_path / "a.toml").read_text()
    assert read_network(tmp_path / "a.toml") == network


def test_a_file_of_other_arrays_is_never_written_over(tmp_path: Path) -> None:
    """Samples of a task stand beside a network of their name; a network's own arrays are written anew."""
    write_network(tmp_path / "own.toml", NETWORK)
    write_network(tmp_path / "own.toml", NETWORK)
    np.savez(tmp_path / "a.npz", inputs=np.ones((2, 30)), labels=[0, 1])
    with pytest.raises(ParameterError, match=r"a\.npz: is there, of other arrays than a network's"):
        write_network(tmp_path / "a.toml", NETWORK)
    with pytest.raises(ParameterError, match="give another name"):
        check_program_path(str(tmp_path / "a.toml"))
    with np.load(tmp_path / "a.npz") as held:
        assert sorted(held) == ["inputs", "labels"]


def test_rules_make_matrices_of_targets_and_sources() -> None:
    one, other = (matrix_of(NETWORK, c) for c in NETWORK.connections[1:])
    assert (one == -0.3 * np.eye(40)).all()
    assert set(np.unique(other)) == {0.0, 0.25}
    assert not np.diag(other).any()
    assert np.mean(other > 0.0) == pytest.approx(0.5, abs=0.05)  # 1600 draws: 4 standard deviations


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "population: missing"),
        ("population = [{ name = 'a', size = 0 }]", r"population\[0\].size: 0, must be >= 1"),
        ("population = [{ name = 'a', size = 2, tau = '20mV' }]", r"population\[0\].tau.*20mV"),
        ("population = [{ name = 'a', size = 2, tua = 1 }]", r"population\[0\].tua: unknown key.*tau"),
    ],
)
def test_a_file_that_is_none_is_refused_with_its_key(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "n.toml"
    path.write_text(text)
    with pytest.raises(DataError, match=told):
        read_network(path)


def test_connections_that_do_not_fit_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="source of c -> a"):
        replace(NETWORK, connections=(Connection("c", "a"),))
    with pytest.raises(ParameterError, match="in -> a: 30 to 40, must be as many"):
        replace(NETWORK, connections=(Connection("in", "a", rule="one-to-one"),))
    with pytest.raises(ParameterError, match="40 x 30, must be 40 x 40"):
        replace(NETWORK, connections=(replace(NETWORK.connections[0], source="b"),))
    with pytest.raises(ParameterError, match="a: given twice"):
        replace(NETWORK, populations=(Population("a", 1), Population("a", 2)))


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Population("a", 2.5), r"^size: 2\.5, must be a whole number$"),  # type: ignore[arg-type]
        (lambda: Population("a", "3"), r"^size: '3', must be a whole number$"),  # type: ignore[arg-type]
        (lambda: Input("in", 1, "500Hz"), r"^rate: '500Hz', must be a number$"),  # type: ignore[arg-type]
        (
            lambda: Connection("a", "b", 3.0, "matrix", matrix=((1.0,),)),
            r"^a -> b\.weight: 3, is not of",
        ),
        (lambda: Connection("a", "b", probability=0.3), r"^a -> b\.probability: 0\.3, .* or take random$"),
        (lambda: Network((Population("", 1),)), r"^'': must be letters"),
        (lambda: Network((Population("a\nb", 1),)), r"^'a\\nb': must be letters that show, on one line"),
        (lambda: Connection("a", "b", to_itself="no"), r"^to_itself: 'no', must be True or False$"),  # type: ignore[arg-type]
    ],
)
def test_a_value_of_another_kind_is_refused(make: Callable[[], object], told: str) -> None:
    with pytest.raises(ParameterError, match=told):
        make()
