# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An even, steady stream of air, in which a body swings: it is pushed by the stream past it."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.drag import AIR, Drag, make_drag
from benchmarks.blind.faults import Faults
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import GRAVITY, Observation
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen


def make_breeze(specimen: Specimen, observation: Observation, faults: Faults) -> Drag:
    """Return what a stream does to a body that moves in it; at rest, it pushes it.

    It is level, and as strong as would draw all of the free mass as `gravity_tilt` says; each
    part of the surface has its share of that, by its area.

    Args:
        specimen: the body.
        observation: the pose.
        faults: say how strong the stream is, and how fast.
    """
    x, z = np.deg2rad(faults.gravity_tilt)
    down = np.array([0.0, -GRAVITY, 0.0])
    side = rotation(np.array([x, 0.0, z])) @ down
    side[1] = 0.0
    strength, speed = float(np.linalg.norm(side)), faults.breeze_speed
    push = strength * float(specimen.body.masses[specimen.shares > 0.0].sum())
    still = make_drag(specimen.mesh, push / (0.5 * AIR * speed**2))
    wind = observation.world_from_object[:3, :3].T @ (speed / strength * side)
    return replace(still, wind=wind)


def breeze_push(specimen: Specimen, observation: Observation, faults: Faults) -> FloatArray:
    """Return how a stream pushes a body that does not move [N], object frame, shape (N, 3)."""
    standing = np.zeros(specimen.mesh.nodes.shape)
    if faults.tilt_form != 'breeze':
        return standing
    return -make_breeze(specimen, observation, faults).forces(standing)
