# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a body is bent that was hung up by both ends, loosely: as a catenary.

By the length s along it from its lowest place, where its radius is a, its slope is s / a, so that
its curvature is a / (a^2 + s^2).
"""

import numpy as np


def catenary_rate(share: float, at: float, sag: float) -> float:
    """Return the curvature at a share of the free length, 1 at the lowest place.

    Args:
        share: of the free length.
        at: that of the lowest place.
        sag: radius there, as a share of the free length.
    """
    return sag**2 / (sag**2 + (share - at) ** 2)


def catenary_lever(at: float, sag: float) -> float:
    """Return the mean over the free length of that curvature times what is left to the tip.

    Args:
        at: share of the free length of the lowest place.
        sag: radius there, as a share of that.
    """
    inner, outer = at / sag, (1.0 - at) / sag
    turned = sag * (np.arctan(inner) + np.arctan(outer))
    return float((1.0 - at) * turned - 0.5 * sag**2 * np.log((1.0 + outer**2) / (1.0 + inner**2)))
