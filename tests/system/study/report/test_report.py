"""The report is one page without references, has every part, and shows in a browser."""

from __future__ import annotations

import math
import re
import shlex
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import matplotlib.image as mpimg
import numpy as np
import pytest

from circuits.lowering.kernel import Machine
from system.cli.command_line import main
from system.study.folder import REPORT as FILE

BLOCK = "rebound-neuron"
HERE = "tests.system.study.report.test_report"
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")
WITH_BROWSER = 60.0  # s that a browser may take to start on a busy machine


def planted(machine: Machine) -> float:
    """A metric with a failed die and an undefined one."""
    number = machine.silicon.die.number
    if number == 1007:
        raise ZeroDivisionError("<b>no</b> slope & more")
    return math.nan if number == 1009 else math.exp(30.0 * float(machine.kernel.transistors.v_t0[4]))


class Page(HTMLParser):
    """Tags, references and text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.references: list[str] = []
        self.codes: list[str] = []
        self.words = ""
        self.open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag not in {"meta", "img"}:
            self.open.append(tag)
        self.references += [v or "" for k, v in attrs if k in {"src", "href", "xlink:href", "srcset", "data"}]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words += data
        if self.open[-1:] == ["code"]:
            self.codes.append(data)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "my study"
    asked = ["--metric", f"{HERE}:planted", "--spec", "planted in 6e7:8e7", "--contributions", "planted"]
    conditions = ["--corner", "random", "--corner", "ss", "--no-process-variation"]
    assert main(["montecarlo", BLOCK, "-n", "24", *asked, *conditions, "-o", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def page(folder: Path) -> Page:
    return Page((folder / FILE).read_text(encoding="utf-8"))


def test_it_is_self_contained(page: Page, folder: Path) -> None:
    assert not page.open
    assert not {"script", "link", "iframe", "object", "base"} & set(page.tags)
    assert page.references
    pages = [r for r in page.references if not r.startswith("data:image/png;base64,")]
    assert pages
    assert all(re.fullmatch(r"die-10\d\d-(random|ss)\.html", r) for r in pages)
    text = (folder / FILE).read_text(encoding="utf-8")
    assert "http" not in text
    assert "@import" not in text
    assert "url(" not in text


def test_it_has_every_part(page: Page) -> None:
    for part in (
        "Monte Carlo study of rebound-neuron", "A/1000 to 1023", "random, seed 0", "numpy ",
        "At 27 degC", "At 27 degC, corner ss", "Classes", "Yield: ", "Clopper-Pearson", "planted not defined",
        "quantile 50 %", "22 samples defined, 2 not defined", "Contributions to the variance of ln planted",
        "by device", "rebound_neuron.inhibition.mi5", "unexplained", "Worst samples",
    ):  # fmt: skip
        assert part in page.words, part
    assert page.tags.count("img") == 6  # a metric, waveforms and a Pareto picture at each corner


def test_it_shows_waveforms_of_the_nominal_die_and_of_some(page: Page, folder: Path) -> None:
    alts = re.findall(r'alt="(Waveforms of [^"]+)"', (folder / FILE).read_text(encoding="utf-8"))
    assert len(alts) == 2
    assert all(
        re.search(r"nominal die, die 10\d\d, median: \S+, die 1007, worst: failed", alt) for alt in alts
    )


def test_texts_are_escaped(page: Page, folder: Path) -> None:
    assert "failed: ZeroDivisionError: <b>no</b> slope & more" in page.words
    assert "b" not in page.tags
    assert "<b>no" not in (folder / FILE).read_text(encoding="utf-8")


def test_its_commands_run(page: Page, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    commands = [shlex.split(text) for text in page.codes if text.startswith("noctule replay")]
    for die, corner in (("1007", "ss"), ("1009", "random")):
        own = ["--metric", f"{HERE}:planted"]  # code, which the study's own file may not load
        view = ["--view", str(folder / f"die-{die}-{corner}.html")]
        assert ["noctule", "replay", str(folder), "--die", die, "--corner", corner, *own, *view] in commands
    assert main(commands[-1][1:]) == 0
    assert Path(commands[-1][-1]).name in page.references
    assert "schematic" in Path(commands[-1][-1]).read_text("utf-8")
    assert "identical to what was kept" in capsys.readouterr().out


def test_the_same_study_gives_the_same_page(folder: Path) -> None:
    before = (folder / FILE).read_bytes()
    asked = ["--metric", f"{HERE}:planted", "--spec", "planted in 6e7:8e7", "--contributions", "planted"]
    conditions = ["--corner", "random", "--corner", "ss", "--no-process-variation", "--resume"]
    assert main(["montecarlo", BLOCK, "-n", "24", *asked, *conditions, "-o", str(folder)]) == 0
    assert (folder / FILE).read_bytes() == before


@pytest.mark.skipif(BROWSER is None, reason="no browser (apt-get install chromium)")
def test_a_browser_shows_it(folder: Path, tmp_path: Path) -> None:
    shot = tmp_path / "page.png"
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1100,2000"]
    places = [f"--user-data-dir={tmp_path / 'profile'}", f"--screenshot={shot}"]
    address = (folder / FILE).absolute().as_uri()
    subprocess.run(
        [str(BROWSER), *options, *places, address], check=True, capture_output=True, timeout=WITH_BROWSER
    )
    pixels = np.asarray(mpimg.imread(shot))[:, :, :3]
    assert pixels.shape[0] > 1000
    dark = (pixels.mean(axis=2) < 0.5).mean()
    assert 0.003 < dark < 0.5  # text and bars, on a light ground
    blue = (pixels[:, :, 2] > pixels[:, :, 0] + 0.4).mean()
    assert blue > 0.002  # the bars of a histogram
