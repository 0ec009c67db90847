"""The Pushbot step by step:its network on ROLLS, its body, and drives through a scene."""

from system.pushbot.body import Pushbot, forward_of, turn_of
from system.pushbot.drive import Readings, Run, begin_run, go_on, steer
from system.pushbot.loop import open_loop, rates, step
from system.pushbot.network.plain import NOTEBOOK, PAPER, PushbotLevels, pushbot_network
from system.pushbot.run import Trace, make_brain, run
from system.pushbot.scenario import Scenario, scene_of
from system.pushbot.scene_picture import draw_path, draw_scene

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Network and chip
    "pushbot_network",
    "PushbotLevels",
    "PAPER",
    "NOTEBOOK",
    # Body and drive
    "Pushbot",
    "forward_of",
    "turn_of",
    "begin_run",
    "Run",
    "steer",
    "go_on",
    "Readings",
    "draw_scene",
    "draw_path",
    # The closed loop
    "Scenario",
    "scene_of",
    "run",
    "make_brain",
    "Trace",
    "open_loop",
    "step",
    "rates",
]
