# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Device arrays of a walk along the outline."""

from diffcal_ros.device_array import zero_floats, zero_ints, zero_points
import warp as wp


class SilhouetteSegments:
    """Device arrays of a walk along the outline."""

    def __init__(self, count: int, device: str) -> None:
        self.count = count
        self.edges = zero_ints(count, device)
        self.fractions = zero_floats(count, device)
        self.points = zero_points(count, device)
        self.normals = wp.zeros(count, dtype=wp.vec2d, device=device)
        self.lengths = zero_floats(count, device)
        self.open = zero_floats(count, device)
        self.behind = zero_floats(count, device)
        self.faces = zero_ints((count, 2), device)
