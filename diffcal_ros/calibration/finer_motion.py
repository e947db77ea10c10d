# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that moves on a mesh of half the size: what the coarse one costs, by trying it.

An error of stiffness alone would be found at rest. A coarse mesh also delays the waves that run
through a body when its support lets go, which looks like late stamps.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from diffcal_ros.calibration.posture import PostureInputs
from diffcal_ros.fem.element import Element
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# Eight times as many tetrahedra are affordable once in a fit up to so many; the usual meshes of
# soft bodies that have more are fine enough.
_MOST_TETS = 600


@dataclass(frozen=True)
class HeldMesh:
    """A mesh with the parts that hold it.

    Attributes:
        mesh: at rest in the world frame.
        staying: vertices that stay held, shape (h,).
        released: vertices of the support that lets go, shape (r,).
        targets: where each vertex is held, if it is [m], shape (V, 3).
    """

    mesh: TetMesh
    staying: IntArray
    released: IntArray
    targets: FloatArray

    def refined(self) -> tuple['HeldMesh', IntArray]:
        """Halve the mesh size; an edge is held where both of its ends are.

        Returns:
            The finer mesh and the parent of each of its tetrahedra.
        """
        finer, parents = self.mesh.refined()
        edges, _ = self.mesh.edges
        staying = self._with_middles(self.staying, edges)
        released = np.setdiff1d(self._with_middles(self.released, edges), staying)
        middles = self.targets[edges].mean(axis=1)
        return HeldMesh(finer, staying, released, np.vstack([self.targets, middles])), parents

    def _with_middles(self, vertices: IntArray, edges: IntArray) -> IntArray:
        held = np.zeros(self.mesh.vertex_count, dtype=bool)
        held[vertices] = True
        middles = self.mesh.vertex_count + np.flatnonzero(held[edges].all(axis=1))
        return np.concatenate([vertices, middles]).astype(np.int32)


def is_affordable(held: HeldMesh, element: Element, inputs: PostureInputs) -> bool:
    """Tell whether a motion can be tried on a finer mesh: small, and nothing goes by node."""
    conditions = inputs.conditions
    return (
        element is Element.QUADRATIC
        and held.mesh.tet_count <= _MOST_TETS
        and conditions.added_masses is None
        and not conditions.cables
    )


def on_finer_mesh(
    held: HeldMesh,
    inputs: PostureInputs,
    simulate: Callable[[HeldMesh, PostureInputs], FloatArray],
) -> FloatArray:
    """Simulate at half the mesh size.

    Args:
        held: the coarse mesh.
        inputs: for it.
        simulate: returns the nodes of quadratic elements in all frames [m], shape (S, N, 3).

    Returns:
        The nodes that quadratic elements have on the coarse mesh [m], shape (S, N, 3).
    """
    finer, parents = held.refined()
    material = replace(
        inputs.material,
        youngs_modulus=inputs.material.youngs_modulus[parents],
        poissons_ratio=inputs.material.poissons_ratio[parents],
        density=inputs.material.density[parents],
    )
    positions = simulate(
        finer, replace(inputs, material=material, damping=inputs.damping[parents])
    )
    # Vertices and middles of edges, in the order of the coarse nodes, come first.
    return positions[:, : finer.mesh.vertex_count]
