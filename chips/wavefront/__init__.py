"""The wavefront chip, on which a path is planned by a wave of spikes over cells that delay them."""
