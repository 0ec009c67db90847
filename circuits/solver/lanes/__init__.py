"""Runs of one circuit side by side, in the lanes of the processor's vectors."""
