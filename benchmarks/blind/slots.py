# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that was stored with both ends in slots, one of which lies beside the other."""


def slotted(share: float) -> float:
    """Return the curvature at a place between the slots, whose tip moves as far as that of an arc.

    Neither end turns, so that the moment goes evenly from one way to the other.

    Args:
        share: of the free length.
    """
    return 3.0 - 6.0 * share
