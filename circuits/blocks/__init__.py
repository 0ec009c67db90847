"""Circuits with a name, one a file: parameters, biases, testbenches and metrics."""
