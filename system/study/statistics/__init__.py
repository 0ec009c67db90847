"""Statistics of Monte Carlo studies: plain functions of arrays, with randomness as an argument."""
