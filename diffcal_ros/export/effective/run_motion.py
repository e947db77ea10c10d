# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that is let go in another simulator, in the place of this package's own."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.moving_posture import MovingPosture
from diffcal_ros.calibration.forward.posture import PostureInputs, RestingPosture
from diffcal_ros.export.effective.run_posture import body_with, changed_material, DIFFERENCE
from diffcal_ros.export.effective.simulators import Swing
from diffcal_ros.export.exported_body import ExportedBody
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.motion.inputs import MotionChange
from diffcal_ros.fem.statics.force_changes import Change, StaticGradient
from diffcal_ros.scene.model import ObservationSetup, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class SwingStates:
    """A body in motion.

    Attributes:
        inputs: what it depends on.
        positions: of its vertices at its frames, world frame [m], shape (S, V, 3).
    """

    inputs: PostureInputs
    positions: FloatArray


class RunMotion:
    """See `calibration.forward.posture.Posture`.

    The body rests on its support by this package's linear elements under the simulator's law,
    which are the simulator's own; from there the simulator has it.

    Attributes:
        body: this package's own, with the shape that cameras trace.
    """

    def __init__(
        self,
        own: MovingPosture,
        scene: Scene,
        setup: ObservationSetup,
        times: Sequence[float],
        body: ExportedBody,
        swing: Swing,
        *,
        difference: float = DIFFERENCE,
    ) -> None:
        """Take what is simulated, and how.

        Args:
            own: of the same body with linear elements.
            scene: with linear elements and the simulator's law.
            setup: the observation.
            times: of its frames, after the first one [s], ascending, shape (S,).
            body: as the simulator is given it, but for the material.
            swing: the simulator.
            difference: half the width of the differences that derivatives are taken by.
        """
        self.body = own.body
        self._times = np.array(times, dtype=np.float64)
        self._supported = RestingPosture(scene, setup, 'auto', 'cpu')
        self._conversion = find_law(scene.law).CONVERSION
        self._exported = body
        self._swing = swing
        self._difference = difference

    def solve(
        self,
        inputs: PostureInputs,
        warm: SwingStates | None = None,
        prediction: FloatArray | None = None,
    ) -> SwingStates:
        """Let the body go, and look at it at its frames."""
        return SwingStates(inputs, self._frames(inputs))

    def tangents(self, states: SwingStates, changes: Sequence[Change]) -> FloatArray:
        """Return how all frames follow changes of material or damping [m], shape (k, S, V, 3).

        Raises:
            NotImplementedError: for a change of something else.
        """
        rates = []
        for change in changes:
            low, high = (
                self._frames(_changed(states.inputs, change, step))
                for step in (-self._difference, self._difference)
            )
            rates.append((high - low) / (2.0 * self._difference))
        return np.array(rates)

    def gradient(self, states: SwingStates, by_positions: FloatArray) -> StaticGradient:
        """Refuse: a simulator that is only run has no adjoint."""
        raise NotImplementedError('a simulator that is run gives no gradient: fit by tangents')

    def mesh_moves(self, states: SwingStates, solver: str) -> FloatArray:
        """Return no move: the mesh that is exported is what the parameters are made for."""
        return np.zeros_like(states.positions)

    def warnings(self, states: SwingStates) -> list[str]:
        """Say nothing: the simulator went on to the last frame, or an error told otherwise."""
        return []

    def _frames(self, inputs: PostureInputs) -> FloatArray:
        material = replace(inputs.material, conversion=self._conversion)
        start = self._supported.solve(replace(inputs, material=material)).positions[0]
        since = self._times - inputs.time_offset - inputs.release_time
        frames = np.repeat(start[None], len(since), axis=0)
        moving = since > 0.0
        if moving.any():
            body = body_with(self._exported, inputs)
            frames[moving] = self._swing(
                replace(body, damping=inputs.damping), start, since[moving]
            )
        return frames


def _changed(inputs: PostureInputs, change: Change, step: float) -> PostureInputs:
    """Return the inputs a step along a change."""
    moved = replace(inputs, material=changed_material(inputs, change, step))
    if not isinstance(change, MotionChange):
        return moved
    if change.mass_damping or change.release_time or change.time_offset:
        raise NotImplementedError(
            'a simulator that is run follows material and damping alone: when the body is let go '
            'stays as the calibration found it'
        )
    if change.damping is None:
        return moved
    return replace(moved, damping=inputs.damping + step * change.damping)
