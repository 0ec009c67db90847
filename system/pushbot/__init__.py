"""Pushbot: a robot with a dynamic vision sensor, steered by a network on ROLLS."""
