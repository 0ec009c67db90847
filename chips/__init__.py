"""Chips: circuits on a die, as behavioural models whose error against the transistors was measured."""
