"""Measures by their names, and gradients as a dataset."""

import numpy as np
import pytest

from circuits.errors import ParameterError, UnknownNameError
from circuits.gradient.gradient import gradients_of
from circuits.gradient.measure import Crossing, Current, Energy, Extreme, Integral, SpikeTime, Voltage
from circuits.gradient.small_signal.transfer import Corner, Transfer
from circuits.lowering.kernel import to_kernel
from system.options.block import choose
from system.study.metrics.gradient import gradients, measure_of, measures_of, shares


@pytest.mark.parametrize(
    ("text", "measure"),
    [
        ("spike_time(spike)", SpikeTime("spike")),
        ("spike_time(line[4,1],2)", SpikeTime("line[4,1]", 2)),
        ("voltage(v_mem)", Voltage("v_mem")),
        ("voltage(v_mem, 5ms)", Voltage("v_mem", 5e-3)),
        ("fall(a.b,1.5V,1)", Crossing("a.b", 1.5, rising=False, number=1)),
        ("maximum(v)", Extreme("v")),
        ("minimum(v,1ms,2ms)", Extreme("v", highest=False, begin=1e-3, end=2e-3)),
        ("integral(v)", Integral("v")),
        ("current(a.m1)", Current("a.m1")),
        ("current(vdd,5ms)", Current("vdd", 5e-3)),
        ("rise(i(a.m1),2nA,1)", Crossing("i(a.m1)", 2e-9, number=1)),
        ("integral(i(vdd),1ms,2ms)", Integral("i(vdd)", 1e-3, 2e-3)),
        ("energy(vdd)", Energy("vdd")),
        ("mag(v[1,2],s,1kHz)", Transfer("mag", "v[1,2]", "s", 1e3)),
        ("db(v, s, 10Hz)", Transfer("db", "v", "s", 10.0)),
        ("phase(v,s,2MHz)", Transfer("phase", "v", "s", 2e6)),
        ("bandwidth(v,s)", Corner("v", "s")),
        ("unity_gain(v,s,1kHz,1MHz)", Corner("v", "s", 1.0, 1e3, 1e6)),
    ],
)
def test_measure_of_its_name(text, measure):
    assert measure_of(text) == measure


NONE = (
    "v(v)", "fall(v)", "spike_time(spike,-1)", "fall(v,1)", "maximum(v,1ms)", "voltage(v,1ms,2)",
    "voltage(v,-1ms)", "spike_time()", "voltage(,1ms)", "maximum(v,2ms,1ms)", "integral(v,1ms,1ms)",
    "rise(i(m1),1V)", "energy()", "current(m1,1ms,2ms)",
    "mag(v,s)", "db(v,s,0Hz)", "phase(v,s,1)", "bandwidth(v)", "bandwidth(v,s,1Hz)",
    "unity_gain(v,s,2Hz,1Hz)",
    "mag(v,s,1Hz,2Hz)",
)  # fmt: skip


@pytest.mark.parametrize("text", NONE)
def test_names_that_are_none(text):
    with pytest.raises(ParameterError, match="metric"):
        measure_of(text)


def test_names_of_measures_tell_between_which_times():
    assert measure_of("maximum(v,1ms,2ms)").name == "maximum(v,0.001s,0.002s)"
    assert measure_of("integral(v)").name == "integral(v)"
    for name in (
        "db(v,s,10Hz)",
        "mag(i(a.m[1]),s,10Hz)",
        "bandwidth(v,s)",
        "bandwidth(i(vdd),s)",
        "unity_gain(v,s,1000Hz,1e+06Hz)",
    ):
        assert measure_of(name).name == name


def test_what_is_no_measure_is_refused():
    with pytest.raises(ParameterError, match="metrics: 3, must be a measure, a metric or a name"):
        gradients(choose("rebound-neuron").testbench(), ["spike_time(spike,0)", 3])


def test_one_text_is_no_list_of_names():
    choice = choose("rebound-neuron")
    with pytest.raises(
        ParameterError, match=r'metrics: "voltage\(v_mem\)", must be a list of measures; write \["'
    ):
        gradients(choice.testbench(), "voltage(v_mem)", choice.silicon)


def test_metrics_of_a_block():
    choice = choose("rebound-neuron")
    assert [m.name for m in measures_of(choice, ("t_inh_s", "spike_time(spike)"))] == [
        "t_inh_s",
        "spike_time(spike,0)",
    ]
    (search,) = measures_of(choice, ("best_delay",))
    assert (search.metric.name, search.machine.testbench.title) == ("best_delay", "rebound neuron")
    with pytest.raises(ParameterError, match="class, is no number of one run"):
        measures_of(choice, ("class",))
    with pytest.raises(UnknownNameError, match="t_in"):
        measures_of(choice, ("t_in",))


def test_dataset_has_what_a_run_backwards_found():
    choice = choose("rebound-neuron")
    data = gradients(choice.testbench(), ["voltage(v_mem)"], choice.silicon)
    found = gradients_of(to_kernel(choice.testbench(), choice.silicon), (Voltage("v_mem"),))
    np.testing.assert_array_equal(data.gradient[0, : found.by.shape[1]], found.by[0])
    assert data.gradient.sel(parameter="source.vdd.value")[0] > 0.0
    assert float(data.spread[0]) == pytest.approx(float(found.spread[0]))
    assert sum(shares(found).values()) == pytest.approx(1.0)
    assert data.parameter_unit.sel(parameter="temperature").item() == "degC"


def test_dataset_has_small_signals_beside_a_run():
    choice = choose("photoreceptor")
    names = ["voltage(v_sf)", "bandwidth(v_sf,v_pd)", "mag(i(vdd),v_prb,1000Hz)"]
    data = gradients(choice.testbench(), names, choice.silicon)
    assert data.unit.values.tolist() == ["V", "Hz", "S"]
    assert data.metric.values.tolist() == names
    assert (data.spread[1:] > 0.01 * data.value[1:]).all()


def test_small_signal_of_a_current_that_is_none_is_told():
    choice = choose("photoreceptor")
    with pytest.raises(UnknownNameError, match="photoreceptor current vd: unknown; did you mean vdd"):
        gradients(choice.testbench(), ["mag(i(vd),v_pd,1kHz)"], choice.silicon)
