# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From parameters to positions in the camera frame, with tangents: where fem and depth meet."""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass

from diffcal_ros.calibration.body_inputs import BodyInputs
from diffcal_ros.calibration.camera_offsets import CameraOffsets
from diffcal_ros.calibration.effect_model import EffectModel, SensorModel
from diffcal_ros.calibration.observation import Observation
from diffcal_ros.calibration.parameters import ParameterSet
from diffcal_ros.calibration.posture import Posture
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.force_changes import Change
from diffcal_ros.fem.static_body import StaticBody
from diffcal_ros.material import Material
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class View:
    """The body as one observation's camera is predicted to see it.

    Attributes:
        points: node positions in the camera frame [m], shape (N, 3).
        trace: the traced view.
    """

    points: FloatArray
    trace: Trace


class ForwardModel:
    """Simulates every posture of a scene and traces it for every observation."""

    def __init__(
        self,
        scene: Scene,
        observations: Sequence[Observation],
        parameters: ParameterSet,
        *,
        solver: str = 'auto',
        device: str = 'cpu',
    ) -> None:
        self.observations = tuple(observations)
        used = sorted({observation.setup_index for observation in observations})
        self.bodies = {
            index: Posture(scene, scene.observations[index], solver, device) for index in used
        }
        self.tracers = [
            DepthTracer(
                self.body(observation).discretisation.surface_triangles,
                self.body(observation).discretisation.node_count,
                observation.camera,
                device=device,
            )
            for observation in observations
        ]
        pivots = [self._pivot(observation) for observation in observations]
        self.cameras = CameraOffsets(scene, self.observations, parameters, pivots)
        # Models that share bodies take turns: only the last one to settle them may ask them.
        self._turn: dict[str, ForwardModel] = {}
        self._take(scene, parameters)
        for index, posture in self.bodies.items():
            posture.body.axes = self.effects.axes(index)

    def _take(self, scene: Scene, parameters: ParameterSet) -> None:
        """Take parameters, and know nothing of the last coordinates."""
        self.scene, self.parameters = scene, parameters
        self.effects = EffectModel(scene, parameters)
        self.inputs = BodyInputs(scene, parameters, self.effects)
        self._coordinates: FloatArray | None = None
        self._tangents: dict[int, FloatArray] = {}
        self._tangent_coordinates: FloatArray | None = None
        self._views: list[View] = []

    def with_parameters(self, scene: Scene, parameters: ParameterSet) -> 'ForwardModel':
        """Return a model of the same bodies and cameras with other parameters or effects."""
        other = copy(self)
        other.cameras = self.cameras.with_parameters(scene, parameters)
        other._take(scene, parameters)
        return other

    def body(self, observation: Observation) -> StaticBody:
        """Return the simulated body of an observation."""
        return self.bodies[observation.setup_index].body

    def views(self, coordinates: FloatArray) -> list[View]:
        """Simulate and trace; one view an observation.

        Args:
            coordinates: of the parameters, shape (k,).

        Raises:
            EquilibriumError: when a posture has no equilibrium.
            OutOfViewError: when a camera does not see the body.
        """
        is_there = self._turn.get('last') is self and self._coordinates is not None
        if is_there and np.array_equal(coordinates, np.asarray(self._coordinates)):
            return self._views
        self._turn['before'] = self._turn.get('last', self)
        self._turn['last'] = self
        material, amplitudes = self.material(coordinates), self.effects.amplitudes(coordinates)
        for index, posture in self.bodies.items():
            gravity = self.inputs.gravity(index, coordinates)
            rest = posture.body.discretisation.rest_nodes
            posture.settle(
                material,
                gravity,
                self._prediction(index, coordinates),
                self.effects.conditions(amplitudes, index, rest, gravity),
            )
        self._views = []
        for number, observation in enumerate(self.observations):
            world = self.body(observation).state.positions
            points = self.cameras.points(number, world, coordinates)
            self._views.append(View(points, self.tracers[number].trace(points)))
        self._coordinates = coordinates.copy()
        return self._views

    def tangents(self, coordinates: FloatArray) -> list[FloatArray]:
        """Return how each view's points follow the coordinates [m], shape (k, N, 3) each."""
        self.views(coordinates)
        self._tangents = {
            index: self._body_tangents(index, posture, coordinates)
            for index, posture in self.bodies.items()
        }
        self._tangent_coordinates = coordinates.copy()
        return [
            self._view_tangents(number, observation, coordinates)
            for number, observation in enumerate(self.observations)
        ]

    def tangents_of(
        self, changes: Callable[[int, StaticBody], Sequence[Change]], coordinates: FloatArray
    ) -> list[FloatArray]:
        """Return how each view's points follow changes of the body [m], shape (k, N, 3) each.

        Args:
            changes: for the number of a posture and its body, the same count for every posture.
            coordinates: shape (c,).
        """
        self.views(coordinates)
        fields = {
            index: posture.body.tangents(changes(index, posture.body))
            for index, posture in self.bodies.items()
        }
        return [
            fields[observation.setup_index] @ self.cameras.rotation(number, coordinates).T
            for number, observation in enumerate(self.observations)
        ]

    def pull_back(self, number: int, by_points: FloatArray, coordinates: FloatArray) -> FloatArray:
        """Pull a derivative by one view's points back to the coordinates (one adjoint solve).

        Args:
            number: of the view.
            by_points: derivative of a scalar by its points [1/m], shape (N, 3).
            coordinates: shape (k,); the model must be there, see `views`.

        Returns:
            Derivative by the coordinates, shape (k,).
        """
        observation = self.observations[number]
        body = self.body(observation)
        by_world = by_points @ self.cameras.rotation(number, coordinates)
        static, world = body.gradient(by_world), body.state.positions
        rest = body.discretisation.rest_nodes
        gradient = np.zeros(len(coordinates))
        for place in range(len(coordinates)):
            change = self.inputs.change(place, observation.setup_index, rest, coordinates)
            motion = self.cameras.motion(number, place, world, coordinates)
            if change is not None:
                gradient[place] = static.along(change)
            elif motion is not None:
                gradient[place] = float((motion * by_points).sum())
        return gradient

    def mesh_moves(self, coordinates: FloatArray, *, solver: str = 'auto') -> list[FloatArray]:
        """Return how a better mesh would move each view's points [m], shape (N, 3) each."""
        self.views(coordinates)
        material = self.material(coordinates)
        moves = {
            index: posture.mesh_move(material, self.inputs.gravity(index, coordinates), solver)
            for index, posture in self.bodies.items()
        }
        return [
            moves[observation.setup_index] @ self.cameras.rotation(number, coordinates).T
            for number, observation in enumerate(self.observations)
        ]

    def material(self, coordinates: FloatArray) -> Material:
        """Return the material of every tetrahedron."""
        return self.inputs.material(coordinates)

    def sensor(self, coordinates: FloatArray) -> SensorModel:
        """Return how the depth camera reads."""
        return self.effects.sensor(self.effects.amplitudes(coordinates))

    def _prediction(self, index: int, coordinates: FloatArray) -> FloatArray | None:
        if self._tangent_coordinates is None or index not in self._tangents:
            return None
        if self._coordinates is None or not np.array_equal(
            self._coordinates, self._tangent_coordinates
        ):
            return None
        if self._turn.get('before') is not self:
            return None
        change = coordinates - self._tangent_coordinates
        return np.einsum('k,kni->ni', change, self._tangents[index])

    def _body_tangents(self, index: int, posture: Posture, coordinates: FloatArray) -> FloatArray:
        """World displacement per unit of each coordinate [m], zero for camera parameters."""
        body = posture.body
        rest = body.discretisation.rest_nodes
        tangents = np.zeros((len(self.parameters), *rest.shape))
        places, changes = [], []
        for place in range(len(self.parameters)):
            change = self.inputs.change(place, index, rest, coordinates)
            if change is not None:
                places.append(place)
                changes.append(change)
        if changes:
            tangents[places] = body.tangents(changes)
        return tangents

    def _pivot(self, observation: Observation) -> FloatArray:
        """Return the point about which offsets turn: the middle of the held part."""
        body = self.body(observation)
        held = body.discretisation.rest_nodes[body.held_nodes]
        return apply(observation.depth_from_world, held.mean(axis=0))

    def _view_tangents(
        self, number: int, observation: Observation, coordinates: FloatArray
    ) -> FloatArray:
        to_camera = self.cameras.rotation(number, coordinates)
        tangents = self._tangents[observation.setup_index] @ to_camera.T
        world = self.body(observation).state.positions
        for place in range(len(self.parameters)):
            motion = self.cameras.motion(number, place, world, coordinates)
            if motion is not None:
                tangents[place] = motion
        return tangents
