"""Worlds, sensors, robots, the closed loop, studies, experiments and the command line."""
