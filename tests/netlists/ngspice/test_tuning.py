"""Trials of a rebound neuron by ngspice: the answers that the solver gives on the nominal neuron."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.blocks.sonar.tuning import tune, tuning_machine
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result
from netlists.ngspice import tuning
from netlists.ngspice.tuning import NgspiceTrials

pytestmark = pytest.mark.usefixtures("kept_ngspice")


def test_the_nominal_neuron_is_silent_but_after_both() -> None:
    neuron, silicon = rebound_neuron.build(), Silicon(AMI_1500_IDEAL)
    ours = tune(tuning_machine(neuron, silicon))
    trials = NgspiceTrials(neuron, silicon)
    assert not trials.fires_at_rest(1e-3)
    call = trials.after_call()
    assert call is not None
    assert not call.fires
    assert call.t_inh == pytest.approx(ours.t_inh, abs=1e-6)
    # the top of the rebound is flat: its time is the coarsest of all
    assert call.t_reb == pytest.approx(ours.t_reb, abs=50e-6)
    assert call.latest == pytest.approx(call.t_inh + trials.span)
    assert not trials.fires_after_echo(1e-3)
    assert trials.fires_after_both(ours.best_delay, ours.t_inh + trials.span)
    assert trials.runs <= 5


def test_a_spike_before_the_echo_is_not_the_echo_s() -> None:
    result = cast("Result", SimpleNamespace(spikes={"spike": np.array([4e-3, 6e-3])}))
    assert tuning._fires(result, 6e-3)
    assert not tuning._fires(result, 6.1e-3)
