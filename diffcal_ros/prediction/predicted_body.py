# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body of each observation of a scene, simulated at the scene's own values."""

from dataclasses import dataclass

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import Instant, Observation
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import SceneError
from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.prediction.film_times import FilmTimes
from diffcal_ros.scene.model import ObservationSetup, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Nothing is seen yet: the cameras are put up when it is known where the body goes.
_NO_CAMERA = PinholeCamera(1, 1, 1.0, 1.0, 0.0, 0.0)
_NO_DEPTH = np.full((1, 1), np.nan, dtype=np.float32)


@dataclass(frozen=True)
class PredictedBody:
    """One observation's body at the times of its frames.

    Attributes:
        setup: the observation.
        times: [s], shape (F,).
        positions: of the nodes in the world frame [m], shape (F, N, 3).
        discretisation: elements and surface.
        held_nodes: that stay in the clamp, shape (h,).
        warnings: what a person should know of how it was simulated.
    """

    setup: ObservationSetup
    times: FloatArray
    positions: FloatArray
    discretisation: Discretisation
    held_nodes: NDArray[np.int32]
    warnings: tuple[str, ...] = ()

    @property
    def largest_displacement(self) -> float:
        """How far any node gets from its place without load [m]."""
        moved = self.positions - self.discretisation.rest_nodes
        return float(np.linalg.norm(moved, axis=2).max())


def predict_bodies(
    scene: Scene, film: FilmTimes, *, solver: str = 'auto', device: str = 'cpu'
) -> list[PredictedBody]:
    """Simulate every observation of a scene.

    Args:
        scene: its start values and effects are taken as they are.
        film: when a moving body is looked at.
        solver: name of the sparse solver.
        device: Warp device.

    Raises:
        SceneError: when a body has no equilibrium or cannot be followed in its motion.
    """
    times = [film.of(setup) for setup in scene.observations]
    return [
        _predict(scene, index, own, solver=solver, device=device)
        for index, own in enumerate(times)
    ]


def _predict(
    scene: Scene, index: int, times: FloatArray, *, solver: str, device: str
) -> PredictedBody:
    setup = scene.observations[index]
    frames = [_frame(setup, index, float(time)) for time in times]
    model = ForwardModel(scene, frames, ParameterSet(), solver=solver, device=device)
    try:
        solution = model.at(np.zeros(0))
    except (EquilibriumError, MotionError) as error:
        raise SceneError(f'{setup.name} cannot be simulated: {error}') from error
    body = model.bodies[index].body
    return PredictedBody(
        setup=setup,
        times=times,
        positions=solution.states[index].positions,
        discretisation=body.discretisation,
        held_nodes=body.held_nodes,
        warnings=tuple(model.warnings(solution.coordinates)),
    )


def _frame(setup: ObservationSetup, index: int, time: float) -> Observation:
    return Observation(
        name=setup.name,
        setup_index=index,
        depth=_NO_DEPTH,
        camera=_NO_CAMERA,
        depth_from_world=np.eye(4),
        instant=None if setup.motion is None else Instant(time, index),
    )
