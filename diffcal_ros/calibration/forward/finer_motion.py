# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that moves on a mesh of half the size: what the coarse one costs, by trying it.

An error of stiffness alone would be found at rest. A coarse mesh also delays the waves that run
through a body when its support lets go, which looks like late stamps.
"""

from dataclasses import replace

from diffcal_ros.calibration.forward.posture import PostureInputs
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.scene.model import Scene
from diffcal_ros.tet_mesh import TetMesh

# Eight times as many tetrahedra are affordable once in a fit up to so many; the usual meshes of
# soft bodies that have more are fine enough.
_MOST_TETS = 600


def is_affordable(scene: Scene, inputs: PostureInputs) -> bool:
    """Tell whether a motion can be tried on a finer mesh: small, and nothing goes by node."""
    conditions = inputs.conditions
    return (
        scene.element is Element.QUADRATIC
        and scene.mesh.tet_count <= _MOST_TETS
        and conditions.added_masses is None
        and conditions.forces is None
        and not conditions.cables
    )


def refined_inputs(inputs: PostureInputs, mesh: TetMesh) -> PostureInputs:
    """Return the inputs of a body for its mesh at half the size, see `TetMesh.refined`."""
    _, parents = mesh.refined()
    material = replace(
        inputs.material,
        youngs_modulus=inputs.material.youngs_modulus[parents],
        poissons_ratio=inputs.material.poissons_ratio[parents],
        density=inputs.material.density[parents],
    )
    return replace(inputs, material=material, damping=inputs.damping[parents])
