# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The material that a scene's start values describe."""

from diffcal_ros.fem.laws import find_law
from diffcal_ros.material import Material
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def start_constant(scene: Scene, name: str) -> FloatArray:
    """Return a constant of every tetrahedron, shape (T,); zero where a region has none.

    Args:
        scene: its start values.
        name: an attribute of its regions, such as `density`.
    """
    column = np.zeros(scene.mesh.tet_count)
    for region in scene.regions:
        quantity = getattr(region, name)
        if quantity is not None:
            column[region.tets] = quantity.start
    return column


def start_material(scene: Scene) -> Material:
    """Return the material that the scene's start values describe."""
    modulus = start_constant(scene, 'youngs_modulus')
    if scene.relative_modulus is not None:
        modulus *= scene.relative_modulus
    return Material(
        youngs_modulus=modulus,
        poissons_ratio=start_constant(scene, 'poissons_ratio'),
        density=start_constant(scene, 'density'),
        convention=scene.convention,
        conversion=find_law(scene.law).CONVERSION,
    )
