"""Chips that are driven from outside as the real ones are: events in, time on, events out, biases."""
