# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From parameters to positions in the camera frame, with tangents: where fem and depth meet."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

from diffcal_ros.calibration.forward.body_inputs import BodyInputs
from diffcal_ros.calibration.forward.effect_model import EffectModel, SensorModel
from diffcal_ros.calibration.forward.posture import Posture, PostureInputs
from diffcal_ros.calibration.forward.shared_bodies import SharedBodies
from diffcal_ros.calibration.forward.side_by_side import side_by_side
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.parameters.camera_offsets import CameraOffsets
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.force_changes import Change, StaticGradient
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
        tracer: of that camera.
    """

    points: FloatArray
    tracer: DepthTracer

    @cached_property
    def trace(self) -> Trace:
        """The traced view.

        Raises:
            OutOfViewError: when the camera does not see the body.
        """
        return self.tracer.trace(self.points)


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
        shared: SharedBodies | None = None,
    ) -> None:
        """Prepare bodies and cameras.

        Args:
            scene: the set-up.
            observations: what is to be predicted.
            parameters: of the fit.
            solver: name of the sparse solver.
            device: Warp device.
            shared: bodies of another model of the same observations; None: own ones are made.
        """
        self.scene, self.parameters = scene, parameters
        self.observations = tuple(observations)
        self.device = device
        self._make = partial(ForwardModel, solver=solver, device=device)
        self._shared = shared or SharedBodies(scene, self.observations, solver, device)
        self.bodies, self.tracers = self._shared.bodies, self._shared.tracers
        self._states = self._shared.states
        pivots = [self._pivot(observation) for observation in observations]
        self.cameras = CameraOffsets(scene, self.observations, parameters, pivots)
        self.effects = EffectModel(scene, parameters)
        self.inputs = BodyInputs(scene, parameters, self.effects)
        self._coordinates: FloatArray | None = None
        self._tangents: dict[int, FloatArray] = {}
        self._tangent_coordinates: FloatArray | None = None
        self._views: list[View] = []
        if shared is None:
            for index, posture in self.bodies.items():
                posture.body.axes = self.effects.axes(index)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle what it is made of: another process has bodies of its own."""
        return self._make, (self.scene, self.observations, self.parameters)

    def with_parameters(self, scene: Scene, parameters: ParameterSet) -> 'ForwardModel':
        """Return a model of the same bodies and cameras with other parameters or effects."""
        return self._make(scene, self.observations, parameters, shared=self._shared)

    @property
    def is_moving(self) -> bool:
        """Tell whether a body is seen in motion."""
        return any(seen.instant is not None for seen in self.observations)

    def body(self, observation: Observation) -> StaticBody:
        """Return the simulated body of an observation."""
        return self._shared.body(observation)

    def views(self, coordinates: FloatArray) -> list[View]:
        """Simulate and trace; one view an observation.

        Args:
            coordinates: of the parameters, shape (k,).

        Raises:
            EquilibriumError: when a posture has no equilibrium.
            MotionError: when a body cannot be followed in its motion.
        """
        is_there = self._shared.are_of(self) and self._coordinates is not None
        if is_there and np.array_equal(coordinates, np.asarray(self._coordinates)):
            return self._views
        self._shared.enter(self)
        predictions = {index: self._prediction(index, coordinates) for index in self.bodies}
        self._coordinates = None  # Where one posture fails, the others are elsewhere already.
        inputs = {index: self._posture_inputs(index, coordinates) for index in self.bodies}

        def simulate(index: int) -> None:
            self.bodies[index].simulate(inputs[index], predictions[index])

        side_by_side(simulate, self.bodies, self.device)
        self._views = []
        for number in range(len(self.observations)):
            points = self.cameras.points(number, self.world(number), coordinates)
            self._views.append(View(points, self.tracers[number]))
        self._coordinates = coordinates.copy()
        return self._views

    def tangents(self, coordinates: FloatArray) -> list[FloatArray]:
        """Return how each view's points follow the coordinates [m], shape (k, N, 3) each."""
        self.views(coordinates)
        self._tangents = side_by_side(
            lambda index: self._body_tangents(index, self.bodies[index], coordinates),
            self.bodies,
            self.device,
        )
        self._tangent_coordinates = coordinates.copy()
        return [
            self._view_tangents(number, coordinates) for number in range(len(self.observations))
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
            index: posture.tangents(changes(index, posture.body))
            for index, posture in self.bodies.items()
        }
        return self._seen(fields, coordinates)

    def pull_back(self, by_points: Sequence[FloatArray], coordinates: FloatArray) -> FloatArray:
        """Pull a derivative by every view's points back to the coordinates.

        Args:
            by_points: derivative of a scalar by the points of each view [1/m], shape (N, 3).
            coordinates: shape (k,); the model must be there, see `views`.

        Returns:
            Derivative by the coordinates, shape (k,).
        """
        gradient = np.zeros(len(coordinates))
        for number in range(len(self.observations)):
            for parameter_index in range(len(coordinates)):
                motion = self.cameras.motion(
                    number, parameter_index, self.world(number), coordinates
                )
                if motion is not None:
                    gradient[parameter_index] += float((motion * by_points[number]).sum())
        for index, pulled in self._pulled(by_points, coordinates).items():
            rest = self.bodies[index].body.discretisation.rest_nodes
            for parameter_index in range(len(coordinates)):
                change = self.inputs.change(parameter_index, index, rest, coordinates)
                if change is not None:
                    gradient[parameter_index] += pulled.along(change)
        return gradient

    def pull_back_to_tets(
        self, by_points: Sequence[FloatArray], coordinates: FloatArray
    ) -> FloatArray:
        """Pull a derivative by every view's points back to each tetrahedron's own modulus.

        Args:
            by_points: see `pull_back`.
            coordinates: see `pull_back`.

        Returns:
            Derivative by the logarithm of Young's modulus, shape (T,): one solve a posture.
        """
        by_modulus = np.zeros(self.scene.mesh.tet_count)
        for pulled in self._pulled(by_points, coordinates).values():
            by_modulus += pulled.youngs_modulus
        by_log: FloatArray = by_modulus * self.material(coordinates).youngs_modulus
        return by_log

    def _pulled(
        self, by_points: Sequence[FloatArray], coordinates: FloatArray
    ) -> dict[int, StaticGradient]:
        """Pull a derivative by every view's points back to the inputs of each posture."""
        by_world: dict[int, FloatArray] = {}
        for number, (observation, state) in enumerate(self._numbered()):
            index = observation.setup_index
            if index not in by_world:
                by_world[index] = np.zeros((self._state_count(index), *by_points[number].shape))
            rotation = self.cameras.rotation(number, coordinates)
            by_world[index][state] += by_points[number] @ rotation
        return {index: self.bodies[index].gradient(both) for index, both in by_world.items()}

    def factor_bodies(self) -> None:
        """Factor every body's stiffness where it is now: pays before many single solves."""
        for posture in self.bodies.values():
            posture.body.factor()

    @property
    def log_modulus(self) -> FloatArray | None:
        """The field that is added to the logarithm of Young's modulus, shape (T,), or None."""
        return self.inputs.log_modulus

    def set_log_modulus(self, field: FloatArray | None) -> None:
        """Add a field to the logarithm of every tetrahedron's Young's modulus, shape (T,)."""
        self.inputs.log_modulus = field
        self._coordinates = None

    def mesh_moves(self, coordinates: FloatArray, *, solver: str = 'auto') -> list[FloatArray]:
        """Return how a better mesh would move each view's points [m], shape (N, 3) each."""
        self.views(coordinates)
        inputs = {index: self._posture_inputs(index, coordinates) for index in self.bodies}
        moves = side_by_side(
            lambda index: self.bodies[index].mesh_moves(inputs[index], solver),
            self.bodies,
            self.device,
        )
        return self._seen(moves, coordinates)

    def warnings(self) -> list[str]:
        """Say what a person should know of how the last states were found."""
        return [text for posture in self.bodies.values() for text in posture.warnings()]

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
        if not self._shared.were_of(self):
            return None
        change = coordinates - self._tangent_coordinates
        return np.einsum('k,ksni->sni', change, self._tangents[index])

    def _body_tangents(self, index: int, posture: Posture, coordinates: FloatArray) -> FloatArray:
        """World displacement per unit of each coordinate [m], zero for camera parameters."""
        rest = posture.body.discretisation.rest_nodes
        tangents = np.zeros((len(self.parameters), self._state_count(index), *rest.shape))
        indices, changes = [], []
        for parameter_index in range(len(self.parameters)):
            change = self.inputs.change(parameter_index, index, rest, coordinates)
            if change is not None:
                indices.append(parameter_index)
                changes.append(change)
        if changes:
            tangents[indices] = posture.tangents(changes)
        return tangents

    def _pivot(self, observation: Observation) -> FloatArray:
        """Return the point about which offsets turn: the middle of the held part."""
        body = self.body(observation)
        held = body.discretisation.rest_nodes[body.held_nodes]
        return apply(observation.depth_from_world, held.mean(axis=0))

    def _view_tangents(self, number: int, coordinates: FloatArray) -> FloatArray:
        to_camera = self.cameras.rotation(number, coordinates)
        index, state = self.observations[number].setup_index, self._states[number]
        tangents = self._tangents[index][:, state] @ to_camera.T
        for parameter_index in range(len(self.parameters)):
            motion = self.cameras.motion(number, parameter_index, self.world(number), coordinates)
            if motion is not None:
                tangents[parameter_index] = motion
        return tangents

    def _posture_inputs(self, index: int, coordinates: FloatArray) -> PostureInputs:
        rest = self.bodies[index].body.discretisation.rest_nodes
        amplitudes = self.effects.amplitudes(coordinates)
        conditions = self.effects.conditions(amplitudes, index, rest)
        return PostureInputs(
            material=self.inputs.material(coordinates),
            gravity=self.inputs.gravity(index, coordinates),
            conditions=replace(conditions, cables=self.inputs.cables(index, coordinates)),
            damping=self.inputs.damping(coordinates),
            release_time=self.inputs.release_time(index, coordinates),
            time_offset=self.effects.time_offset(amplitudes),
            creep=self.effects.creep(amplitudes),
        )

    def _seen(self, fields: dict[int, FloatArray], coordinates: FloatArray) -> list[FloatArray]:
        """Turn fields of all states, shape (.., S, N, 3), to those that the cameras see."""
        return [
            fields[observation.setup_index][..., state, :, :]
            @ self.cameras.rotation(number, coordinates).T
            for number, (observation, state) in enumerate(self._numbered())
        ]

    def world(self, number: int) -> FloatArray:
        """Return the nodes that an observation shows, world frame [m], shape (N, 3)."""
        return self.bodies[self.observations[number].setup_index].positions(self._states[number])

    def _numbered(self) -> Iterable[tuple[Observation, int]]:
        """Return each observation with the number of its state."""
        return zip(self.observations, self._states, strict=True)

    def _state_count(self, index: int) -> int:
        own = [state for seen, state in self._numbered() if seen.setup_index == index]
        return max(own) + 1
