"""Spikes of circuits and chips as files that other programs open."""
