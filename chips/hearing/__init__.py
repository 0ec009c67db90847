"""The bat's hearing: from the sound at a microphone to spikes of the onset and high-threshold neurons."""
