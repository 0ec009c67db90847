"""Figures and tables of papers made again, one experiment a file; `system.registry` lists them."""
