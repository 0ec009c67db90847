"""Where a calibration of the ranging chip begins, and what it aims at; all numbers are ours.

The paper's biases make windows of 1.8 ms, 2.2 ms apart: where an echo falls between two of them the next
reflector is answered instead. Here the membrane is slower (I_rslope, I_rtau), so that windows of 3.5 ms
overlap and one or two neurons answer every echo; V_rest is lower, which leaves 0.1 V and more of V_ex,max
between an echo that no neuron answers and one that is answered without a call; and I_ex_tau is the same for
all neurons, so that an echo makes one to three spikes and no longer bursts. By the circuit of the paper, its
sizes included.
"""

from __future__ import annotations

from collections.abc import Mapping

BEGIN: Mapping[str, float] = {
    "i_ex_tau": 100e-12,
    "i_rslope": 170e-12,
    "i_rtau": 150e-12,
    "v_rest": 1.5,
    "v_th": 2.602,
    "v_ex_max": 4.3,
}

# I_rslope over the one at which the median neuron, and the first one, spikes after a call alone.
MEDIAN_SHARE, FIRST_SHARE = 1.0 / 1.8, 1.0 / 1.2
BELOW = 35e-3  # V, of v_ex_max under the highest at which all neurons but one answer
WIDTH = 3.5e-3  # s, of the median window
WIDTH_WITHIN = 0.1  # share
CENTRE_WITHIN = 0.15e-3  # s, of a window's middle
FAR = 0.5e-3  # s, of a middle from its best delay, from where its neighbours are moved towards it
NARROWEST, WIDEST = 1.0e-3, 6.0e-3  # s, of a window that is of use
LEAST = 10  # neurons without which a chip is of no use
