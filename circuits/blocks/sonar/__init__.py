"""Circuits of the sonar: they hear echoes, measure range, and control the next call."""
