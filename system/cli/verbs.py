"""The verbs that are neither a simulation nor a study: `list`, `show`, `op`, `export` and others."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from system.cli import shared_options as shared
from system.cli.shared_options import BlockValues, Engine, Level, OnBlock
from system.cli.verb import argument, like, part, required
from system.option import option
from system.options.begin import BeginChoice
from system.options.silicon import USUAL_CELSIUS, SiliconChoice

FRAMES = "960x720@20"  # of moving pictures; `system.animation.movie` reads it
NOMINAL = "nominal"  # instead of a die's number
DIALECTS = "netlists.registry:dialect_names"


@dataclass(frozen=True, slots=True, kw_only=True)
class List:
    """List blocks, chips, systems, experiments and the rest."""

    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Show(OnBlock):
    """Show what a block or chip is made of, or draw its graph. Of rolls, show what a die is like."""

    values: BlockValues = shared.values_part()
    silicon: SiliconChoice = shared.silicon_part()
    stimulus: tuple[str, ...] = shared.stimulus_option()
    metrics: bool = option(default=False, about="Run the testbench, and list all that it measures")
    plot: str | None = shared.plot_option()
    schematic: str | None = shared.file_option("Draw the schematic into a .svg, .png or .pdf file")
    op: bool = option(default=False, about="Write the operating point into the schematic")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Op(OnBlock):
    """Solve for the operating point. Devices have current, inversion and headroom."""

    values: BlockValues = shared.values_part("bias_file")
    silicon: SiliconChoice = shared.silicon_part()
    stimulus: tuple[str, ...] = shared.stimulus_option()
    start: tuple[str, ...] = option((), "Voltage to start from, repeatable", metavar="NODE=V")
    engine: Engine = option("native", "What solves it; ngspice a deck with cards that only it has")
    csv: str | None = shared.file_option("Write a row a device")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Export(OnBlock):
    """Write a block, a chip or a row of rolls as a netlist. Its testbench is part of it."""

    output: str = required("File, or - for stdout", short="o", metavar="FILE")
    stimulus: tuple[str, ...] = shared.stimulus_option()
    values: BlockValues = shared.values_part()
    silicon: SiliconChoice = shared.silicon_part()
    program: str | None = shared.file_option("Of rolls: of noctule map, a CSV of post,pre,level, or pushbot")
    dialect: str = option(
        "ngspice",
        "What to write, as spectre or xschem; see noctule list",
        metavar="NAME",
        names="system.registry:written_names",
    )
    models: Literal["ekv", "bsim3", "sweepable"] = option(
        "ekv", "What transistors are; sweepable: ngspice's temperature and sizes move them"
    )
    begin: BeginChoice = shared.begin_part("at_rest")
    parasitics: str | None = shared.file_option("CSV of node and capacitance, merged in")
    mapping: str | None = option(None, "A foundry's process, as gf180mcu, or a TOML file", metavar="NAME")
    level: Level = option("transistor", "Devices, or a chip's neurons by their reduced equations")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class NetlistReading:
    """How netlists are read."""

    root: str | None = option(None, "Folder of included files; the netlist's own", metavar="DIR")
    dialect: str | None = option(
        None, "Of a netlist without our notes, as cdl", metavar="NAME", names=DIALECTS
    )
    drop: tuple[str, ...] = option(
        (), "What may go though it cannot be honoured: a model, .model for all, .step, an option",
        metavar="NAME,...",
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Import:
    """Read a netlist, and say what was not taken over. Circuit, sources and analyses are shown."""

    file: str = argument("FILE", "A netlist")
    output: str | None = shared.file_option("Write it as a file of Python or another netlist", short="o")
    to: str | None = option(
        None, "What is written: python, or a dialect; by the file's ending unless given", metavar="NAME"
    )
    reading: NetlistReading = part(NetlistReading)
    allow_implausible: bool = like(SiliconChoice, "allow_implausible")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Compare:
    """Compare netlists or blocks; status 1 if they differ."""

    first: str = argument("A", "A netlist, a block, or FILE.py:NAME")
    second: str = argument("B", "What it is compared with, likewise")
    reading: NetlistReading = part(NetlistReading)
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Characterise(OnBlock):
    """Measure a block's behavioural model; takes minutes."""

    block: str = argument(
        "BLOCK", "What has a model, as rebound-neuron; or FILE.py:NAME of a Model",
        names="chips.model:model_names",
    )  # fmt: skip
    output: str | None = shared.file_option("Record to write; in the caches unless given", short="o")
    bias_set: str | None = like(BlockValues, "bias_set")
    process: str | None = like(SiliconChoice, "process")
    law: Literal["ideal", "full"] = like(SiliconChoice, "law")
    update_package: bool = option(default=False, about="Write the package's own record, in a checkout")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Extract:
    """Fit our transistor law to cards, or to measurements."""

    output: str = required("Process's file to write, for --process", short="o", metavar="FILE.toml")
    process: str | None = option(None, "A foundry's process, whose cards ngspice runs", metavar="NAME")
    points: str | None = shared.file_option("CSV of measured drain currents, in its place")
    fit: str | None = option(None, "Folder of a chip's measurements, or coach", metavar="FOLDER")
    conditions: str | None = shared.file_option("What was set at each; the package's unless given")
    only: tuple[str, ...] = option((), "Of --fit, those alone whose names match", metavar="PATTERN")
    base: str | None = option(
        None, "Process that says what points do not; rolls-180 unless given", metavar="NAME"
    )
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Identify:
    """Find the die that a measured chip is; takes minutes."""

    output: str = required("Die's file to write, for --die", short="o", metavar="FILE.toml")
    fit: str = required("Folder of its measurements, or coach", metavar="FOLDER")
    process: str = required("Its process, as noctule extract makes it", metavar="NAME")
    conditions: str | None = shared.file_option("What was set at each; the package's unless given")
    only: tuple[str, ...] = option((), "Those alone whose names match", metavar="PATTERN")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Predict:
    """Predict a chip's measurements with their 95 % bands."""

    chip: Literal["coach"] = argument("CHIP", "The chip: coach")
    output: str = required("Folder to write", short="o", metavar="FOLDER")
    process: str = required("Its process, as noctule extract makes it", metavar="NAME")
    die: str = required("Its die, as noctule identify makes it", metavar="FILE")
    conditions: str | None = shared.file_option("What was set at each; the package's unless given")
    blank: str = option("coach", "Folder of files whose empty columns are filled", metavar="FOLDER")
    fit: str = option("coach", "Folder of measurements that some are put in relation to", metavar="FOLDER")
    only: tuple[str, ...] = option((), "Those alone whose names match", metavar="PATTERN")
    draws: int = option(200, "Draws behind a band")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibrate:
    """Calibrate a chip on a die, as on a bench; takes seconds."""

    chip: str = argument(
        "CHIP",
        "A chip, or the network on one: see noctule list",
        names="system.registry:calibration_names",
    )
    output: str | None = shared.file_option("File of codes to write, for --codes", short="o")
    silicon: SiliconChoice = shared.silicon_part("at", "allow_implausible")
    bias_kind: Literal["ideal", "generator"] = option("generator", "Ideal PTAT currents, or the generator")
    anew: bool = option(default=False, about="Calibrate even where the codes are known")
    update_package: bool = option(default=False, about="Write the package's own codes, in a checkout")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Reproduce:
    """Make a paper's figure again; status 1 if a row disagrees."""

    experiment: str = argument(
        "EXPERIMENT", "An experiment: see noctule list", names="system.registry:experiment_names"
    )
    param: tuple[str, ...] = option((), "Of a campaign, as forests=20", metavar="NAME=COUNT")
    output: str | None = shared.file_option("Keeps a campaign's runs as it goes", short="o")
    resume: bool = option(default=False, about="Go on with the campaign in --output")
    workers: int | None = option(None, "Processes of a campaign")
    scheduler: str | None = option(None, "Dask cluster of a campaign", metavar="ADDRESS")
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class New:
    """Write a small package of your own. It runs, has a test, and says what to change."""

    kind: Literal["block", "chip", "robot", "experiment"] = argument(
        "KIND", "block, chip, robot or experiment"
    )
    name: str = argument("NAME", "Its name, as my-neuron")
    output: str | None = option(None, "Folder that it is written into; this one", short="o", metavar="DIR")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Doctor:
    """Show what is installed, and what mends what is not."""

    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class OnDie:
    """The die and the temperature of a system's run."""

    variation: SiliconChoice = part(
        SiliconChoice, "at", "allow_implausible", "temperature", "process", "law", "die"
    )
    die: str | None = option(
        None,
        "Die of the lot, a number, nominal or a file of one; 1000 unless given",
        metavar="NUMBER|nominal|FILE",
    )
    temperature: str = option(
        USUAL_CELSIUS, "Degrees Celsius, a course as 0s:27,60s:44, or a CSV of one", metavar="DEGC"
    )

    @property
    def silicon(self) -> SiliconChoice:
        """The silicon that the run is on."""
        die = None if self.die in {None, NOMINAL} else self.die
        return shared.of_study(replace(self.variation, temperature=self.temperature, die=die))


