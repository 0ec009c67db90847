"""Compiled waves of the wavefront chip: whole delays on a grid, real ones, and those of single edges."""
