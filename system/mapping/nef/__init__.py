"""Networks of values, of the Neural Engineering Framework, put on the NEF chip."""
