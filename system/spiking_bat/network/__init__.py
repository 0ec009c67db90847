"""A spiking network of Hodgkin-Huxley and integrate-and-fire neurons, compiled."""
