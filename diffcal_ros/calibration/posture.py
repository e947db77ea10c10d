# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body and the way its clamp goes, in one observation of a scene."""

from diffcal_ros.fem.conditions import Conditions
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.mesh_error import MeshError
from diffcal_ros.fem.static_body import HeldPath, StaticBody
from diffcal_ros.material import Material
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.posing import held_targets, world_positions
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Posture:
    """A body and the way its clamp goes.

    Attributes:
        setup: the observation of the scene.
        body: simulates it.
    """

    def __init__(self, scene: Scene, setup: ObservationSetup, solver: str, device: str) -> None:
        self.setup = setup
        rest = world_positions(scene.mesh, setup)
        self.body = StaticBody(
            TetMesh(rest, scene.mesh.tets),
            scene.element,
            held_targets(setup, rest).vertices,
            law=find_law(scene.law),
            solver=solver,
            device=device,
        )
        self._path: HeldPath | None = None
        if any(part.turn is not None for part in setup.held):
            self._path = lambda fraction: held_targets(setup, rest, fraction).positions

    def settle(
        self,
        material: Material,
        gravity: FloatArray,
        prediction: FloatArray | None,
        conditions: Conditions,
    ) -> None:
        """Find the equilibrium, see `StaticBody.settle`."""
        self.body.settle(
            material,
            gravity,
            held_path=self._path,
            prediction=prediction,
            conditions=conditions,
        )

    def mesh_move(self, material: Material, gravity: FloatArray, solver: str) -> FloatArray:
        """Return how a better mesh would move the nodes [m], shape (N, 3)."""
        return MeshError(self.body, solver=solver).displacement(material, gravity, self._path)
