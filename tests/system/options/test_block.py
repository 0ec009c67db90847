"""Text of the command line becomes parameters, biases and stimuli, or one line that names the mistake."""

from dataclasses import dataclass, field

import pytest

from chips.ranging.circuit import CHIP
from circuits.blocks.block import Stimulus
from circuits.blocks.sonar.rebound_neuron import BIAS_SETS, BLOCK
from circuits.count import PULSES
from circuits.devices.source import polyline
from circuits.errors import CircuitError, ParameterError, UnknownNameError
from circuits.registry import BLOCKS, block_names
from circuits.units import quantity
from system.options.begun import read_voltages
from system.options.block import block_of_target, choose, parameters, read_biases, read_params, read_stimuli
from system.options.silicon import SiliconChoice
from tests.chips.whole import WHOLE_CHIPS
from tests.refusals import refusals


@dataclass(frozen=True, slots=True)
class Inner:
    length: float = quantity(1e-6, "m")


@dataclass(frozen=True, slots=True)
class Outer:
    stages: int = quantity(3, "")
    weights: tuple[float, ...] = quantity((1.0, 2.0), "")
    gain: float = quantity(10.0, "")
    cut: float = quantity(1.0, "Hz")
    inner: Inner = field(default_factory=Inner)


def test_units_are_stated_by_fields() -> None:
    units = {p.name: p.unit for p in parameters(Outer())}
    assert units == {"stages": "", "weights": "", "gain": "", "cut": "Hz", "inner.length": "m"}
    assert {p.unit for p in parameters(BLOCK.params())} == {"F"}


def test_a_field_without_a_unit_is_refused() -> None:
    @dataclass(frozen=True, slots=True)
    class Silent:
        membrane_capacitance: float = 600e-15

    with pytest.raises(ParameterError, match=r"Silent\.membrane_capacitance: states no unit"):
        list(parameters(Silent()))


SIZES = ("capacitance", "resistance", "width", "length", "current")


@pytest.mark.parametrize("name", [*BLOCKS, *WHOLE_CHIPS])
def test_every_number_of_every_block_states_its_unit(name: str) -> None:
    block = block_of_target(name)
    for each in parameters(block.params()):
        # a length or a capacitance that is told as a plain number would be taken as farad or metre
        assert each.unit in {"", "A", "F", "Ohm", "m", "um"}
        assert bool(each.unit) == each.name.endswith(SIZES)
    for stimulus in block.stimuli:
        assert stimulus.unit in {"", "A", "Hz", "V", "s"}


def test_sizes_in_micrometre_are_read_in_metre() -> None:
    params = block_of_target("dpi-synapse").params()
    assert read_params(params, ["pair_width=8um", "logic_length=180nm"]) == params
    with pytest.raises(ParameterError, match=r"pair_width.*as in 8um"):
        read_params(params, ["pair_width=8"])


def test_no_number_alone_and_no_other_unit() -> None:
    circuit = BLOCK.build()
    with pytest.raises(ParameterError, match=r"membrane_capacitance.*must be a capacitance in F.*600fF"):
        read_params(BLOCK.params(), ["membrane_capacitance=600"])
    with pytest.raises(ParameterError, match=r"must be a current in A; .* such as 40pA"):
        read_biases(circuit, ["i_inh_tau=40V"])
    with pytest.raises(ParameterError, match=r"as in 2\.4V"):
        read_biases(circuit, ["v_th=2.4"])


def test_parameters_of_every_type() -> None:
    texts = ["stages=4", "weights=3", "gain=2k", "cut=3Hz", "inner.length=2um"]
    assert read_params(Outer(), texts) == Outer(4, (3.0, 3.0), 2000.0, 3.0, Inner(2e-6))
    assert read_params(Outer(), ["weights=1,5"]).weights == (1.0, 5.0)


test_bad_parameters = refusals(
    CircuitError,
    lambda text: read_params(Outer(), [text]),
    [
        ("stages=1.5", "must be a whole number"),
        ("weights=1,2,3", "must be one or 2"),
        ("gain=1,2", "must be one"),
        ("gain=2V", "must be a plain number"),
        ("inner.length=1V", "must be a length in m"),
        ("inner=1", "did you mean inner.length"),
        ("gain", "must be NAME=VALUE"),
        ("gain=", "must be NAME=VALUE"),
        ("=1", "must be NAME=VALUE"),
    ],
)


def test_biases() -> None:
    circuit = BLOCK.build()
    assert read_biases(circuit, ["i_inh_tau=199.9p", "v-th=2.4V"]) == {"i_inh_tau": 199.9e-12, "v_th": 2.4}
    for text in ("i_lim[0]=1uA", "i_lim=1uA,2uA", "v_th=1A"):
        with pytest.raises(ParameterError):
            read_biases(circuit, [text])


def test_a_code_is_its_nominal_current_and_a_fixed_gate_has_none() -> None:
    circuit = BLOCK.build()
    for kind in ("ideal", "generator"):
        found = read_biases(circuit, ["i_lim=1:200"], kind)  # type: ignore[arg-type]
        assert found == {"i_lim": pytest.approx(3.2e-6 * 200 / 256)}
    for text, words in (("i_lim=8:1", "coarse 0 to 7"), ("i_lim=1:0", "fine 1 to 255"), ("v_th=1:2", "v_th")):
        with pytest.raises(ParameterError, match=words):
            read_biases(circuit, [text], "generator")
    with pytest.raises(ParameterError, match=r"i_lim: code 1:200, a fixed gate .* kind generator or ideal"):
        read_biases(circuit, ["i_lim=1:200"])


