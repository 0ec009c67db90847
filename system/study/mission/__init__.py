"""Missions: what share of dies does what a robot is for, at which temperature, and why the others fail."""
