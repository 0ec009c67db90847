"""Circuits of two ears that tell a direction."""
