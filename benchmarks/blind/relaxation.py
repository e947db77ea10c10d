# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How stresses relax, as Prony pairs: a share, for all or at each Gauss point, and a time [s].

A power law is the mean of exponentials over rates that are spread as a gamma distribution,

    (1 + t / tau)^-n = 1 / Gamma(n) int s^(n-1) exp(-s) exp(-s t / tau) ds,

which the trapezoidal rule over log s turns into pairs. So is an exponential of the root of the
time, over rates that are spread as a Levy distribution,

    exp(-(t / tau)^0.5) = 1 / (2 pi^0.5) int s^-1.5 exp(-1 / (4 s)) exp(-s t / tau) ds.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import gamma

from benchmarks.blind.faults import Faults
from benchmarks.blind.oiling import oil_share
from benchmarks.blind.shapes import FloatArray

Pair = tuple[FloatArray | float, float]

# Of log s: what is faster than the first has relaxed at once, what is slower never does.
_FASTEST, _SLOWEST, _SPACING = 2.0, -8.5, 0.75
# The same of an exponential of the root, whose slow rates have an end of their own.
_ROOT_FASTEST, _ROOT_SLOWEST = 4.0, -4.0
# Forms whose pairs are of all rates: a step can be as long as what is still on its way.
GRADED = ('power', 'root')


def material_times(faults: Faults, times: Sequence[float]) -> list[float]:
    """Return how long it would have taken to relax as far, had a body stayed as it was [s].

    One that a lamp warms relaxes faster and faster (Schwarzl & Staverman 1952, J. Appl. Phys.
    23): its rate comes up to `creep_haste` of what it was by the exponential of the time. One
    that is still setting relaxes slower and slower: its rate falls by the exponential of the time.

    Args:
        faults: say how.
        times: since the load [s].
    """
    if faults.creep_form == 'setting':
        # In the end it has gone on for so long, and no longer.
        return [-faults.creep_set * float(np.expm1(-t / faults.creep_set)) for t in times]
    if faults.creep_form != 'warmed':
        return list(times)
    haste, slow = faults.creep_haste, faults.creep_warmth
    return [haste * t + (haste - 1.0) * slow * float(np.expm1(-t / slow)) for t in times]


def prony_pairs(faults: Faults, share: FloatArray, below: FloatArray | None = None) -> list[Pair]:
    """Return the pairs of a body that creeps.

    Args:
        faults: say how.
        share: of the free length at which Gauss points lie, shape (C, 8).
        below: how far these lie below the nearest side [mm], that shape; None: it tells nothing.
    """
    part, time = faults.creep_share, faults.creep_time
    if faults.creep_form == 'two':
        return [(0.5 * part, time), (0.5 * part, 5.0 * time)]
    if faults.creep_form == 'power':
        return power_pairs(part, time, faults.creep_power)
    if faults.creep_form == 'root':
        return root_pairs(part, time)
    if faults.creep_form == 'pour':
        inner = (share < faults.creep_until)[..., None, None]
        return [(part * inner.astype(float), time)]
    if faults.creep_form == 'oiled':
        assert below is not None
        return [(part * oil_share(below, faults.creep_depth)[..., None, None], time)]
    return [(part, time)]


def power_pairs(share: float, time: float, power: float) -> list[Pair]:
    """Return the pairs of stresses that fall to 1 - share + share (1 + t / time)^-power."""
    logs = np.arange(_FASTEST, _SLOWEST, -_SPACING)
    return _mixed(share, time, logs, np.exp(power * logs - np.exp(logs)), gamma(power))


def root_pairs(share: float, time: float) -> list[Pair]:
    """Return the pairs of stresses that fall to 1 - share + share exp(-(t / time)^0.5)."""
    logs = np.arange(_ROOT_FASTEST, _ROOT_SLOWEST, -_SPACING)
    density = np.exp(-0.5 * logs - 0.25 * np.exp(-logs))
    return _mixed(share, time, logs, density, 2.0 * float(np.sqrt(np.pi)))


def _mixed(
    share: float, time: float, logs: FloatArray, density: FloatArray, whole: float
) -> list[Pair]:
    """Return the pairs of a law that is a mean over rates.

    Args:
        share: of the stresses that relax.
        time: by which rates are stated [s].
        logs: of the rates.
        density: of the mean over these, at each of them.
        whole: integral of that over all logarithms.
    """
    weights = _SPACING * density / whole
    return [
        (share * float(w), time * float(np.exp(-u))) for w, u in zip(weights, logs, strict=True)
    ]
