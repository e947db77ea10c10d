# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How stresses relax, as Prony pairs: a share, for all or at each Gauss point, and a time [s].

A power law is the mean of exponentials over rates that are spread as a gamma distribution,

    (1 + t / tau)^-n = 1 / Gamma(n) int s^(n-1) exp(-s) exp(-s t / tau) ds,

which the trapezoidal rule over log s turns into pairs.
"""

import numpy as np
from scipy.special import gamma

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray

Pair = tuple[FloatArray | float, float]

# Of log s: what is faster than the first has relaxed at once, what is slower never does.
_FASTEST, _SLOWEST, _SPACING = 2.0, -8.5, 0.75


def prony_pairs(faults: Faults, share: FloatArray) -> list[Pair]:
    """Return the pairs of a body that creeps.

    Args:
        faults: say how.
        share: of the free length at which Gauss points lie, shape (C, 8).
    """
    part, time = faults.creep_share, faults.creep_time
    if faults.creep_form == 'two':
        return [(0.5 * part, time), (0.5 * part, 5.0 * time)]
    if faults.creep_form == 'power':
        return power_pairs(part, time, faults.creep_power)
    if faults.creep_form == 'pour':
        inner = (share < faults.creep_until)[..., None, None]
        return [(part * inner.astype(float), time)]
    return [(part, time)]


def power_pairs(share: float, time: float, power: float) -> list[Pair]:
    """Return the pairs of stresses that fall to 1 - share + share (1 + t / time)^-power."""
    logs = np.arange(_FASTEST, _SLOWEST, -_SPACING)
    weights = _SPACING * np.exp(power * logs - np.exp(logs)) / gamma(power)
    return [
        (share * float(w), time * float(np.exp(-u))) for w, u in zip(weights, logs, strict=True)
    ]
