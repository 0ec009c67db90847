"""Weights of few bits: what they become, what a task loses by them, and how many are enough."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.mapping.certify.resolution import Resolved, bits_of, fewest_bits, of_bits, resolved
from system.mapping.certify.system import Scenario
from system.mapping.chips import map_on
from system.mapping.nef import network as values
from system.mapping.network import Connection, Input, Network, Population, Probe
from system.mapping.program_file import write_program

WEIGHTS = ((0.5, 0.4), (-0.1, -0.26))
NET = Network(
    (Population("left", 4), Population("right", 4)),
    (Input("in", 2),),
    (
        Connection("in", "left", rule="matrix", matrix=np.tile(WEIGHTS[0], (4, 1))),  # type: ignore[arg-type]
        Connection("in", "right", rule="matrix", matrix=np.tile(WEIGHTS[1], (4, 1))),  # type: ignore[arg-type]
        Connection("left", "right", -0.3, "one-to-one"),
    ),
    (Probe("goes left", "left"), Probe("goes right", "right")),
)


def weights(bits: int) -> np.ndarray:
    rounded = of_bits(NET, bits)
    return np.array([c.matrix[0] for c in rounded.connections[:2]])  # type: ignore[union-attr]


@pytest.mark.parametrize("bits", [2, 3, 5, 12])
def test_weights_are_whole_steps_of_which_the_largest_of_a_source_is_the_last(bits: int) -> None:
    found, most = weights(bits), 2 ** (bits - 1) - 1
    steps = found / (0.5 / most)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert found[0, 0] == pytest.approx(0.5)
    assert np.abs(found - WEIGHTS).max() <= 0.5 * 0.5 / most * (1.0 + 1e-9)


def test_two_bits_are_a_sign_and_a_number_of_its_own_stays() -> None:
    np.testing.assert_allclose(weights(2), [[0.5, 0.5], [0.0, -0.5]])
    assert of_bits(NET, 2).connections[2] == NET.connections[2]  # the only one from its source


def test_transforms_of_a_network_of_values_have_bits_too() -> None:
    net = values.ValueNetwork(
        (values.Ensemble("a", 60, dimensions=2), values.Ensemble("b", 60)),
        (Input("in", 2),),
        (
            values.Connection("in", "a", transform=((1.0, 0.4), (0.0, -0.6))),
            values.Connection("a", "b", transform=((0.8, 0.1),)),
        ),
        (values.Probe("out", "b"),),
    )
    first, second = (c.transform for c in of_bits(net, 3).connections)  # type: ignore[union-attr]
    np.testing.assert_allclose(first, [[1.0, 1.0 / 3.0], [0.0, -2.0 / 3.0]])
    np.testing.assert_allclose(second, [[0.8, 0.0]])


CLOSE = '''
def close(player, seed):
    """Whether left, of 0.5 and 0.4, has more spikes of its first channel than of its second."""
    player.begin()
    one = player([400.0, 0.0], 0.4)[0]
    player.begin()
    return float(one > player([0.0, 400.0], 0.4)[0])
'''


def test_a_task_that_hangs_on_a_small_weight_loses_by_few_bits(tmp_path: Path) -> None:
    write_program(tmp_path / "p.toml", map_on("rolls", NET))
    (tmp_path / "close.py").write_text(CLOSE)
    asked = Scenario(program=str(tmp_path / "p.toml"), task=f"{tmp_path / 'close.py'}:close", seed=3)
    found = resolved(asked, (2, 8))
    assert [(each.bits, each.score, each.lost) for each in found] == [(2, 0.0, 1.0), (8, 1.0, 0.0)]
    assert fewest_bits(found) == 8


def test_without_bits_nothing_is_played() -> None:
    assert resolved(Scenario(program="none.toml", task="none.py:none"), ()) == ()


def test_the_fewest_bits_are_those_from_which_on_nothing_is_lost() -> None:
    lost = {2: 0.4, 3: 0.01, 4: 0.05, 6: 0.0, 8: 0.02}
    found = [Resolved(bits, 1.0 - each, each) for bits, each in lost.items()]
    assert fewest_bits(found) == 6
    assert fewest_bits(found[:3]) is None
    assert fewest_bits([]) is None


def test_numbers_of_bits_are_read_and_others_refused() -> None:
    assert bits_of("") == ()
    assert bits_of("6,2, 4,4") == (2, 4, 6)
    for text, told in (("1", '"1"'), ("3,x", '"x"'), ("17", '"17"'), ("2,,3", '""'), ("2.5", '"2.5"')):
        with pytest.raises(ParameterError, match=f"bits: {told}, must be whole numbers from 2 to 16"):
            bits_of(text)
