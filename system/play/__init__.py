"""Runs of any system step by step, from Python."""
