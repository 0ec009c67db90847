"""Runs of a ROLLS chip from rest, with its first neurons alone and events put in order once for all dies."""
