"""The page in a real browser: it loads, plays, scrubs, is steered by keys, and asks no host for anything."""

import json
import math
import os
import shutil
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from circuits.solver.transient import simulate
from system.approach import healing
from system.options.block import choose
from system.options.silicon import SiliconChoice
from system.registry import load_system
from system.schematic.film import film_of
from system.view.film import Film
from system.view.page import write_page
from tests.system.view.films import film

BROWSER, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
if (BROWSER is None or DRIVER is None) and os.environ.get("CI") != "true":
    pytest.skip("chromium and chromedriver are not here; apt has both", allow_module_level=True)
FOLLOWER = Path(__file__).parents[3] / "examples" / "circuits" / "follower.py"
READY = 20.0  # s of wall clock; ours, with room for a busy machine


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    assert DRIVER is not None, "CI needs chromium and chromedriver"
    options = webdriver.ChromeOptions()
    for argument in (
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-dev-shm-usage",
        "--window-size=1000,1400",
    ):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    found = webdriver.Chrome(options=options, service=Service(DRIVER))
    yield found
    found.quit()


def opened(browser: Any, path: Path) -> Any:
    """The page in the browser, once it is ready."""
    browser.get(path.as_uri())
    until(lambda: browser.execute_script("return !!window.noctule"))
    return browser.find_element(By.TAG_NAME, "body")


def until(true: Any) -> None:
    """Wait for something to be true."""
    last = time.monotonic() + READY
    while not true():
        assert time.monotonic() < last
        time.sleep(0.02)


def now(browser: Any) -> float:
    return float(browser.execute_script("return noctule.state.t"))


def shown(browser: Any, name: str) -> list[str]:
    """What stands beside a name in the state of all panels."""
    rows = browser.find_elements(By.CSS_SELECTOR, ".state div")
    found = [row.find_elements(By.XPATH, "./*") for row in rows]
    return [value.text for what, value in found if what.text == name]


