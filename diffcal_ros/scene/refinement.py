# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scene on a mesh of half the size."""

from dataclasses import replace

from diffcal_ros.scene.model import HeldPart, Scene
import numpy as np


def refined_scene(scene: Scene) -> Scene:
    """Return the scene on a mesh of half the size; regions and held parts are the same solids."""
    mesh, parents = scene.mesh.refined()
    edges, _ = scene.mesh.edges
    field = scene.relative_modulus

    def finer(part: HeldPart) -> HeldPart:
        is_held = np.zeros(scene.mesh.vertex_count, dtype=bool)
        is_held[part.vertices] = True
        between = scene.mesh.vertex_count + np.flatnonzero(is_held[edges].all(axis=1))
        vertices = np.concatenate([part.vertices, between]).astype(np.int32)
        return replace(part, vertices=vertices)

    return replace(
        scene,
        mesh=mesh,
        relative_modulus=None if field is None else field[parents],
        regions=tuple(
            replace(region, tets=np.flatnonzero(np.isin(parents, region.tets)).astype(np.int32))
            for region in scene.regions
        ),
        observations=tuple(
            replace(setup, held=tuple(finer(part) for part in setup.held))
            for setup in scene.observations
        ),
    )