@dataclass(frozen=True, slots=True, kw_only=True)
class Run(OnDie):
    """Options that `noctule run` has for every system."""

    ideal: bool = option(default=False, about="Programs, or the papers' equations, in place of every chip")
    seed: int = option(0, "Of noise and worlds")
    plot: str | None = shared.plot_option()
    beside: str | None = option(None, "Run on this die too, and draw it beside", metavar="NUMBER|nominal")
    view: str | None = option(None, "Page that plays the run, for a browser", metavar="FILE.html")
    inside: str | None = option(
        None, "Neurons that the page looks into; eight that spike most", metavar="NAME,..."
    )
    output: str | None = option(None, "Keep the run, for noctule view", short="o", metavar="RUN.nc")
    animate: str | None = option(
        None, "Moving picture of the run, a .mp4, .webm or .gif file", metavar="FILE"
    )
    frames: str = option(
        FRAMES, "Its size, frames a second, and how much faster than the run", metavar="WxH@RATE[xSPEED]"
    )
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """Play a kept run, or two beside each other; or film it."""

    run: str = argument("RUN", "A run that noctule run or simulate has kept by -o RUN.nc")
    beside: str | None = option(None, "Another run, beside it", metavar="RUN.nc")
    output: str = required("Page to write, or a .mp4, .webm or .gif", short="o", metavar="FILE.html")
    frames: str = like(Run, "frames")
    open: bool = option(default=False, about="Show it in the browser")
    as_json: bool = shared.json_option()
