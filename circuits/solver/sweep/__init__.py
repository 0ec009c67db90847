"""Direct-current sweeps: operating points over the values of one source, each continued from the last."""

from circuits.solver.sweep.direct_current import Sweep, dc_sweep

__all__ = ["Sweep", "dc_sweep"]
