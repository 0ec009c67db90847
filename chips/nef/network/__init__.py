"""Networks of the Neural Engineering Framework: description, decoders, and a run on ideal neurons."""
