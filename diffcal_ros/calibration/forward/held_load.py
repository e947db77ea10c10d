# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that is let go and then filmed for long: at rest in every frame, while it creeps.

A clamp that is elsewhere takes the support along.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.posture import clamped_body, PostureInputs
from diffcal_ros.fem.creep import Creep, CreepChange
from diffcal_ros.fem.force_changes import Change, StaticGradient
from diffcal_ros.fem.mesh_error import MeshError
from diffcal_ros.fem.motion.inputs import MotionChange
from diffcal_ros.fem.static_body import StaticBody
from diffcal_ros.material import Material
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
        """Return the derivative along a change of the inputs, creep included.

        Raises:
            NotImplementedError: for a change of effects.
        """
        numbered = enumerate(self.frames)
        return sum(part.along(self.own_change(frame, change)) for frame, part in numbered)


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
        alone = replace(setup, held=setup.staying)
        self.body, self._path = clamped_body(scene, alone, solver, device)
        self._supported, self._support_path = clamped_body(scene, setup, solver, device)
        self._inputs: PostureInputs | None = None
        self._frames = np.zeros((0, 0, 3))

    def simulate(self, inputs: PostureInputs, prediction: FloatArray | None) -> None:
        """Find the equilibrium of every frame."""
        self._inputs = inputs
        self._frames = np.stack([self._at(frame).state.positions for frame in self._all()])

    def positions(self, state: int) -> FloatArray:
        """Return the nodes in one frame, world frame [m], shape (N, 3)."""
        frame: FloatArray = self._frames[state]
        return frame

    def tangents(self, changes: Sequence[Change]) -> FloatArray:
        """Return how all frames follow changes of the inputs [m], shape (k, S, N, 3)."""
        fields = []
        for frame in self._all():
            body = self._at(frame)
            fields.append(body.tangents([self._own_change(frame, change) for change in changes]))
        return np.stack(fields, axis=1)

    def gradient(self, by_positions: FloatArray) -> StaticGradient:
        """Pull a derivative by positions, shape (S, N, 3), back to the inputs but effects.

        Moduli count in full: what creep makes of them is part of each frame.
        """
        parts = []
        for frame in self._all():
            # Each frame solves the body anew: what it says of effects would not last.
            parts.append(replace(self._at(frame).gradient(by_positions[frame]), by_effects=None))
        factors = [self._creep().factor(self._held(frame)) for frame in self._all()]
        pairs = list(zip(factors, parts, strict=True))
        return _FramesGradient(
            youngs_modulus=np.sum([f * part.youngs_modulus for f, part in pairs], axis=0),
            poissons_ratio=np.sum([part.poissons_ratio for part in parts], axis=0),
            density=np.sum([part.density for part in parts], axis=0),
            gravity=np.sum([part.gravity for part in parts], axis=0),
            frames=tuple(parts),
            own_change=self._own_change,
        )

    def mesh_moves(self, inputs: PostureInputs, solver: str) -> FloatArray:
        """Return about how a better mesh would move the nodes [m], shape (S, N, 3).

        As it moves the body without support; on its support it hardly sags.
        """
        last = int(np.argmax(self._times))
        body = self._at(last)
        error = MeshError(body, solver=solver)
        moved = error.displacement(self._material(last), inputs.gravity, self._path)
        nothing = np.zeros_like(moved)
        return np.stack([moved if self._held(f) > 0.0 else nothing for f in self._all()])

    def warnings(self) -> list[str]:
        """Say nothing: an equilibrium is one, however it was found."""
        return []

    def _all(self) -> range:
        return range(len(self._times))

    def _held(self, frame: int) -> float:
        """Return how long the load had been held in a frame [s]; not above 0 on the support."""
        return float(self._times[frame] - self._now().release_time)

    def _now(self) -> PostureInputs:
        if self._inputs is None:
            raise RuntimeError('no state yet: call simulate first')
        return self._inputs

    def _creep(self) -> Creep:
        return self._now().creep

    def _at(self, frame: int) -> StaticBody:
        """Return the body in equilibrium as in a frame."""
        inputs, held = self._now(), self._held(frame)
        body, path = (
            (self.body, self._path) if held > 0.0 else (self._supported, self._support_path)
        )
        self._supported.axes = self.body.axes
        body.solve_equilibrium(
            self._material(frame), inputs.gravity, held_path=path, conditions=inputs.conditions
        )
        return body

    def _material(self, frame: int) -> Material:
        """Return the material as it answers in a frame."""
        material, factor = self._now().material, self._creep().factor(self._held(frame))
        if factor == 1.0:
            return material
        return replace(material, youngs_modulus=factor * material.youngs_modulus)

    def _own_change(self, frame: int, change: Change) -> Change:
        """Return what a change of the inputs is to the body in a frame."""
        held, modulus = self._held(frame), self._now().material.youngs_modulus
        if isinstance(change, CreepChange):
            return Change(youngs_modulus=change.along(held) * modulus)
        slower = np.zeros_like(modulus)
        if isinstance(change, MotionChange):
            # What is let go later has been held for less.
            slower = -change.release_time * self._creep().rate(held) * modulus
        if change.youngs_modulus is not None:
            slower = slower + self._creep().factor(held) * change.youngs_modulus
        return replace(change, youngs_modulus=slower) if slower.any() else change
