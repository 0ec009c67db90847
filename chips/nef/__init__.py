"""The NEF chip: networks of the Neural Engineering Framework on neurons whose tuning curves a die sets."""
