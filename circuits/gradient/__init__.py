"""Gradients of what a testbench measures, from one transient and one run backwards."""
