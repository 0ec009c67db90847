"""Wen & Horiuchi 2022: Curved Openspace and its spiking network."""
