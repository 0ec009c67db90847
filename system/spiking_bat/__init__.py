"""Spiking bat: flights through a forest, steered by spike latencies."""
