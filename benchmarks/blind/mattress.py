# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a body is bent that lay on a mattress, into which its heavy holder sank.

By the moment of a long beam on an even bed of springs that bears a force at its end (Hetenyi 1946,
Beams on Elastic Foundation): the exponential of the way from there times its sine.
"""

import numpy as np


def bedded_moment(share: float, width: float) -> float:
    """Return the moment at a share of the free length, over force and width.

    Args:
        share: of the free length, from the holder.
        width: share over which it falls to a third, and its sine goes on by 1.
    """
    way = share / width
    return float(np.exp(-way) * np.sin(way))


def bedded_lever(width: float) -> float:
    """Return the mean over the free length of that moment times what is left to the tip.

    Args:
        width: as above.
    """
    rate = 1.0 / width
    fallen, sine, cosine = np.exp(-rate), np.sin(rate), np.cos(rate)
    whole = (1.0 - fallen * (sine + cosine)) / (2.0 * rate)
    first = (1.0 - fallen * cosine) / (2.0 * rate**2) - fallen * (sine + cosine) / (2.0 * rate)
    return float(whole - first)
