"""Draws on a graphics processor beside those of dies, by what stands in for one."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.programs import gpu
from circuits.silicon.die import Die, Path, _key, _keys, normals_of, place_names, places_of
from circuits.silicon.draws_on_gpu import normals_on_gpu
from tests.circuits.programs.stand_in import COMPILER, stand_in

PATHS: list[Path] = [(("neuron", (2, 3)), ("m1", ())), (("m2", ()),), (("x" * 150, ()), ("m3", ()))]


@pytest.mark.skipif(COMPILER is None, reason="no C++ compiler, which stands in for a graphics processor")
def test_draws_are_those_of_the_dies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gpu, "cupy", stand_in)
    gpu._compiled.cache_clear()
    place = (("chip", ()), ("row", (3,)))
    owners = [f"({lot!r}, {number!r}, " for lot in ("A", "5") for number in range(60)]
    names, places = [place_names(place, path) for path in PATHS], places_of(place, PATHS)
    ours = normals_on_gpu(owners, names, places, "v_t0")
    assert ours.shape == (120, 8)
    # the tails take a logarithm, whose last bit a device may have another way
    np.testing.assert_allclose(ours, normals_of(owners, names, places, "v_t0"), rtol=1e-14)
    gpu._compiled.cache_clear()


def test_without_a_graphics_processor_the_error_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    places = places_of((), PATHS)
    monkeypatch.setattr(gpu, "_imported", lambda: None)
    assert not gpu.there_is_one()
    with pytest.raises(
        ParameterError, match=r"device: gpu, needs CuPy; install noctule\[gpu\]; or leave the device"
    ):
        normals_on_gpu(["(1, 2, "], ["a", "b", "c"], places, "v_t0")


def test_keys_of_many_dies_are_those_of_each() -> None:
    dies = [Die(lot="5", number=k) for k in (5, 55, 2**40)]
    assert _keys(dies) == [_key(each, (), "v_t0") for each in dies]
