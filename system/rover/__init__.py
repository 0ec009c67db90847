"""Rover: a robot that plans its way by a wave of spikes and drives it."""
