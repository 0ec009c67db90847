"""Hwu et al. 2018: path planning by waves of spikes."""
