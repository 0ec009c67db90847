"""Circuits that make biases."""