def test_one_element_of_a_bias() -> None:
    circuit = CHIP.build()
    old = circuit.bias("i_inh_tau").value
    assert isinstance(old, tuple)
    new = read_biases(circuit, ["i_inh_tau[3]=1pA", "i_inh_tau[4]=2pA"])["i_inh_tau"]
    assert new == (*old[:3], 1e-12, 2e-12, *old[5:])
    with pytest.raises(ParameterError, match="it has 13"):
        read_biases(circuit, ["i_inh_tau[13]=1pA"])


def test_stimuli() -> None:
    known = (Stimulus("delay", "s", 1.0, ""), Stimulus("call", "", 1.0, "", can_be_off=True))
    assert read_stimuli(known, []) == {"delay": 1.0, "call": 1.0}
    assert read_stimuli(known, ["delay=2ms", "call=off"]) == {"delay": 2e-3, "call": None}
    assert read_stimuli(known, ["call=off", "call=on"])["call"] == 1.0
    with pytest.raises(ParameterError, match="must have a value"):
        read_stimuli(known, ["delay=off"])


def test_voltages_keep_node_paths() -> None:
    assert read_voltages(["axon.x=1.5V", "v[2]=-1V"], "start") == {"axon.x": 1.5, "v[2]": -1.0}


def test_a_choice_carries_it_all() -> None:
    choice = choose(
        "rebound-neuron",
        ["membrane-capacitance=700fF"],
        ["v_th=2.4V"],
        "ideal",
        SiliconChoice("-20"),
        ["delay=3ms"],
    )
    assert choice.params.membrane_capacitance == 700e-15
    assert choice.circuit.bias("v_th").value == 2.4
    assert {b.kind for b in choice.circuit.biases} == {"ideal", "voltage"}
    assert choice.silicon.temperature_c == -20.0
    assert choice.stimuli["delay"] == 3e-3
    with pytest.raises(UnknownNameError, match="did you mean rebound-neuron"):
        choose("rebound_neuron")


def test_a_named_set_of_biases_and_a_bias_on_top() -> None:
    def values(**options: object) -> dict[str, object]:
        circuit = choose("rebound-neuron", **options).circuit  # type: ignore[arg-type]
        return {b.name: b.value for b in circuit.biases}

    assert values(bias_set="facts") == values()
    assert values(bias_set="burst") == BIAS_SETS["burst"]
    assert values(bias_set="burst", biases=["v_th=2.55V"]) == {**BIAS_SETS["burst"], "v_th": 2.55}
    # a set is complete: it replaces what a place on the chip gives the neuron
    there = SiliconChoice(at="ranging-chip/neuron[5]")
    assert values(bias_set="robust", silicon=there) == BIAS_SETS["robust"]


def test_bad_sets_of_biases() -> None:
    with pytest.raises(UnknownNameError, match="known are burst, facts, robust, single-spike"):
        choose("rebound-neuron", bias_set="busrt")
    with pytest.raises(ParameterError, match="bias_set: robust, ranging-chip has no named sets"):
        choose("ranging-chip", bias_set="robust")


HUGE = "42949672964294967296"
COUNTS = [
    (name, each.name)
    for name in (*block_names(), *WHOLE_CHIPS)
    for each in parameters(block_of_target(name).params())
    if isinstance(each.value, int)
]


@pytest.mark.parametrize(("block", "count"), COUNTS)
def test_every_count_has_a_limit(block: str, count: str) -> None:
    with pytest.raises(ParameterError, match=rf"{count}: 4.29497e\+19, must be"):
        choose(block, [f"{count}={HUGE}"])


STIMULI = [
    (name, each.name, each.unit)
    for name in (*block_names(), *WHOLE_CHIPS)
    for each in block_of_target(name).stimuli
    if each.unit in {"", "Hz", "s"}
]


@pytest.mark.parametrize(("block", "stimulus", "unit"), STIMULI)
def test_a_huge_stimulus_makes_no_huge_testbench(block: str, stimulus: str, unit: str) -> None:
    try:
        bench = choose(block, stimuli=[f"{stimulus}=1e18{unit}"]).testbench()
        sizes = [polyline(s.name, s.waveform)[0].size for s in bench.sources]
    except ParameterError:
        return
    assert max(sizes) <= PULSES


SLIPS = {
    "params": (["membrane_capacitance=600mF"], r"c_m\.capacitance: 0\.6 F, must be 1aF to 1mF"),
    "biases": (["i_lim=40A"], r"bias i_lim\.value: 40 A, must be 1fA to 1A"),
}


@pytest.mark.parametrize("what", SLIPS)
def test_a_size_that_nobody_means_is_refused_unless_it_is_meant(what: str) -> None:
    texts, says = SLIPS[what]
    with pytest.raises(ParameterError, match=rf"{says}.*`allow_implausible`"):
        choose("rebound-neuron", **{what: texts})  # type: ignore[arg-type]
    meant = choose("rebound-neuron", silicon=SiliconChoice(allow_implausible=True), **{what: texts})  # type: ignore[arg-type]
    assert meant.testbench().circuit == meant.circuit


def test_a_current_of_a_stimulus_is_one_that_is_meant() -> None:
    with pytest.raises(ParameterError, match=r"i_in\.waveform: 3 A, must be 1fA to 1A"):
        choose("nef-neuron", stimuli=["current=3A"]).testbench()
    choose("nef-neuron", stimuli=["current=3A"], silicon=SiliconChoice(allow_implausible=True)).testbench()
    choose("nef-neuron", stimuli=["current=0"]).testbench()
