"""What is wrong with the options of `noctule run` is one line on stderr, and nothing else happens."""

from __future__ import annotations

from collections.abc import Callable

import pytest

CHIP, SPIKES = ("--brain", "chip"), ("--brain", "network")  # of a spiking bat
WRONG: dict[str, list[tuple[tuple[str, ...], str]]] = {
    "rovr": [((), "system rovr: unknown; did you mean rover?")],
    "approach": [(("--map", "map2"), "No such option: --map")],
    "bug": [
        (("--agent", "bug3"), "--agent: bug3, must be bug0, bug1 or bug2"),
        (("--brain", "cortex"), "--brain: cortex, must be reference, ideal or chip"),
        (("--map", "bug-cop"), "did you mean bug-cup?"),
        (("--start", "1"), '--start: "1", must be a number from 0 to 0'),
        (("--start", "6.5,6.5"), "--start: 6.5,6.5, a wall is 0 away, must be at least the robot's radius"),
        (("--goal", "30,3"), "--goal: 30,3, must be in the map of 26 x 16"),
        (("--duration", "-1s"), "--duration: -1 s, must be >= 0.01"),
        (("--seed", "3"), "--seed: 3, a reference has no neurons"),
        (("--plot", "way.bmp"), "--plot: way.bmp, must end with"),
        (("--die", "3"), "--die: die A/3, no chip is in the loop; add --brain chip"),
        (("--agent", "bug1", "--brain", "ideal"), "--agent: bug1, has no network; use --brain reference"),
        (("--brain", "ideal", "--neurons", "9"), "--neurons: 9, must be from 300 to 40000"),
        (("--design", "improved"), "--design: a reference has no neurons; add --brain ideal"),
    ],
    "car": [
        (("--forest", "wood"), "--forest: wood, must be corridor, open or dense"),
        (("--start", "0m,0.45m"), "--start: 0,0.45, a pipe's surface is -0.025 m away"),
        (("--forest", "none.csv"), "none.csv: No such file or directory, must be a readable file"),
        (("--start", "here"), '--start: "here", must be X,Y; write as in --start 40m,25m'),
        (("--vmax", "0"), "--vmax: 0 m/s, must be > 0"),
        (("--ping-rate", "-12Hz"), "--ping-rate: -12 Hz, must be > 0"),
        (("--temperature", "60"), "--temperature: 60.0, no chip is in the loop"),
        (("--die", "3"), "--die: die A/3, no chip is in the loop"),
        (("--ranges", "exact", "--occlusion"), "--occlusion: not with --ranges exact"),
        (("--ranges", "sonar"), "--ranges: sonar, must be flight, exact or chip"),
        (("--plot", "way.bmp"), "--plot: way.bmp, must end with"),
        (("--pings", "0"), "--pings: 0, must be >= 1"),
    ],
    "forest": [
        (("--obstacles", "9000"), "--obstacles: 9000, must fit 50 x 50 m"),
        (("--vmax", "0"), "--vmax: 0 m/s, must be > 0"),
        (("--ping-rate", "-5Hz"), "--ping-rate: -5 Hz, must be > 0"),
        (("--map", "/nonexistent.csv"), "/nonexistent.csv: No such file"),
        (("--plot", "way.bmp"), "--plot: way.bmp, must end with"),
        (("--ranges", "radar"), "--ranges: radar, must be exact, sonar or chip"),
        (("--die", "3"), "--die: no chip is in the loop"),
        (("--temperature", "60"), "--temperature: 60 degC, must be 27"),
        (("--weights", "none"), "--weights: none, must be fixed or speed"),
        (("--animate", "way.mov"), "--animate: way.mov, must end with .gif"),
        (("--animate", "/nonexistent/way.gif"), "there is no folder /nonexistent"),
        (("--occlusion",), "--occlusion: not with --ranges exact"),
        (("--ranges", "chip", "--area", "0"), "ranging.area: 0 times"),
        (("--model", "latency-chip"), "--model: is no option now"),
        (("--taps", "15"), "No such option: --taps"),
    ],
    "head": [
        (("--ping-rate", "0"), "--ping-rate: 0 Hz, must be > 0"),
        (("--ping-rate", "90Hz"), "an echo from 1.4 m takes"),
        (("--azimuth", "100deg"), "behind the head"),
        (("--gain=-2deg",), "--gain: -2 deg, must be >= 0"),
        (("--duration", "5V"), "--duration"),
        (("--temperature", "80"), "sonar_head.temperature: 80 degC, must be -10 to 65 degC"),
    ],
    "pushbot": [
        (("--events", "events.dat"), "events.dat: must end with .aedat4, .npz, .txt"),
        (("--way", "0"), "--way: 0 m, must be > 0"),
        (("--speed-factor", "0"), "speed_factor: 0, must be above 0"),
        (("--scene", "nowhere"), "scene nowhere: unknown"),
        (("--exc", "60"), "population.target: 128 neurons, must be <= 116"),
        (("--window", "70ms"), "--window: 0.07 s"),
        (("--readout", "mean"), "--readout: mean, must be fixed, sliding or spikes"),
        (("--readout", "spikes", "--window", "50ms"), "--window: 0.05 s, must not be given"),
        (("--frame",), "--frame: without a target"),
        (("--light", "blinding"), "light: blinding"),
        (("--light", "500"), "or an illuminance above 0; write as in 500lux"),
        (("--plot", "way.bmp"), "--plot: way.bmp"),
    ],
    "rover": [
        (("--start", "2"), '--start: "2", must be ROW,COLUMN from 0'),
        (("--goal", "2,-3"), '--goal: "2,-3", must be ROW,COLUMN'),
        (("--goal", "99,0"), "--goal: 99,0, must be in the map of 20 x 20"),
        (("--duration", "2s"), "No such option: --duration"),
        (("--isolation",), "No such option: --isolation"),
        (("--learn", "0"), "--learn: 0, must be above 0"),
        (("--plot", "way.bmp"), "--plot: way.bmp, must end with"),
        (("--temperature", "200"), "200"),
        (("--temperature", "40"), "--temperature: 40.0, no chip is in the loop; add --cells chip"),
        (("--die", "3"), "--die: die A/3, no chip is in the loop"),
        (("--unit", "20us", "--cells", "ideal"), "--unit: 2e-05, no chip is in the loop"),
        (("--bias-kind", "generator"), "--bias-kind: generator, no chip is in the loop"),
    ],
    "spiking-bat": [
        ((*SPIKES, "--paths", "15"), "--paths: 15 memories, must be 33"),
        ((*SPIKES, "--taps", "13"), "--taps: 13, a delay line of 39 ms, must reach the longest"),
        ((*SPIKES, "--taps", "0"), "--taps: 0, must be a whole number from 1 to 64"),
        ((*SPIKES, "--ping-rate", "40Hz"), "a period of 25 ms is shorter than the longest echo, 29.2 ms"),
        ((*SPIKES, "--ping-rate", "15Hz"), "the emergency neuron takes 68 ms"),
        ((*SPIKES, "--ping-rate", "5Hz"), "a period of 200 ms is longer than a memory lasts"),
        ((*SPIKES, "--ranges", "chip"), "No such option: --ranges"),
        ((*SPIKES, "--die", "3"), "--die: die A/3, no chip is in the loop; add --brain chip"),
        ((*SPIKES, "--codes", "usual"), "--codes: no chip is in the loop; add --brain chip"),
        ((*CHIP, "--unit", "33,0"), "latency_chip.memory[33].unit[0]: not on a chip of 33 memories"),
        ((*CHIP, "--unit", "x"), '--unit: "x", must be MEMORY,UNIT'),
        ((*CHIP, "--paths", "15"), "--paths: 15 memories, must be 33"),
        ((*CHIP, "--ping-rate", "40Hz"), "a period of 25 ms is shorter than the longest echo"),
        ((*CHIP, "--temperature", "90"), "latency_chip.temperature: 90 degC, must be -10 to 65"),
        ((*CHIP, "--area", "0"), "latency_chip.area: 0 times"),
        ((*SPIKES, "--animate", "way.gif"), "No such option: --animate"),
    ],
}
CASES = [(system, *case) for system, cases in WRONG.items() for case in cases]


@pytest.mark.parametrize(("system", "arguments", "says"), CASES)
def test_what_is_wrong_is_one_line(
    refused: Callable[..., str], system: str, arguments: tuple[str, ...], says: str
) -> None:
    assert says in refused("run", system, *arguments)
