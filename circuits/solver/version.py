"""The version of the solvers, which every measured record carries.

It rises when a solver gives other answers to the same circuit by more than its tolerance: another step
control, another rule of integration, another convergence test. `tests/circuits/solver/test_version.py` holds
answers of this version, so that a change of them is noticed.
"""

VERSION = 1
