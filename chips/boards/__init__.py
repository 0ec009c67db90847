"""Boards beside the ranging chip: centroid, isolation of the first target, and vocalization."""
