"""Circuits of the latency chip, which computes with the times of spikes."""
