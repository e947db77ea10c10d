# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that is let go and then filmed for long: at rest in every frame, while it creeps.

A clamp that is elsewhere takes the support along.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

from diffcal_ros.calibration.forward.posture import make_body, PostureInputs
from diffcal_ros.fem.held_part import HeldPath
from diffcal_ros.fem.motion.inputs import MotionChange
from diffcal_ros.fem.statics.creep import CreepChange
from diffcal_ros.fem.statics.force_changes import Change, StaticGradient
from diffcal_ros.fem.statics.mesh_error import MeshError
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.statics.static_state import StaticState
from diffcal_ros.material import Material
from diffcal_ros.scene.body_plan import plan_body
from diffcal_ros.scene.model import ObservationSetup, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class _FramesGradient(StaticGradient):
    """Derivative by the inputs of all frames.

    Attributes:
        frames: of each frame by its own inputs.
        own_change: returns what a change of the inputs is to a frame, given by number.
    """

    frames: tuple[StaticGradient, ...]
    own_change: Callable[[int, Change], Change]

    def along(self, change: Change) -> float:
        """Return the derivative along a change of the inputs, creep included."""
        numbered = enumerate(self.frames)
        return sum(part.along(self.own_change(frame, change)) for frame, part in numbered)


@dataclass(frozen=True)
class HeldLoadStates:
    """A body at rest in every frame.

    Attributes:
        inputs: what it depends on.
        solved: where it is, on its support in the frames before the release.
    """

    inputs: PostureInputs
    solved: tuple[StaticState, ...]

    @cached_property
    def positions(self) -> FloatArray:
        """The nodes, world frame [m], shape (S, N, 3)."""
        return np.stack([own.positions for own in self.solved])


class HeldLoadPosture:
    """A body in equilibrium in every frame: on its support, then without.

    Attributes:
        body: held by the parts that stay.
    """

    def __init__(
        self,
        scene: Scene,
        setup: ObservationSetup,
        times: Sequence[float],
        solver: str,
        device: str,
    ) -> None:
        """Prepare the body with its support and without.

        Args:
            scene: mesh and material law.
            setup: its motion and held parts.
            times: of the frames, after the first one [s], shape (S,).
            solver: name of the sparse solver.
            device: Warp device.
        """
        self._times = np.array(times, dtype=np.float64)
        plan = plan_body(scene, setup)
        self.body = make_body(plan, plan.staying, solver, device)
        self._supported = make_body(plan, plan.held, solver, device)
        self._path, self._support_path = plan.staying.path, plan.held.path

    def solve(
        self,
        inputs: PostureInputs,
        warm: HeldLoadStates | None = None,
        prediction: FloatArray | None = None,
    ) -> HeldLoadStates:
        """Find the equilibrium of every frame."""
        self.body.forget()
        self._supported.forget()
        return HeldLoadStates(
            inputs, tuple(self._solved(inputs, frame, warm) for frame in self._all())
        )

    def _solved(
        self, inputs: PostureInputs, frame: int, warm: HeldLoadStates | None
    ) -> StaticState:
        body, path = self._of(inputs, frame)
        if warm is not None and self._of(warm.inputs, frame)[0] is body:
            body.go_to(warm.solved[frame])
        body.solve_equilibrium(
            self._material(inputs, frame),
            inputs.gravity_at(float(self._times[frame])),
            held_path=path,
            conditions=inputs.conditions,
        )
        return body.solved

    def tangents(self, states: HeldLoadStates, changes: Sequence[Change]) -> FloatArray:
        """Return how all frames follow changes of the inputs [m], shape (k, S, N, 3)."""
        fields = []
        for frame in self._all():
            own = [self._own_change(states.inputs, frame, change) for change in changes]
            fields.append(self._at(states, frame).tangents(own))
        return np.stack(fields, axis=1)

    def gradient(self, states: HeldLoadStates, by_positions: FloatArray) -> StaticGradient:
        """Pull a derivative by positions, shape (S, N, 3), back to the inputs.

        Moduli count in full: what creep makes of them is part of each frame.
        """
        inputs = states.inputs
        parts = [self._at(states, f).gradient(by_positions[f]) for f in self._all()]
        factors = [inputs.creep.factor(self._held(inputs, frame)) for frame in self._all()]
        pairs = list(zip(factors, parts, strict=True))
        return _FramesGradient(
            youngs_modulus=np.sum([f * part.youngs_modulus for f, part in pairs], axis=0),
            poissons_ratio=np.sum([part.poissons_ratio for part in parts], axis=0),
            density=np.sum([part.density for part in parts], axis=0),
            gravity=np.sum([part.gravity for part in parts], axis=0),
            frames=tuple(parts),
            own_change=partial(self._own_change, inputs),
        )

    def mesh_moves(self, states: HeldLoadStates, solver: str) -> FloatArray:
        """Return about how a better mesh would move the nodes [m], shape (S, N, 3).

        As it moves the body without support; on its support it hardly sags.
        """
        inputs, last = states.inputs, int(np.argmax(self._times))
        error = MeshError(self._at(states, last), solver=solver)
        moved = error.displacement(self._material(inputs, last), inputs.gravity, self._path)
        nothing = np.zeros_like(moved)
        return np.stack([moved if self._held(inputs, f) > 0.0 else nothing for f in self._all()])

    def warnings(self, states: HeldLoadStates) -> list[str]:
        """Say nothing: an equilibrium is one, however it was found."""
        return []

    def _all(self) -> range:
        return range(len(self._times))

    def _held(self, inputs: PostureInputs, frame: int) -> float:
        """Return how long the load had been held in a frame [s]; not above 0 on the support."""
        return float(self._times[frame] - inputs.release_time)

    def _of(self, inputs: PostureInputs, frame: int) -> tuple[StaticBody, HeldPath | None]:
        """Return what is simulated in a frame, and the way of its clamp."""
        if self._held(inputs, frame) > 0.0:
            return self.body, self._path
        return self._supported, self._support_path

    def _at(self, states: HeldLoadStates, frame: int) -> StaticBody:
        """Return the body in equilibrium as in a frame."""
        body, _ = self._of(states.inputs, frame)
        body.go_to(states.solved[frame])
        return body

    def _material(self, inputs: PostureInputs, frame: int) -> Material:
        """Return the material as it answers in a frame."""
        factor = inputs.creep.factor(self._held(inputs, frame))
        if factor == 1.0:
            return inputs.material
        return replace(inputs.material, youngs_modulus=factor * inputs.material.youngs_modulus)

    def _own_change(self, inputs: PostureInputs, frame: int, change: Change) -> Change:
        """Return what a change of the inputs is to the body in a frame."""
        held, modulus = self._held(inputs, frame), inputs.material.youngs_modulus
        if isinstance(change, CreepChange):
            return Change(youngs_modulus=change.along(held) * modulus)
        slower = np.zeros_like(modulus)
        if isinstance(change, MotionChange):
            # What is let go later has been held for less.
            slower = -change.release_time * inputs.creep.rate(held) * modulus
            if change.gravity is not None:
                weight = float(change.weights(self._times[frame]))
                change = replace(change, gravity=weight * change.gravity)
        if change.youngs_modulus is not None:
            slower = slower + inputs.creep.factor(held) * change.youngs_modulus
        return replace(change, youngs_modulus=slower) if slower.any() else change
