"""Codes of chips in runs and studies: how each chip is calibrated, where codes are kept, and their files."""
