"""The NEF chip: neurons whose tuning curves are those of its die."""
