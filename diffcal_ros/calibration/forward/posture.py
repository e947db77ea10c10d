# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The simulated body of one observation of a scene: where its nodes are, and what moves them.

A posture is asked about *states* that it has found: the nodes once for a body at rest, once a
frame for a body that moves. They are values; the posture goes back to them where it has to.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

from diffcal_ros.fem.motion.inputs import gravity_in, GravityCourse
from diffcal_ros.fem.statics.creep import Creep, NO_CREEP
from diffcal_ros.fem.statics.force_changes import Change, StaticGradient
from diffcal_ros.fem.statics.mesh_error import MeshError
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.statics.static_state import StaticState
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.material import Material
from diffcal_ros.scene.body_plan import BodyPlan, Holding, plan_body
from diffcal_ros.scene.model import ObservationSetup, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class PostureInputs:
    """What the state of a body depends on.

    Attributes:
        material: one value per tetrahedron.
        gravity: acceleration in the world frame [m/s^2], shape (3,).
        conditions: effects on the body.
        damping: by strain rates [Pa s], shape (T,).
        release_time: when the support lets go, after the first frame [s].
        time_offset: by which the stamps of the frames are late [s], of all or of each, shape (S,).
        creep: of the material under a load that is held.
        gravity_course: what gravity is more in the course of a recording.
    """

    material: Material
    gravity: FloatArray
    conditions: Conditions
    damping: FloatArray
    release_time: float
    time_offset: FloatArray | float = 0.0
    creep: Creep = NO_CREEP
    gravity_course: GravityCourse = ()

    def gravity_at(self, time: float) -> FloatArray:
        """Return gravity at a time after the first frame [s]."""
        return gravity_in(self.gravity_course, self.gravity, time)


class PostureStates(Protocol):
    """What a body does under some inputs."""

    @property
    def inputs(self) -> PostureInputs:
        """What the states depend on."""

    @property
    def positions(self) -> FloatArray:
        """Return the nodes, world frame [m], shape (S, N, 3)."""


States = TypeVar('States', bound=PostureStates)


class Posture(Protocol[States]):
    """A body, in states that are all found at once.

    Attributes:
        body: simulates it; held by what stays.
    """

    body: StaticBody

    def solve(
        self,
        inputs: PostureInputs,
        warm: States | None = None,
        prediction: FloatArray | None = None,
    ) -> States:
        """Find the states.

        Args:
            inputs: what they depend on.
            warm: states to start from; None: from rest.
            prediction: how far they will be off those [m], shape (S, N, 3).
        """

    def tangents(self, states: States, changes: Sequence[Change]) -> FloatArray:
        """Return how all states follow changes of the inputs [m], shape (k, S, N, 3)."""

    def gradient(self, states: States, by_positions: FloatArray) -> StaticGradient:
        """Pull a derivative by positions, shape (S, N, 3), back to the inputs."""

    def mesh_moves(self, states: States, solver: str) -> FloatArray:
        """Return how a better mesh would move the nodes [m], shape (S, N, 3)."""

    def warnings(self, states: States) -> list[str]:
        """Say what a person should know of how the states were found."""


@dataclass(frozen=True)
class RestingStates:
    """A body at rest.

    Attributes:
        inputs: what it depends on.
        solved: where it is.
    """

    inputs: PostureInputs
    solved: StaticState

    @property
    def positions(self) -> FloatArray:
        """The nodes, world frame [m], shape (1, N, 3)."""
        return self.solved.positions[None]


class RestingPosture:
    """A body at rest, and the way its clamp goes there.

    Attributes:
        body: simulates it.
    """

    def __init__(self, scene: Scene, setup: ObservationSetup, solver: str, device: str) -> None:
        plan = plan_body(scene, setup)
        self.body, self._path = make_body(plan, plan.held, solver, device), plan.held.path

    def solve(
        self,
        inputs: PostureInputs,
        warm: RestingStates | None = None,
        prediction: FloatArray | None = None,
    ) -> RestingStates:
        """Find the equilibrium."""
        if warm is None:
            self.body.forget()
        else:
            self.body.go_to(warm.solved)
        self.body.solve_equilibrium(
            inputs.material,
            inputs.gravity,
            held_path=self._path,
            prediction=None if prediction is None else prediction[0],
            conditions=inputs.conditions,
        )
        return RestingStates(inputs, self.body.solved)

    def tangents(self, states: RestingStates, changes: Sequence[Change]) -> FloatArray:
        """Return how the nodes follow changes of the inputs [m], shape (k, 1, N, 3)."""
        self.body.go_to(states.solved)
        return self.body.tangents(changes)[:, None]

    def gradient(self, states: RestingStates, by_positions: FloatArray) -> StaticGradient:
        """Pull a derivative by positions, shape (1, N, 3), back to the inputs."""
        self.body.go_to(states.solved)
        return self.body.gradient(by_positions[0])

    def mesh_moves(self, states: RestingStates, solver: str) -> FloatArray:
        """Return how a better mesh would move the nodes [m], shape (1, N, 3)."""
        self.body.go_to(states.solved)
        error, inputs = MeshError(self.body, solver=solver), states.inputs
        cables = inputs.conditions.cables
        return error.displacement(inputs.material, inputs.gravity, self._path, cables)[None]

    def warnings(self, states: RestingStates) -> list[str]:
        """Say nothing: an equilibrium is one, however it was found."""
        return []


def make_body(
    plan: BodyPlan, holding: Holding, solver: str = 'auto', device: str = 'cpu'
) -> StaticBody:
    """Make the body of an observation.

    Args:
        plan: of it.
        holding: what holds it.
        solver: name of the sparse solver.
        device: Warp device.
    """
    return StaticBody(
        plan.mesh,
        plan.element,
        holding.vertices,
        law=plan.law,
        solver=solver,
        device=device,
        cables=plan.cables,
        axes=plan.axes,
    )
