# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From parameters to positions in the camera frame, with tangents: where fem and depth meet."""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass

from diffcal_ros.calibration.effect_model import EffectModel, SensorModel
from diffcal_ros.calibration.observation import Observation
from diffcal_ros.calibration.parameters import (
    Kind,
    OFFSET_AXES,
    Parameter,
    ParameterSet,
    TILT_AXES,
)
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.conditions import Conditions
from diffcal_ros.fem.mesh_error import MeshError
from diffcal_ros.fem.static_body import Change, HeldPath, StaticBody
from diffcal_ros.material import Material
from diffcal_ros.rigid_motion import moved, moved_by, tilt_axes
from diffcal_ros.rigid_transform import apply, rotation_matrix
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.posing import held_targets, world_positions
from diffcal_ros.tet_mesh import TetMesh
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
        self.scene = scene
        self.observations = tuple(observations)
        self.parameters = parameters
        self.effects = EffectModel(scene, parameters)
        used = sorted({observation.setup_index for observation in observations})
        self.bodies = {
            index: _Posture(scene, scene.observations[index], solver, device) for index in used
        }
        for index, posture in self.bodies.items():
            posture.body.axes = self.effects.axes(index)
        self.tracers = [
            DepthTracer(
                self.body(observation).discretisation.surface_triangles,
                self.body(observation).discretisation.node_count,
                observation.camera,
                device=device,
            )
            for observation in observations
        ]
        self._pivots = [self._pivot(observation) for observation in observations]
        # One camera that is elsewhere is elsewhere in every view: its offset has one pivot.
        self._common_pivot = np.mean(self._pivots, axis=0)
        # Models that share bodies take turns: only the last one to settle them may ask them.
        self._turn: dict[str, ForwardModel] = {}
        self._forget()

    def _forget(self) -> None:
        """Know nothing of the last coordinates."""
        self._coordinates: FloatArray | None = None
        self._tangents: dict[int, FloatArray] = {}
        self._tangent_coordinates: FloatArray | None = None
        self._views: list[View] = []

    def with_parameters(self, scene: Scene, parameters: ParameterSet) -> 'ForwardModel':
        """Return a model of the same bodies and cameras with other parameters or effects."""
        other = copy(self)
        other.scene, other.parameters = scene, parameters
        other.effects = EffectModel(scene, parameters)
        other._forget()
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
            gravity = self._gravity(posture.setup, coordinates)
            rest = posture.body.discretisation.rest_nodes
            posture.settle(
                material,
                gravity,
                self._prediction(index, coordinates),
                self.effects.conditions(amplitudes, index, rest, gravity),
            )
        self._views = []
        for number, observation in enumerate(self.observations):
            points = self._camera_points(number, observation, coordinates)
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
            fields[observation.setup_index]
            @ self._camera_from_world_rotation(number, coordinates).T
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
        by_world = by_points @ self._camera_from_world_rotation(number, coordinates)
        static = self.body(observation).gradient(by_world)
        gradient = np.zeros(len(coordinates))
        for place, parameter in enumerate(self.parameters):
            change = self._change(parameter, observation.setup_index, place, coordinates)
            motion = self._camera_motion(number, parameter, coordinates)
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
            index: posture.mesh_move(material, self._gravity(posture.setup, coordinates), solver)
            for index, posture in self.bodies.items()
        }
        return [
            moves[observation.setup_index]
            @ self._camera_from_world_rotation(number, coordinates).T
            for number, observation in enumerate(self.observations)
        ]

    def material(self, coordinates: FloatArray) -> Material:
        """Return the material of every tetrahedron."""
        scene = self.scene
        columns = {
            kind: np.empty(scene.mesh.tet_count)
            for kind in (Kind.YOUNGS_MODULUS, Kind.POISSONS_RATIO, Kind.DENSITY)
        }
        for kind, column in columns.items():
            for region in scene.regions:
                column[region.tets] = getattr(region, kind.value).start
        for parameter, coordinate in zip(self.parameters, coordinates, strict=True):
            if parameter.kind in columns:
                tets = scene.regions[parameter.target].tets
                columns[parameter.kind][tets] = parameter.value(coordinate)
        contrast = self.effects.log_modulus(self.effects.amplitudes(coordinates))
        if contrast is not None:
            columns[Kind.YOUNGS_MODULUS] *= np.exp(contrast)
        return Material(
            youngs_modulus=columns[Kind.YOUNGS_MODULUS],
            poissons_ratio=columns[Kind.POISSONS_RATIO],
            density=columns[Kind.DENSITY],
            convention=scene.convention,
        )

    def sensor(self, coordinates: FloatArray) -> SensorModel:
        """Return how the depth camera reads."""
        return self.effects.sensor(self.effects.amplitudes(coordinates))

    def rigid_offset(self, coordinates: FloatArray) -> FloatArray:
        """Return the offset's translation [m] and rotation vector [rad], shape (6,)."""
        return self._six(coordinates, Kind.RIGID_OFFSET, None)

    def _six(self, coordinates: FloatArray, kind: Kind, observation: int | None) -> FloatArray:
        values = self._stated_offset() if kind is Kind.RIGID_OFFSET else np.zeros(6)
        for parameter, coordinate in zip(self.parameters, coordinates, strict=True):
            if parameter.kind is kind and observation in (None, parameter.target):
                values[parameter.axis] = coordinate
        return values

    def _stated_offset(self) -> FloatArray:
        """Return the offset that the scene states, shape (6,)."""
        known = self.scene.effects.get('camera_offset', {})
        return np.array([known.get(axis, 0.0) for axis in OFFSET_AXES])

    def _gravity(self, setup: ObservationSetup, coordinates: FloatArray) -> FloatArray:
        known = self.scene.effects.get('gravity_tilt', {})
        angles = np.array([known.get(axis, 0.0) for axis in TILT_AXES])
        for parameter, coordinate in zip(self.parameters, coordinates, strict=True):
            if parameter.kind is Kind.GRAVITY_TILT:
                angles[parameter.target] = coordinate
        return rotation_matrix(angles @ np.stack(tilt_axes(setup.gravity))) @ setup.gravity

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

    def _body_tangents(
        self, index: int, posture: '_Posture', coordinates: FloatArray
    ) -> FloatArray:
        """World displacement per unit of each coordinate [m], zero for camera parameters."""
        body = posture.body
        tangents = np.zeros((len(self.parameters), body.discretisation.node_count, 3))
        places, changes = [], []
        for place, parameter in enumerate(self.parameters):
            change = self._change(parameter, index, place, coordinates)
            if change is not None:
                places.append(place)
                changes.append(change)
        if changes:
            tangents[places] = body.tangents(changes)
        return tangents

    def _change(
        self, parameter: Parameter, setup_index: int, place: int, coordinates: FloatArray
    ) -> Change | None:
        """Return how a parameter acts on the body in one posture, or None."""
        posture = self.bodies[setup_index]
        if parameter.kind is Kind.EFFECT:
            return self._effect_change(parameter, setup_index, coordinates)
        if parameter.kind is Kind.GRAVITY_TILT:
            # To first order in the tilt, which is a few degrees.
            axis = tilt_axes(posture.setup.gravity)[parameter.target]
            return Change(gravity=np.cross(axis, self._gravity(posture.setup, coordinates)))
        if parameter.kind not in (Kind.YOUNGS_MODULUS, Kind.POISSONS_RATIO, Kind.DENSITY):
            return None
        column = np.zeros(self.scene.mesh.tet_count)
        tets = self.scene.regions[parameter.target].tets
        column[tets] = 1.0
        if parameter.kind is Kind.YOUNGS_MODULUS:
            return Change(youngs_modulus=column * self.material(coordinates).youngs_modulus)
        if parameter.kind is Kind.DENSITY:
            return Change(density=column * parameter.value(coordinates[place]))
        return Change(poissons_ratio=column)

    def _effect_change(
        self, parameter: Parameter, setup_index: int, coordinates: FloatArray
    ) -> Change | None:
        mode = self.effects.modulus_mode(parameter)
        if mode is not None:
            return Change(youngs_modulus=mode * self.material(coordinates).youngs_modulus)
        change = self.effects.change(
            parameter,
            setup_index,
            self.bodies[setup_index].body.discretisation.rest_nodes,
            self.effects.amplitudes(coordinates),
        )
        return None if change is None else Change(conditions=change)

    def _pivot(self, observation: Observation) -> FloatArray:
        """Return the point about which offsets turn: the middle of the held part."""
        body = self.body(observation)
        held = body.discretisation.rest_nodes[body.held_nodes]
        return apply(observation.depth_from_world, held.mean(axis=0))

    def _camera_points(
        self, number: int, observation: Observation, coordinates: FloatArray
    ) -> FloatArray:
        world = self.body(observation).state.positions
        points = apply(observation.depth_from_world, world)
        for six, pivot in self._offsets(number, coordinates):
            points = moved(points, six, pivot)
        return points

    def _offsets(
        self, number: int, coordinates: FloatArray
    ) -> list[tuple[FloatArray, FloatArray]]:
        """Return translation and rotation vector, shape (6,), and pivot, in order of use."""
        pivot = self._pivots[number]
        measured = self.observations[number].pose_pivot
        return [
            (
                self._six(coordinates, Kind.CAMERA_POSE, number),
                pivot if measured is None else measured,
            ),
            (self._six(coordinates, Kind.RIGID_OFFSET, None), self._common_pivot),
        ]

    def _view_tangents(
        self, number: int, observation: Observation, coordinates: FloatArray
    ) -> FloatArray:
        to_camera = self._camera_from_world_rotation(number, coordinates)
        tangents = self._tangents[observation.setup_index] @ to_camera.T
        for place, parameter in enumerate(self.parameters):
            motion = self._camera_motion(number, parameter, coordinates)
            if motion is not None:
                tangents[place] = motion
        return tangents

    def _camera_from_world_rotation(self, number: int, coordinates: FloatArray) -> FloatArray:
        """Return the rotation from the world to the camera, offsets included, shape (3, 3)."""
        rotation = self.observations[number].depth_from_world[:3, :3]
        for six, _ in self._offsets(number, coordinates):
            rotation = rotation_matrix(six[3:]) @ rotation
        return rotation

    def _camera_motion(
        self, number: int, parameter: Parameter, coordinates: FloatArray
    ) -> FloatArray | None:
        """Return how a camera parameter moves the points [m], shape (N, 3); None for others."""
        is_pose = parameter.kind is Kind.CAMERA_POSE and parameter.target == number
        if not is_pose and parameter.kind is not Kind.RIGID_OFFSET:
            return None
        observation = self.observations[number]
        (pose, point), (offset, pivot) = self._offsets(number, coordinates)
        start = apply(observation.depth_from_world, self.body(observation).state.positions)
        if is_pose:
            turned = rotation_matrix(offset[3:])
            return moved_by(start, pose, point, parameter.axis) @ turned.T
        return moved_by(moved(start, pose, point), offset, pivot, parameter.axis)


class _Posture:
    """A body and the way its clamp goes."""

    def __init__(self, scene: Scene, setup: ObservationSetup, solver: str, device: str) -> None:
        self.setup = setup
        rest = world_positions(scene.mesh, setup)
        self.body = StaticBody(
            TetMesh(rest, scene.mesh.tets),
            scene.element,
            held_targets(setup, rest).vertices,
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
        self.body.settle(
            material,
            gravity,
            held_path=self._path,
            prediction=prediction,
            conditions=conditions,
        )

    def mesh_move(self, material: Material, gravity: FloatArray, solver: str) -> FloatArray:
        return MeshError(self.body, solver=solver).displacement(material, gravity, self._path)
