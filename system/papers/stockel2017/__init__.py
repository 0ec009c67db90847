"""Stöckel 2017: Bug robots of spiking neurons."""
