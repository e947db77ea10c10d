# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How heavy and how long the body of a scene is."""

from diffcal_ros.effects.body_size import BodySize
from diffcal_ros.scene.model import Scene
import numpy as np


def size_of_body(scene: Scene) -> BodySize:
    """Return a body's size by its mesh and the densities where a fit starts.

    Its length is the extent along its main axis, whichever way it lies in its frame.
    """
    volumes, points = scene.mesh.volumes, scene.mesh.rest_positions
    mass = sum(
        float(volumes[region.tets].sum()) * region.density.start for region in scene.regions
    )
    main_axis = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    return BodySize(mass=mass, length=float(np.ptp(points @ main_axis)))
