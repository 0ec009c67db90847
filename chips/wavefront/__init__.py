"""The wavefront chip: cells whose axons delay a spike by a programmed cost."""
