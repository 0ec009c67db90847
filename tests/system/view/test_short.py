"""Films at the edge: a run in which nothing was heard, and a process whose devices do not deviate."""

from dataclasses import replace

from circuits.blocks.sonar import rebound_neuron
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.registry import load_system
from system.view.devices import devices_of
from system.view.page import page


def test_a_run_without_a_call_has_a_film() -> None:
    system = load_system("approach")
    trace = system.run(system.on_silicon(level="behavioural", duration=0.05))
    assert not trace.pulses.size
    film = system.filmed(trace, ["neuron[0]"])
    assert film.neurons[0].waveform is not None
    assert page([film])


def test_devices_of_a_process_without_mismatch_are_at_no_sigma() -> None:
    still = replace(AMI_1500, pair_a_vt=0.0, pair_a_beta=0.0)
    found = devices_of(rebound_neuron.build(), Silicon(still, die=Die(number=3)))
    assert {device.sigma for device in found} == {0.0}
