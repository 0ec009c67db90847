"""Calibration of the ranging chip: its bench, where it begins and aims, what it does, what codes say."""
