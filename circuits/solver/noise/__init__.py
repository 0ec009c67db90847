"""Noise of the devices: about a rest state, in a transient, and at an event."""
