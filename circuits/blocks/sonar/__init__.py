"""Circuits of the sonar: hearing, ranging, and the next call."""
