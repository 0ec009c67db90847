"""Solvers of a circuit: operating point, transient, small signals, noise, and batches over dies."""
