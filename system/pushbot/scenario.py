"""What a run of the Pushbot is asked to do: scene, architecture of the network, readout, and the silicon."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from system.option import check_options, option
from system.options.codes import check_codes
from system.options.noise import Noisy, check_device_noise, noise_option, noise_seed_option
from system.options.rolls.process import MadeIn
from system.pushbot.body import Factors
from system.pushbot.brain import FIELD_SCENES, Architecture
from system.pushbot.network.codes import MODIFIED, PLAIN
from system.pushbot.readout import DIRECT, LOOK, REFERENCE, Readout
from system.pushbot.readout import Kind as ReadoutKind
from system.worlds.arena.file import load_scene
from system.worlds.arena.scene import Scene, recoloured

DEFAULT_SCENE = "single-block"
TURN_FACTOR = 0.5  # the only one that the paper names with 0.35 m/s: Table 1, sections 3.5 and 3.7
MODIFIED_TURN_FACTOR = 2.0  # of the modified architecture, whose turns are short; ours


@dataclass(frozen=True, slots=True)
class Scenario(MadeIn):
    """One drive of a Pushbot in a scene.

    Attributes
    ----------
    scene : str
        Name of the scene, or of a file that ends with .toml.
    speed_factor : float
        Factor of equation (2), dimensionless.
    turn_factor : float or None
        Factor of equation (1), dimensionless; that of the architecture unless given.
    window : float or None
        Time in which spikes are counted, s; that of the architecture unless given.
    readout : str
        How spikes become commands, one of `system.pushbot.readout.KINDS`.
    modified : bool
        Whether the network is the modified architecture (section 3.4).
    dropped : float
        Share of the events that are dropped at random.
    colour : str or None
        Colour of the blocks; the scene's unless given.
    light : str or None
        Light on the floor, as `dark` or `500lux`; the scene's unless given.
    target : bool or None
        Whether the target field gets events; where the scene has a target unless given.
    duration : float or None
        Time after which the run ends, s; the scene's unless given.
    way : float or None
        Way after which the run ends too, m; none unless given.
    exc : int
        How many neurons fire constantly.
    frame, raise_lateral : bool
        As `frame` and `raised` of `Architecture`.
    silicon_noise : str
        Which noise the chip's devices make.
    noise_seed : int or None
        Seed of that noise; `seed` unless given.

    Raises
    ------
    ParameterError
        A field breaks its rule; the text names it.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = (PLAIN, MODIFIED)

    scene: str = option(
        DEFAULT_SCENE,
        "Its name, or a FILE.toml",
        metavar="SCENE",
        study=True,
        names="system.worlds.arena.file:scene_names",
    )
    speed_factor: float = option(
        0.5, "Of equation (2), the usual one about 0.35 m/s", unit="", study=True, key="speed_factor"
    )
    turn_factor: float | None = option(
        None, "Of equation (1), 0.5, or 2 for the modified architecture, unless given", unit="", study=True
    )
    window: float | None = option(
        None, "In which spikes are counted, 500ms unless told otherwise", unit="s", study=True
    )
    readout: ReadoutKind = option(
        "sliding", "As fixed a command at each window's end, as spikes to the motors", study=True
    )
    modified: bool = option(
        default=False, about="Gyro-driven suppression and graded weights (section 3.4)", study=True
    )
    dropped: float = option(
        0.8, "Of events that are dropped at random", name="drop", unit="", metavar="SHARE", study=True
    )
    colour: str | None = option(None, "Of the blocks, as blue, red or yellow", study=True, key="")
    light: str | None = option(None, "As normal, dark, very-dark, or 500lux", study=True, key="")
    target: bool | None = option(
        None, "Events to the target field; where the scene has a target", study=True, key=""
    )
    duration: float | None = option(
        None, "After which the run ends; the scene's", unit="s", above=0.0, study=True, key=""
    )
    way: float | None = option(
        None, "After which the run ends too; none", unit="m", above=0.0, study=True, key=""
    )
    exc: int = option(16, "Neurons that fire constantly", study=True, key="")
    frame: bool = option(
        default=False, about="A target frame that keeps its orientation, on a second chip", study=True, key=""
    )
    raise_lateral: bool = option(
        default=False, about="Stronger lateral weights while the target is lost", study=True, key=""
    )
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self)
        check_codes(self)
        check_device_noise(self)

    def read(self) -> Readout:
        """Return how spikes become commands."""
        usual = DIRECT if self.readout == "spikes" else (LOOK if self.modified else REFERENCE)
        window = self.window if self.window is not None else usual
        turn = MODIFIED_TURN_FACTOR if self.modified else TURN_FACTOR
        turn = self.turn_factor if self.turn_factor is not None else turn
        return Readout(Factors(self.speed_factor, turn), window, self.readout)

    def architecture(self) -> Architecture:
        """Return which network is on the chip."""
        target = self.target if self.target is not None else self.scene in FIELD_SCENES
        return Architecture(self.modified, target, self.exc, self.frame, self.raise_lateral)


def scene_of(scenario: Scenario) -> Scene:
    """Return the scene of a scenario in its light and colour.

    What is scattered in the scene is drawn from the scenario's seed.
    """
    scene = load_scene(scenario.scene, seed=scenario.seed, light=scenario.light)
    return scene if scenario.colour is None else recoloured(scene, scenario.colour)


def check_scene(scenario: Scenario) -> None:
    """Raise an error for a readout, scene, light or colour that there is none of."""
    scenario.read()
    scene_of(scenario)
