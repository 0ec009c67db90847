"""Curved Openspace: arcs of flight, chosen by what narrow pings show."""