@pytest.fixture(scope="module")
def one(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("view") / "one.html"
    write_page(str(path), [film()])
    return path


def test_it_shows_the_right_number_at_a_time(browser: Any, one: Path) -> None:
    opened(browser, one)
    browser.execute_script("noctule.seek(4.0)")
    assert shown(browser, "ramp") == ["12"]
    spikes, f = shown(browser, "in 100 ms")[0], film()
    raster = f.panels[1].raster
    assert raster is not None
    count = int(((raster.time > 3.9) & (raster.time <= 4.0)).sum())
    assert spikes == f"{count} spikes"
    assert f.eye is not None
    events = int(((f.eye.time > 3.96) & (f.eye.time <= 4.0)).sum())
    captions = " ".join(c.text for c in browser.find_elements(By.TAG_NAME, "figcaption"))
    assert f"{events} events in the last 40 ms of 2000" in captions


def test_it_plays_and_scrubs_by_keys(browser: Any, one: Path) -> None:
    body = opened(browser, one)
    body.send_keys(" ")
    until(lambda: now(browser) > 0.1)
    body.send_keys(" ")
    held = now(browser)
    assert held < 10.0
    body.send_keys(Keys.ARROW_RIGHT)
    assert now(browser) == pytest.approx(held + 0.1)  # a hundredth of what is shown
    body.send_keys(Keys.END)
    assert now(browser) == 10.0
    body.send_keys(Keys.HOME)
    assert now(browser) == 0.0
    body.send_keys("i")
    assert browser.execute_script("return noctule.state.to - noctule.state.from") == pytest.approx(5.0)
    body.send_keys("0")
    assert browser.execute_script("return noctule.state.to - noctule.state.from") == pytest.approx(10.0)


def test_a_click_goes_to_a_time_and_into_a_neuron(browser: Any, one: Path) -> None:
    opened(browser, one)
    panels = browser.find_elements(By.CSS_SELECTOR, ".stack canvas:last-child")
    webdriver.ActionChains(browser).move_to_element(panels[0]).click().perform()
    assert now(browser) == pytest.approx(5.0, abs=0.05)
    (button,) = [b for b in browser.find_elements(By.CSS_SELECTOR, ".state button") if "neuron[2]" in b.text]
    button.click()
    inside = browser.find_element(By.ID, "inside")
    assert "neuron[2]: 2 devices" in inside.text
    assert "V_T0 +5.00 mV" in inside.text
    assert [float(text) for text in shown(browser, "v_mem")] == pytest.approx(
        [math.sin(now(browser))], abs=1e-3
    )


@pytest.fixture(scope="module")
def follower() -> Film:
    """An amplifier that follows a step, with its schematic."""
    chosen = choose(f"{FOLLOWER}:step", silicon=SiliconChoice(die=1003))
    return film_of(simulate(chosen.testbench(), chosen.silicon), ("v_in", "v_out"))


def test_a_schematic_shows_what_there_is_at_the_cursor(browser: Any, tmp_path: Path, follower: Film) -> None:
    write_page(str(tmp_path / "circuit.html"), [follower])
    body = opened(browser, tmp_path / "circuit.html")
    volts, amperes = follower.panels
    at = 0.21e-3
    browser.execute_script(f"noctule.seek({at})")
    texts = [t.text for t in browser.find_elements(By.CSS_SELECTOR, ".schematic text")]
    told = {line.name: float(np.interp(at, line.time, line.value)) for line in (*volts.lines, *amperes.lines)}
    assert f"v_out {told['v_out']:.3f}V" in texts
    assert f"{1e9 * told['tail']:.3g}nA" in texts
    device = browser.find_element(By.CSS_SELECTOR, '.schematic [aria-label="mirror"]')
    browser.execute_script("arguments[0].focus()", device)
    device.send_keys(Keys.ENTER)
    inside = browser.find_element(By.ID, "inside").text
    assert "pFET 6/6 um; drain v_out" in inside
    assert "current of mirror" in inside
    drawn = "return noctule.films[0].panels[0].lines.filter(l => l.shown).map(l => l.name)"
    assert browser.execute_script(drawn) == ["v_in", "v_out"]
    webdriver.ActionChains(browser).move_to_element(
        browser.find_element(By.CSS_SELECTOR, '.schematic [aria-label="net v_s"] text')
    ).click().perform()
    assert browser.execute_script(drawn) == ["v_in", "v_out", "v_s"]
    body.send_keys(Keys.HOME, Keys.ARROW_RIGHT)
    assert now(browser) == pytest.approx(follower.duration / 100)
    assert browser.find_element(By.ID, "clock").text == "5.000 us of 500 us"
    body.send_keys(" ")
    until(lambda: now(browser) > follower.duration / 50)
    assert browser.get_log("browser") == []


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_it_is_readable_in_dark_and_light(browser: Any, one: Path, theme: str) -> None:
    body = opened(browser, one)
    for _ in range(2):
        if browser.execute_script("return document.documentElement.dataset.theme") != theme:
            body.send_keys("d")
    colours = "return ['color', 'backgroundColor'].map(c => getComputedStyle(document.body)[c])"
    ink, back = (
        [int(v) / 255 for v in text[4:-1].split(",")[:3]] for text in browser.execute_script(colours)
    )
    bright = [
        sum(w * _linear(v) for w, v in zip((0.2126, 0.7152, 0.0722), c, strict=True)) for c in (ink, back)
    ]
    assert (max(bright) + 0.05) / (min(bright) + 0.05) > 7.0  # WCAG's AAA
    assert (bright[0] > bright[1]) == (theme == "dark")


def _linear(v: float) -> float:
    return v / 12.92 if v <= 0.04045 else float(((v + 0.055) / 1.055) ** 2.4)


def test_two_films_run_beside_each_other(browser: Any, tmp_path: Path) -> None:
    write_page(str(tmp_path / "two.html"), [film(), replace(film(), title="another")])
    opened(browser, tmp_path / "two.html")
    browser.execute_script("noctule.seek(2.0)")
    assert shown(browser, "ramp") == ["6", "6"]
    assert [h.text for h in browser.find_elements(By.TAG_NAME, "h1")] == ["a robot", "another"]


def test_no_error_and_no_request_to_any_host(browser: Any, one: Path) -> None:
    for kind in ("browser", "performance"):
        browser.get_log(kind)
    opened(browser, one)
    assert browser.get_log("browser") == []
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    asked = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    assert asked
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []


def test_from_the_loss_of_a_target_to_its_transistor_by_clicks(
    browser: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(healing, "MOST", 1)
    approach = load_system("approach")
    die = replace(approach.settings["die"].default, number=1002)
    scenario = approach.on_silicon(level="behavioural", codes="default", die=die, duration=3.2)
    film = approach.filmed(approach.run(scenario), ["neuron[2]"])
    (k,) = [k for k, one in enumerate(film.moments) if one.neuron == "neuron[2]"]
    moment = film.moments[k]
    write_page(str(tmp_path / "lost.html"), [film])
    opened(browser, tmp_path / "lost.html")
    clicks = 0

    def click(css: str) -> None:
        nonlocal clicks
        webdriver.ActionChains(browser).click(browser.find_element(By.CSS_SELECTOR, css)).perform()
        clicks += 1

    click(f".moment:nth-of-type({k + 1})")
    assert now(browser) == pytest.approx(moment.time)
    assert browser.execute_script("return noctule.state.chosen") == moment.neuron == "neuron[2]"
    first = browser.find_element(By.CSS_SELECTOR, "#inside tbody tr").text
    assert "neuron[2].membrane.mr1" in first.replace("\n", "")
    assert "ms after the echo" in first
    click("#inside tbody tr td button")
    assert shown(browser, "v_mem healed") != []
    assert "membrane.mr1 healed alone" in browser.find_element(By.ID, "inside").text
    assert clicks <= 6
