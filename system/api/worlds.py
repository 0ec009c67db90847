"""What robots live in, see and hear:scenes, the event camera, sound and its targets."""

from system.worlds.arena.file import load_scene, scene_names
from system.worlds.arena.geometry import collision, obstacles_of
from system.worlds.arena.scene import Scene
from system.worlds.camera.event import Events
from system.worlds.camera.file import read_events, write_events
from system.worlds.camera.sensor import Dvs
from system.worlds.sound.acoustics import speed_of_sound
from system.worlds.sound.microphone import Microphone
from system.worlds.sound.targets import (
    Approach,
    ConstantVelocity,
    Target,
    Waypoints,
    default_scene,
    read_targets,
)

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Scenes
    "scene_names",
    "load_scene",
    "Scene",
    "obstacles_of",
    "collision",
    # Event camera
    "Dvs",
    "Events",
    "read_events",
    "write_events",
    # Sound
    "speed_of_sound",
    "Microphone",
    "Target",
    "ConstantVelocity",
    "Waypoints",
    "Approach",
    "default_scene",
    "read_targets",
]
