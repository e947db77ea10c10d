# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A lead wire that winds around a body like a vine, at an even pitch."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray


def vine_weight(share: FloatArray, across: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of a wire places bear over an even one, whose sections hang on that.

    Parts on the other side are lifted, so that a section's load is where the wire touches it:
    the middle of 1 + 3 w . p over a square is w, where p goes from -1 to 1 along both sides.

    Args:
        share: of the free length, shape (C, 8).
        across: of the places, over half the width and the height, shape (C, 2, 8).
        faults: say where the wire begins, on which side, and how long a turn of it is.
    """
    wound = 2.0 * np.pi * (share - faults.added_mass_at) / faults.mass_wind
    angle = np.deg2rad(faults.mass_side) + wound
    y, z = np.clip(across, -1.0, 1.0).swapaxes(0, 1)
    leans = 1.0 + 3.0 * (np.cos(angle) * y + np.sin(angle) * z)
    return np.asarray(leans * (share > faults.added_mass_at))
