"""The teaching chip and its board: circuits of `circuits.blocks.bench`, their biases, and what reads them."""
