"""Circuits of the sonar head's comparison of its two ears."""
