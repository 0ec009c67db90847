"""Blame: the fewest devices of a die whose healing mends a robot that fails on it."""
