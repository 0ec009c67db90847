"""Checks of our own: experiments that no paper has."""
