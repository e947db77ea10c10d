# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What every integrator offers to a moving body."""

from collections.abc import Callable, Sequence
from typing import Protocol

from diffcal_ros.fem.motion.frame_reader import FrameReader
from diffcal_ros.fem.motion.gradient_sum import GradientSum
from diffcal_ros.fem.motion.held_nodes import HeldState
from diffcal_ros.fem.motion.path import Path
from diffcal_ros.fem.statics.force_changes import Change
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# Held nodes at a time since the start [s].
HeldAt = Callable[[float], HeldState]
# How held nodes follow each change at a time since the start; None: they do not.
HeldChanges = Callable[[float], Sequence[HeldState | None]]
# Takes the derivative by positions and velocities of held nodes at a time since the start.
ByHeld = Callable[[float, FloatArray, FloatArray], None]


class Integrator(Protocol):
    """Marches from rest; keeps what its derivatives need until the next march."""

    name: str

    @property
    def step_count(self) -> int:
        """Number of steps of the last march."""

    @property
    def halvings(self) -> int:
        """How often a step of the last march had to be halved."""

    @property
    def rungs(self) -> tuple[int, ...]:
        """How often each step of the last march halves the longest one; empty if all alike."""

    @property
    def step_errors(self) -> FloatArray:
        """What each step of the last march is off by [m]; empty where that is not known."""

    @property
    def path(self) -> Path | None:
        """Where the last march went; None where that is not kept."""

    def march(
        self,
        start: FloatArray,
        stamps: FloatArray,
        held_at: HeldAt,
        rungs: Sequence[int] | None = None,
        near: Path | None = None,
    ) -> FrameReader:
        """March from positions (N, 3) [m] through stamps since the start [s], shape (F,).

        Args:
            start: positions at rest [m], shape (N, 3).
            stamps: since the start [s], shape (F,).
            held_at: held nodes.
            rungs: of the steps to take, such as those of an earlier march; None: chosen anew.
            near: a motion that this one is like, from which implicit steps are sought.

        Returns:
            Frames of shape (F, N, 3) and their derivative by time.

        Raises:
            MotionError: when the motion does not go on.
        """

    def tangents(
        self, changes: Sequence[Change], start: FloatArray, held_changes: HeldChanges
    ) -> FloatArray:
        """Return how the frames follow changes [m], shape (k, F, N, 3).

        Args:
            changes: of the inputs.
            start: how the positions at the start follow them [m], shape (k, N, 3).
            held_changes: how held nodes do.
        """

    def gradient(
        self, by_frames: FloatArray, by_held: ByHeld | None
    ) -> tuple[GradientSum, FloatArray]:
        """Pull a derivative by the frames [1/m], shape (F, N, 3), back to the inputs.

        Args:
            by_frames: derivative of a scalar by the frames.
            by_held: takes the derivative by held nodes; None: nobody asks.

        Returns:
            Sums for the gradient by the inputs, and the derivative by the positions at the
            start, shape (N, 3).
        """
