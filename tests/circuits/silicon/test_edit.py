"""Edits of a die: which devices a path means, and what becomes of their deviations in every lowering."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.errors import ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.lowering.on_die import on_die
from circuits.silicon.die import Die, drawn_for, noted
from circuits.silicon.edit import Edit, matched, unmatched
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

PLACE = (("ranging_chip", ()),)
PATH = (("neuron", (13,)), ("membrane", ()), ("mr1", ()))
AREA = 36e-12
DIE = Die(number=1003)


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("ranging-chip/neuron[2]", [2]),
        ("ranging_chip.neuron[2].membrane.mr1", [2]),
        ("ranging_chip/neuron", range(13)),
        ("ranging_chip/neuron[*].membrane.mr?", range(13)),
        ("ranging_chip/neuron[1*]", [1, 10, 11, 12]),
        ("*.mr1", range(13)),
        ("*[2]*", [2]),
        ("ranging_chip/neuron[2].membrane.mr1.v_t0", [2]),
        ("ranging_chip/neuron[2].membrane.mr1.beta", []),
        ("ranging_chip/neuron[2].membrane.mr", []),
        ("ranging_chip/neuron[2", []),
        ("ranging*2*mr1", []),  # a star takes whole indices
        ("process", []),
    ],
)
def test_path_means_what_is_at_it_and_below(text, meant):
    assert np.flatnonzero(matched([text], PLACE, [PATH], "v_t0")).tolist() == list(meant)


def test_healed_devices_alone_do_not_deviate():
    before, after = (
        Silicon(die=die).deviations("ranging_chip", [PATH], AREA)
        for die in (DIE, DIE.healed("ranging_chip/neuron[2]", "*[3]*.v_t0"))
    )
    others = [k for k in range(13) if k not in {2, 3}]
    assert after.v_t0[[2, 3]].tolist() == [0.0, 0.0]
    assert after.beta[2] == 0.0
    assert after.beta[3] == before.beta[3] != 0.0
    np.testing.assert_array_equal(after.v_t0[others], before.v_t0[others])


def test_only_leaves_no_other_deviation_and_no_process():
    silicon = Silicon(die=DIE.only("ranging_chip/neuron[2]"))
    own = silicon.deviations("ranging_chip", [PATH], AREA).v_t0
    assert np.flatnonzero(own).tolist() == [2]
    assert silicon.law("n") == Silicon().law("n")
    assert Silicon(die=DIE.only("process.n")).law("n") == Silicon(die=DIE).law("n")
    assert Silicon(die=DIE.only("process.n")).law("p") == Silicon().law("p")


def test_set_deviation_goes_over_draw_heal_and_only():
    for die in (Die(), DIE, DIE.healed("*"), DIE.only("nothing"), replace(DIE, mismatch=False)):
        own = Silicon(die=die.with_("ranging_chip/neuron[4]", "v_t0", 0.01)).deviations(
            "ranging_chip", [PATH], AREA
        )
        assert own.v_t0[4] == 0.01
    assert Silicon(die=DIE.with_("process.n", "v_t0", 0.05)).law("n").v_t0 == Silicon().law("n").v_t0 + 0.05


@pytest.mark.parametrize("variation", ["plain", "full"])
def test_die_healed_of_all_is_the_nominal_die(variation):
    neuron = rebound_neuron.build()
    bench = rebound_neuron.BLOCK.testbench(
        neuron, {s.name: s.default for s in rebound_neuron.BLOCK.stimuli}, 5.0
    )
    healed = replace(DIE, variation=variation).healed("*")
    own, nominal = (to_kernel(bench, Silicon(die=die)).kernel for die in (healed, Die()))
    for mine, other in ((own.transistors, nominal.transistors), (own.charge, nominal.charge)):
        for a, b in zip(mine, other, strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-14)


def test_behavioural_models_and_solver_see_the_same_edited_device():
    neuron = rebound_neuron.build()
    silicon = Silicon(die=DIE.with_("rebound_neuron.membrane.mr1", "v_t0", 0.02))
    fet = on_die(neuron, silicon, ("membrane.mr1", "membrane.mr2")).fet
    plain = on_die(neuron, replace(silicon, die=DIE), ("membrane.mr1", "membrane.mr2")).fet
    assert float(fet["membrane.mr1"].v_t0) == 0.02
    assert fet["membrane.mr2"].v_t0 == plain["membrane.mr2"].v_t0


def test_gradient_across_a_die_is_healed_with_its_devices():
    die = replace(DIE, variation="transistors")
    own = Silicon(AMI_1500, die=die.healed("ranging_chip/neuron[0]")).deviation(
        "ranging_chip", PATH, AREA, "p"
    )
    assert own.v_t0[0] == 0.0 != own.v_t0[1]


def test_capacitor_is_set_on_a_die_whose_capacitors_do_not_vary():
    path, value = ((("neuron", (2,)), ("cm", ())),), np.full(2, 1e-12)
    changed = Silicon(die=Die().with_("chip.neuron[1].cm", "capacitance", 0.1)).change(
        "chip", path, "capacitor", value
    )
    np.testing.assert_allclose(changed.value, [0.0, 0.1], atol=1e-15)


def test_edited_die_has_a_name_of_its_own():
    assert str(DIE.healed("a/b")) == "die A/1003, healed a.b"
    assert (
        repr(DIE) == "Die(lot='A', number=1003, corner='random', mismatch=True, process=True, sampling=None)"
    )
    assert DIE.healed("a") != DIE


def test_edits_hold_in_an_order_of_their_own():
    assert DIE.healed("a").only("b") == DIE.only("b").healed("a")
    with pytest.raises(ParameterError, match=r"only: b beside a, must be one list"):
        DIE.only("a").only("b")


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (DIE.healed, "no path"),
        (lambda: DIE.with_("a", "kappa", 0.1), "a.parameter: 'kappa', must be v_t0"),
        (lambda: DIE.with_("a", "v_t0", float("nan")), "must be finite"),
        (lambda: DIE.with_("a", "beta", -2.0), "a.beta: changes by -200 %, must be above -100 %"),
    ],
)
def test_refusals(make, text):
    with pytest.raises(ParameterError, match=text):
        make()


def test_paths_that_mean_nothing_are_told():
    edits = (Edit("heal", ("ranging_chip.neuron[2]", "ranging_chip.neuron[13]", "ranging_chip.nueron")),)
    families = [(PLACE, [PATH], "v_t0")]
    assert unmatched(edits, families) == ["ranging_chip.neuron[13]", "ranging_chip.nueron"]
    on_it, on_none = (Edit("set", ("ranging_chip.neuron[2]",), name, 0.1) for name in ("v_t0", "capacitance"))
    assert unmatched((on_it, on_none), families) == ["ranging_chip.neuron[2]"]


def test_shared_edits_touch_no_single_device():
    shared = replace(DIE, edits=DIE.healed("process.n", "a.b").with_("a.b", "beta", 0.1).shared_edits)
    assert Silicon(die=shared).law("n") == Silicon().law("n")
    assert not any("a.b" in path for edit in shared.edits for path in edit.paths)


def test_circuit_sees_its_own_edits_and_those_of_what_is_shared():
    die = DIE.healed("board.m1", "chip[2].m1", "*.m3", "process.n").with_("board.m1", "beta", 0.1)
    assert [path for edit in die.seen_by("chip").edits for path in edit.paths] == [
        "chip[2].m1",
        "*.m3",
        "process.n",
    ]
    assert DIE.only("board.m1").seen_by("chip").edits == DIE.only("board.m1").edits
    assert Silicon(die=die).seen_by("chip").die == die.seen_by("chip")


@pytest.mark.parametrize(
    "text", ["chip.cell[3]", "chip.cell[3].x[1,2]", "chip.cell[*].x[1,2]", "chip.cell[9]"]
)
def test_indices_are_found_as_letters_are(text):
    place, path = (("chip", ()),), (("cell", (5,)), ("x", (3, 4)), ("m", ()))
    own = matched([text], place, [path], "v_t0")
    spelt = matched([text.replace("cell", "ce?l")], place, [path], "v_t0")  # a wildcard, by its letters
    np.testing.assert_array_equal(own, spelt)


def test_draws_of_a_die_are_noted_as_they_are_without_edits():
    probe = noted(DIE.with_("ranging_chip.neuron[3]", "v_t0", 0.01), "a test")
    Silicon(die=probe).deviations("ranging_chip", [PATH], AREA)
    Silicon(die=probe).law("n")
    plain = Silicon(die=DIE).deviations("ranging_chip", [PATH], AREA)
    found = {(place[0][0], parameter): drawn for (place, _, parameter), drawn in drawn_for(probe).items()}
    np.testing.assert_array_equal(found["ranging_chip", "v_t0"].value, plain.v_t0)
    shift = Silicon(die=DIE).law("n").v_t0 - Silicon().law("n").v_t0
    assert found["process", "shared.v_t0"].value == pytest.approx([shift], rel=1e-9)
    assert found["process", "shared.v_t0"].process is AMI_1500
