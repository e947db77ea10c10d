# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The true body: a scene's mesh, perhaps a finer one, bent by its start values."""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.effect_model import EffectModel
from diffcal_ros.calibration.forward.posture import make_body
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.effects.registry import Amplitudes
from diffcal_ros.errors import SceneError
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.fem.terms.conditions import NO_CONDITIONS
from diffcal_ros.scene.body_plan import plan_body
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.sections.cables import start_cables
from diffcal_ros.scene.start_material import start_material
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class PosedBody:
    """A body at rest.

    Attributes:
        positions: of its nodes in the world frame [m], shape (N, 3).
        rest: where they are without load [m], shape (N, 3).
        triangles: outward, shape (F, 3).
        held_nodes: that a clamp holds, shape (h,).
    """

    positions: FloatArray
    rest: FloatArray
    triangles: IntArray
    held_nodes: IntArray

    @property
    def outward(self) -> FloatArray:
        """From the middle of what is held to the middle of the body [m], shape (3,)."""
        return self.positions.mean(axis=0) - self.positions[self.held_nodes].mean(axis=0)

    @property
    def largest_displacement(self) -> float:
        """How far the node that moved most is from its place at rest [m]."""
        return float(np.linalg.norm(self.positions - self.rest, axis=1).max())


def pose_body(
    scene: Scene,
    setup: ObservationSetup,
    *,
    solver: str = 'auto',
    effects: Amplitudes | None = None,
) -> PosedBody:
    """Let the body come to rest in one posture.

    Args:
        scene: its start values are the truth.
        setup: the posture, under the name of one of the scene's.
        solver: name of the sparse solver.
        effects: amplitudes of what else acts on the body, by effect and component.

    Raises:
        SceneError: when it finds no rest under the start values.
    """
    plan = plan_body(scene, setup)
    body = make_body(plan, plan.held, solver)
    conditions = NO_CONDITIONS
    if effects:
        model = EffectModel(scene, ParameterSet())
        index = [other.name for other in scene.observations].index(setup.name)
        nodes = body.discretisation.rest_nodes
        conditions = model.conditions(effects, index, nodes)
    conditions = replace(conditions, cables=start_cables(scene, setup))
    try:
        state = body.solve_equilibrium(
            start_material(scene), setup.gravity, held_path=plan.held.path, conditions=conditions
        )
    except EquilibriumError as error:
        raise SceneError(
            f'the start values of {setup.name} cannot be simulated: {error}'
        ) from error
    return PosedBody(
        positions=state.positions,
        rest=body.discretisation.rest_nodes,
        triangles=body.discretisation.surface_triangles,
        held_nodes=body.held_nodes,
    )
