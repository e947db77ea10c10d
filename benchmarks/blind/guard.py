# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sheet of acrylic that was bent before a sensor, to guard that from splashes."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.peeling import ways_aslant
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def guard_share(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how much of a bent sheet's error there is, shape (h, w, 1).

    A ray that meets a sheet at an angle has a longer way in it, by the square of that as long as
    it is small; along the line about which the sheet was bent it is alike.

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say where the sheet is met squarely, across which way it is bent, and how far off
            there is all of the error.
    """
    return np.asarray((ways_aslant(rendering, setup, faults) / faults.depth_width) ** 2)[..., None]


def farthest_way(setup: Setup, spot: tuple[float, float], slant: float) -> float:
    """Return how far an end of a straight body is at most from a line across the image [px].

    Args:
        setup: with its poses.
        spot: a place of the line, to the right of the principal point and down [px].
        slant: of the way across the line, from the image's right towards down [deg].
    """
    shape, camera = setup.shape, setup.camera
    ends = shape.place(np.array([[shape.clamp, 0.0, 0.0], [shape.length, 0.0, 0.0]]))
    angle, place = np.deg2rad(slant), np.array([camera.cx, camera.cy]) + spot
    ways = [
        (camera.project(applied(setup.depth_from_world @ pose.world_from_object, ends)) - place)
        @ [np.cos(angle), np.sin(angle)]
        for pose in setup.observations
    ]
    return float(np.abs(ways).max())
