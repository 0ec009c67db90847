"""Circuits of the latency chip."""
