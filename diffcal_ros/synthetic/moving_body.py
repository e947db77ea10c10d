# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The true body in motion: a scene's mesh, perhaps a finer one, let go under its start values."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.moving_posture import MovingPosture
from diffcal_ros.calibration.forward.posture import PostureInputs
from diffcal_ros.errors import SceneError
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.fem.terms.conditions import NO_CONDITIONS
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.start_material import start_constant, start_material
from diffcal_ros.synthetic.posed_body import PosedBody
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class MovingBodyFilm:
    """A body at a number of times.

    Attributes:
        first: at the first time.
        positions: of its nodes in the world frame [m], shape (F, N, 3).
    """

    first: PosedBody
    positions: FloatArray

    def at(self, number: int) -> PosedBody:
        """Return the body at one of the times."""
        return replace(self.first, positions=self.positions[number])


def move_body(
    scene: Scene,
    setup: ObservationSetup,
    times: Sequence[float] | FloatArray,
    *,
    integrator: str | None = None,
    time_step: float | None = None,
) -> MovingBodyFilm:
    """Let the body go.

    Args:
        scene: its start values are the truth.
        setup: an observation that moves.
        times: after the first frame [s], shape (F,).
        integrator: in place of the scene's.
        time_step: in place of the scene's [s].

    Raises:
        SceneError: when it cannot be simulated.
    """
    if setup.motion is None:
        raise ValueError(f'{setup.name} is at rest')
    motion = replace(
        setup.motion,
        integrator=integrator or setup.motion.integrator,
        time_step=time_step or setup.motion.time_step,
        # A tolerance chooses steps of the scene's own integrator.
        tolerance=None if integrator or time_step else setup.motion.tolerance,
    )
    posture = MovingPosture(scene, replace(setup, motion=motion), list(times), 'auto', 'cpu')
    inputs = PostureInputs(
        material=start_material(scene),
        gravity=setup.gravity,
        conditions=NO_CONDITIONS,
        damping=start_constant(scene, 'damping'),
        release_time=motion.release_time.start,
    )
    try:
        positions = posture.solve(inputs).positions
    except (EquilibriumError, MotionError) as error:
        raise SceneError(
            f'the start values of {setup.name} cannot be simulated: {error}'
        ) from error
    shape = posture.body.discretisation
    first = PosedBody(
        positions=positions[0],
        rest=shape.rest_nodes,
        triangles=shape.surface_triangles,
        held_nodes=posture.body.held_nodes,
    )
    return MovingBodyFilm(first, positions)
