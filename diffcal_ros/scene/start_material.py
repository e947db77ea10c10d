# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The material that a scene's start values describe."""

from diffcal_ros.fem.laws import find_law
from diffcal_ros.material import Material
from diffcal_ros.scene.model import Scene
import numpy as np

_CONSTANTS = ('youngs_modulus', 'poissons_ratio', 'density')


def start_material(scene: Scene) -> Material:
    """Return the material that the scene's start values describe."""
    columns = {name: np.empty(scene.mesh.tet_count) for name in _CONSTANTS}
    for region in scene.regions:
        for name, column in columns.items():
            column[region.tets] = getattr(region, name).start
    if scene.relative_modulus is not None:
        columns['youngs_modulus'] *= scene.relative_modulus
    return Material(
        **columns, convention=scene.convention, conversion=find_law(scene.law).CONVERSION
    )
