"""Extraction: the transistor law's numbers from curves, whoever made them."""
