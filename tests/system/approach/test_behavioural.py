"""The compiled loop of the approach against the general one, with the same models."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.boards.vocalization.model import VocalizationModel
from chips.boards.vocalization.noise import phase_after_call
from chips.hearing.model import hearing_on
from chips.noise import SiliconNoise
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.approach import behavioural as behavioural_approach
from system.approach import loop as approach_loop
from system.approach.kernel import Scene
from system.approach.kernel import echo_delay as compiled_delay
from system.approach.run import run, run_in_loop
from system.approach.scenario import Scenario
from system.loop import AnalogWire
from system.worlds.sound.acoustics import echo_delay
from system.worlds.sound.targets import Approach, ConstantVelocity, Target, Waypoints, default_scene

SCENE = (Target("target", Approach(1.6, 1.1, 0.5)), Target("clutter", Approach(2.6, 2.1, 0.5), 1.5))
BASE = Scenario(SCENE, 1.0, level="behavioural")


@pytest.mark.parametrize(
    "scenario",
    [
        BASE,
        replace(BASE, isolation=False),
        replace(BASE, amplitude_law="d4"),
        # windows of calibrated dies overlap, and a marginal spike of a burst may be that of one loop alone
        replace(BASE, temperature_c=20.0, die=Die(number=1003, process=False), codes="default"),
        Scenario(duration=2.0, level="behavioural"),
        # the hearing's noise is solved at each of a course's temperatures: here at 2, below not at 31
        replace(BASE, course=((0.0, 27.0), (0.5, 26.9), (1.0, 27.0))),
        replace(BASE, course=((0.0, 27.0), (0.5, 25.0), (1.0, 28.0)), silicon_noise="off"),
    ],
    ids=["plain", "without isolation", "d4", "die", "default", "course", "long course"],
)
def test_both_loops_give_the_same_run(scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    # the general loop would thin the proximity to 1 mV
    monkeypatch.setattr(approach_loop, "AnalogWire", lambda *ends: AnalogWire(*ends[:4], 0.0))
    fast, slow = run(scenario), run_in_loop(scenario)
    assert fast.calls.shape == slow.calls.shape
    assert [n for _, n in fast.spikes] == [n for _, n in slow.spikes]
    assert fast.pulses.size == slow.pulses.size
    assert fast.echoes.size == slow.echoes.size
    # neurons are stepped otherwise: their spikes differ by some us, and so do the calls that follow
    assert np.abs(fast.calls[:, 0] - slow.calls[:, 0]).max(initial=0.0) < 20e-6
    assert np.abs(fast.calls[:, 1] - slow.calls[:, 1]).max(initial=0.0) < 0.5e-3
    # the general loop notes the proximity at the ends of its rounds only, with straight lines between
    assert np.abs(fast.proximity_V - slow.proximity_V).max() < 50e-3
    assert fast.counts["clipped_sounds"] == slow.counts["clipped_sounds"]
    assert fast.counts["undecided_sounds"] == slow.counts["undecided_sounds"]


def test_the_room_of_the_log_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = run(BASE)
    monkeypatch.setattr(behavioural_approach, "ROWS", 100)
    pieces = run(BASE)
    assert np.array_equal(whole.calls, pieces.calls)
    assert whole.spikes == pieces.spikes
    assert np.array_equal(whole.proximity_V, pieces.proximity_V)


def test_the_compiled_delay_is_the_delay() -> None:
    paths = (Approach(4.0, 0.5, 1.0), ConstantVelocity(1.0, 2.0), Waypoints((0.5, 1.0, 3.0), (1.0, 2.0, 0.7)))
    targets = tuple(Target(f"t{i}", path) for i, path in enumerate(paths))
    laid = [list(behavioural_approach._waypoints(t, 5.0)) for t in targets]
    for k, (target, points) in enumerate(zip(targets, laid, strict=True)):
        table = np.array([points])
        scene = Scene(
            table[:, :, 0].copy(), table[:, :, 1].copy(), np.ones(1), 345.0, 0.0, 1e-4, 1.0, 1.0, 2.5
        )
        for time in (0.0, 0.7, 1.9, 3.9):
            expected = float(echo_delay(target.trajectory, time, 345.0))
            assert compiled_delay(scene, 0, time) == pytest.approx(expected, abs=1e-11), (k, time)


def test_a_target_that_leaves_its_path_is_refused() -> None:
    gone = (Target("gone", ConstantVelocity(1.0, -0.9)),)
    with pytest.raises(ParameterError, match="range"):
        run(replace(BASE, targets=gone, duration=3.0))


def test_a_long_flight_forgets_old_sounds() -> None:
    trace = run(Scenario(default_scene(), 8.0, level="behavioural"))
    assert trace.echoes.size > 3 * behavioural_approach.SOUNDS // 2
    assert trace.echoes.size == 3 * trace.pulses.size


def test_noise_moves_calls_and_echoes_as_their_models_draw_it() -> None:
    noisy = replace(BASE, duration=0.4, seed=1)
    quiet = replace(noisy, silicon_noise="off")
    plain, jittered = run(quiet), run(noisy)
    noise = SiliconNoise(1)
    model = VocalizationModel(Silicon(AMI_1500_IDEAL), noise=noise)
    # with no target found yet the interval is that of 5 Hz, and lacks the phase that the call left
    late = -phase_after_call(model.noise, 0, model.numbers.base) / model.numbers.base
    moved = jittered.calls[:, 0] - plain.calls[:, 0]
    assert abs(late) > 1e-6
    assert moved[0] == 0.0
    assert np.sign(moved[1]) == np.sign(late)
    assert abs(moved[1]) < 2.0 * abs(late)  # a proximity that rises meanwhile makes intervals shorter
    ears = hearing_on(Silicon(AMI_1500_IDEAL), noise=noise)
    assert 1e-9 < abs(jittered.echoes[1] - plain.echoes[1]) < 1e-5
    assert ears.noise.onset.size > 0
    assert jittered.pulses[0] != plain.pulses[0]
    assert quiet.noisy_boxes == ()
    assert noisy.noisy_boxes == ("chip", "vocalization", "hearing")
    assert replace(noisy, transistors=frozenset({"hearing"})).noisy_boxes == ("chip", "vocalization")
