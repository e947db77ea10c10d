# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body whose upper side tears near the clamp while it swings."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.body import Body
from benchmarks.blind.faults import Faults
from benchmarks.blind.material import softened
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen

WIDE = 0.08  # Share of the free length over which small tears fall to a third on either side.


def torn_share(share: FloatArray, height: FloatArray, at: float) -> FloatArray:
    """Return how much of all tears is at places, 1 on the upper face amid them.

    Args:
        share: of the free length, any shape.
        height: -1 at the lower face and 1 at the upper one, that shape; there is none below 0.
        at: share amid them.
    """
    along = np.exp(-(((share - at) / WIDE) ** 2))
    return np.asarray(along * np.maximum(height, 0.0))


def torn(specimen: Specimen, faults: Faults) -> Body:
    """Return what a body is once it is torn: as heavy, and softer there, pressed or drawn."""
    body = specimen.body
    share = specimen.shares[body.cells] @ body.quadrature.values.T
    factor = np.exp(-faults.tearing * torn_share(share, specimen.heights, faults.tearing_at))
    return replace(body, numbers=softened(body.numbers, factor))
