# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From parameters to positions in the camera frame, with tangents: where fem and depth meet."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from diffcal_ros.calibration.forward.body_factory import instants
from diffcal_ros.calibration.forward.body_inputs import BodyInputs
from diffcal_ros.calibration.forward.effect_model import EffectModel
from diffcal_ros.calibration.forward.posture import Posture, PostureInputs, PostureStates
from diffcal_ros.calibration.forward.sensor_model import SensorModel
from diffcal_ros.calibration.forward.shared_bodies import SharedBodies
from diffcal_ros.calibration.forward.side_by_side import side_by_side
from diffcal_ros.calibration.forward.solution import KnownSolutions, Solution, View
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.parameters.camera_offsets import CameraOffsets
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.effects.registry import Amplitudes
from diffcal_ros.fem.statics.force_changes import Change, StaticGradient
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class ForwardModel:
    """Simulates every posture of a scene and traces it for every observation.

    `solve` and `with_tangents` take what they start from and return what they found. All else asks
    for coordinates and remembers the last solutions, so that none is found twice while a fit goes
    back and forth, and the next one starts from the last.
    """

    def __init__(
        self,
        scene: Scene,
        observations: Sequence[Observation],
        parameters: ParameterSet,
        *,
        solver: str = 'auto',
        device: str = 'cpu',
        shared: SharedBodies | None = None,
        warm: Solution | None = None,
    ) -> None:
        """Prepare bodies and cameras.

        Args:
            scene: the set-up.
            observations: what is to be predicted.
            parameters: of the fit.
            solver: name of the sparse solver.
            device: Warp device.
            shared: bodies of another model of the same observations; None: own ones are made.
            warm: a solution of that model to start from.
        """
        self.scene, self.parameters = scene, parameters
        self.observations = tuple(observations)
        self.device = device
        self._make = partial(ForwardModel, solver=solver, device=device)
        self._shared = shared or SharedBodies(scene, self.observations, solver, device)
        self.bodies, self.tracers = self._shared.bodies, self._shared.tracers
        pivots = [self._pivot(observation) for observation in observations]
        self.cameras = CameraOffsets(scene, self.observations, parameters, pivots)
        self.effects = EffectModel(scene, parameters)
        self.inputs = BodyInputs(scene, parameters, self.effects)
        self._warm = warm
        self._last: Solution | None = None
        self._known = KnownSolutions()

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle what it is made of: another process has bodies of its own.

        They go on from where these ones are: from rest a state may not be found, or another one.
        """
        make = partial(self._make, warm=self._next_warm())
        return make, (self.scene, self.observations, self.parameters)

    def with_parameters(self, scene: Scene, parameters: ParameterSet) -> 'ForwardModel':
        """Return a model of the same bodies and cameras with other parameters or effects."""
        warm = self._next_warm()
        return self._make(scene, self.observations, parameters, shared=self._shared, warm=warm)

    def _next_warm(self) -> Solution | None:
        """Return where another model may start from."""
        # Its tangents are by these parameters, and its views take memory.
        return self._warm if self._last is None else self._last.states_only()

    @property
    def place(self) -> FloatArray:
        """Coordinates of where the next solution starts from, shape (k,).

        Of what the model that this one comes from did not have, where it is absent.
        """
        if self._last is not None:
            return self._last.coordinates
        begun = self.parameters.start()
        if self._warm is not None:
            known = dict(zip(self._warm.names, self._warm.coordinates.tolist(), strict=True))
            for index, name in enumerate(self.parameters.names):
                begun[index] = known.get(name, begun[index])
        return begun

    @property
    def is_moving(self) -> bool:
        """Tell whether a body is seen in motion."""
        return any(seen.instant is not None for seen in self.observations)

    def body(self, observation: Observation) -> StaticBody:
        """Return the simulated body of an observation."""
        return self._shared.body(observation)

    def solve(self, coordinates: FloatArray, warm: Solution | None = None) -> Solution:
        """Simulate every body and place it before its cameras.

        Args:
            coordinates: of the parameters, shape (k,).
            warm: a solution of the same bodies to start from. With tangents, which must be by
                these coordinates, it is followed along them. None: from rest.

        Raises:
            EquilibriumError: when a posture has no equilibrium.
            MotionError: when a body cannot be followed in its motion.
        """
        inputs = {index: self._posture_inputs(index, coordinates) for index in self.bodies}

        def simulate(index: int) -> PostureStates:
            posture: Posture[Any] = self.bodies[index]
            if warm is None:
                return posture.solve(inputs[index])
            prediction = None
            if warm.tangents is not None:
                change = coordinates - warm.coordinates
                prediction = np.einsum('k,ksni->sni', change, warm.tangents[index])
            return posture.solve(inputs[index], warm.states[index], prediction)

        states = side_by_side(simulate, self.bodies, self.device)
        return self._solution(states, coordinates)

    def _solution(self, states: Mapping[int, PostureStates], coordinates: FloatArray) -> Solution:
        """Place states before the cameras."""
        views = tuple(
            View(self.cameras.points(number, shown, coordinates), self.tracers[number])
            for number, shown in enumerate(self._shown(states))
        )
        return Solution(coordinates.copy(), states, views, names=self.parameters.names)

    def with_tangents(self, solution: Solution) -> Solution:
        """Return a solution that knows how its bodies follow the coordinates."""
        if solution.tangents is not None:
            return solution
        tangents = side_by_side(
            lambda index: self._body_tangents(index, solution), self.bodies, self.device
        )
        return replace(solution, tangents=tangents)

    def at(self, coordinates: FloatArray) -> Solution:
        """Return the solution at some coordinates, found from the last one; see `solve`."""
        last = self._last
        if last is None or not np.array_equal(coordinates, last.coordinates):
            known = self._known.find(coordinates)
            if known is None:
                last = self.solve(coordinates, last or self._warm)
            else:
                last = self._solution(known.states, coordinates)
            self._known.add(last)
            self._last = last
        return last

    def keep(self, coordinates: FloatArray) -> None:
        """Remember what is found at some coordinates, shape (k,), until two others are kept."""
        self._known.keep(self.at(coordinates))

    def views(self, coordinates: FloatArray) -> tuple[View, ...]:
        """Return what every observation is predicted to show, see `solve`."""
        return self.at(coordinates).views

    def tangents(self, coordinates: FloatArray) -> list[FloatArray]:
        """Return how each view's points follow the coordinates [m], shape (k, N, 3) each."""
        self._last = solution = self.with_tangents(self.at(coordinates))
        assert solution.tangents is not None
        worlds = self._shown(solution.states)
        found = []
        for number, (observation, state) in enumerate(self._numbered()):
            own = solution.tangents[observation.setup_index][:, state]
            tangents = self.cameras.carried(number, worlds[number], own, coordinates)
            motions = self.cameras.motions(number, worlds[number], coordinates)
            for index, motion in motions.items():
                tangents[index] = motion
            found.append(tangents)
        return found

    def tangents_of(
        self, changes: Callable[[int, StaticBody], Sequence[Change]], coordinates: FloatArray
    ) -> list[FloatArray]:
        """Return how each view's points follow changes of the body [m], shape (k, N, 3) each.

        Args:
            changes: for the number of a posture and its body, the same count for every posture.
            coordinates: shape (c,).
        """
        states = self.at(coordinates).states

        def follow(index: int, posture: Posture[Any]) -> FloatArray:
            wanted = changes(index, posture.body)
            # A motion keeps its tangents: those of the parameters come with the same march.
            own = self._own_changes(index, coordinates)[1] if self.is_moving else []
            return posture.tangents(states[index], [*wanted, *own])[: len(wanted)]

        fields = {index: follow(index, posture) for index, posture in self.bodies.items()}
        return self._seen(fields, coordinates)

    def pull_back(self, by_points: Sequence[FloatArray], coordinates: FloatArray) -> FloatArray:
        """Pull a derivative by every view's points back to the coordinates.

        Args:
            by_points: derivative of a scalar by the points of each view [1/m], shape (N, 3).
            coordinates: shape (k,).

        Returns:
            Derivative by the coordinates, shape (k,).
        """
        gradient = np.zeros(len(coordinates))
        for number, world in enumerate(self._shown(self.at(coordinates).states)):
            for index, motion in self.cameras.motions(number, world, coordinates).items():
                gradient[index] += float((motion * by_points[number]).sum())
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
        states = self.at(coordinates).states
        by_world = {index: np.zeros_like(own.positions) for index, own in states.items()}
        worlds = self._shown(states)
        for number, (observation, state) in enumerate(self._numbered()):
            by_world[observation.setup_index][state] += self.cameras.carried_back(
                number, worlds[number], by_points[number], coordinates
            )
        return {
            index: self.bodies[index].gradient(states[index], both)
            for index, both in by_world.items()
        }

    def mesh_moves(self, coordinates: FloatArray, *, solver: str = 'auto') -> list[FloatArray]:
        """Return how a better mesh would move each view's points [m], shape (N, 3) each."""
        states = self.at(coordinates).states
        moves = side_by_side(
            lambda index: self.bodies[index].mesh_moves(states[index], solver),
            self.bodies,
            self.device,
        )
        return self._seen(moves, coordinates)

    def warnings(self, coordinates: FloatArray) -> list[str]:
        """Say what a person should know of how the states there were found."""
        states = self.at(coordinates).states
        return [text for index, own in self.bodies.items() for text in own.warnings(states[index])]

    def material(self, coordinates: FloatArray) -> Material:
        """Return the material of every tetrahedron."""
        return self.inputs.material(coordinates)

    def sensor(self, coordinates: FloatArray, number: int) -> SensorModel:
        """Return how the depth camera of one observation reads."""
        seen = self.observations[number]
        amplitudes = self.effects.amplitudes(coordinates, seen.setup_index, seen.time)
        return self.effects.sensor(amplitudes)

    def _body_tangents(self, index: int, solution: Solution) -> FloatArray:
        """World displacement per unit of each coordinate [m], zero for camera parameters."""
        posture, states = self.bodies[index], solution.states[index]
        tangents = np.zeros((len(self.parameters), *states.positions.shape))
        indices, changes = self._own_changes(index, solution.coordinates)
        if changes:
            tangents[indices] = posture.tangents(states, changes)
        return tangents

    def _own_changes(self, index: int, coordinates: FloatArray) -> tuple[list[int], list[Change]]:
        """Return which parameters change a body, and how."""
        rest = self.bodies[index].body.discretisation.rest_nodes
        found = [
            self.inputs.change(number, index, rest, coordinates)
            for number in range(len(self.parameters))
        ]
        indices = [number for number, change in enumerate(found) if change is not None]
        return indices, [change for change in found if change is not None]

    def _pivot(self, observation: Observation) -> FloatArray:
        """Return the point about which offsets turn: the middle of the held part."""
        body = self.body(observation)
        held = body.discretisation.rest_nodes[body.held_nodes]
        return apply(observation.depth_from_world, held.mean(axis=0))

    def _posture_inputs(self, index: int, coordinates: FloatArray) -> PostureInputs:
        rest = self.bodies[index].body.discretisation.rest_nodes
        amplitudes = self.effects.amplitudes(coordinates, index)
        conditions = self.effects.conditions(amplitudes, index, rest)
        return PostureInputs(
            material=self.inputs.material(coordinates),
            gravity=self.inputs.gravity(index, coordinates),
            conditions=replace(conditions, cables=self.inputs.cables(index, coordinates)),
            damping=self.inputs.damping(coordinates),
            release_time=self.inputs.release_time(index, coordinates),
            time_offset=self._time_offset(index, coordinates, amplitudes),
            creep=self.effects.creep(amplitudes),
            gravity_course=self.effects.gravity_course(coordinates, index),
        )

    def _time_offset(
        self, index: int, coordinates: FloatArray, usual: Amplitudes
    ) -> FloatArray | float:
        """Return by how much stamps of one posture are late [s], of each where they differ.

        Args:
            index: of the posture.
            coordinates: shape (k,).
            usual: amplitudes at all times.
        """
        always, effects = self.effects.time_offset(usual), self.effects
        if all(own.knot is None for own in self.parameters):
            return always
        late = [
            effects.time_offset(effects.amplitudes(coordinates, index, time))
            for time in instants(self.observations, index)
        ]
        return np.array(late) if any(own != always for own in late) else always

    def _seen(self, fields: dict[int, FloatArray], coordinates: FloatArray) -> list[FloatArray]:
        """Turn fields of all states, shape (.., S, N, 3), to those that the cameras see."""
        worlds = self.worlds(coordinates)
        return [
            self.cameras.carried(
                number,
                worlds[number],
                fields[observation.setup_index][..., state, :, :],
                coordinates,
            )
            for number, (observation, state) in enumerate(self._numbered())
        ]

    def worlds(self, coordinates: FloatArray) -> list[FloatArray]:
        """Return the nodes that every observation shows, world frame [m], shape (N, 3) each."""
        return self._shown(self.at(coordinates).states)

    def _shown(self, states: Mapping[int, PostureStates]) -> list[FloatArray]:
        return [states[seen.setup_index].positions[state] for seen, state in self._numbered()]

    def _numbered(self) -> Iterable[tuple[Observation, int]]:
        """Return each observation with the number of its state."""
        return zip(self.observations, self._shared.states, strict=True)
