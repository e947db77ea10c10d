# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a model predicts at some coordinates, and which of that it need not find twice."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from diffcal_ros.calibration.forward.posture import PostureStates
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import DepthTracer
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A search and a fit go back and forth between two places.
_LATEST = 2
# Where the last fit began and where it ended.
_KEPT = 2
# Coordinates that come back from a value in its unit differ by their rounding.
_ROUNDING = 1e-12


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


@dataclass(frozen=True)
class Solution:
    """What a model predicts at some coordinates, and where the next one may start.

    Attributes:
        coordinates: of the parameters, shape (k,).
        states: of each body, by number of the scene's observation.
        views: one an observation.
        tangents: how all states of each body follow the coordinates, world frame [m], shape
            (k, S, N, 3), zero for camera parameters; None: not asked for, see
            `ForwardModel.with_tangents`.
        names: of the parameters; a model with others may start from there.
    """

    coordinates: FloatArray
    states: Mapping[int, PostureStates]
    views: tuple[View, ...]
    tangents: Mapping[int, FloatArray] | None = None
    names: tuple[str, ...] = ()

    def states_only(self) -> 'Solution':
        """Return it without what takes memory and is found from the states."""
        return replace(self, tangents=None, views=())


class KnownSolutions:
    """The states of the latest solutions, and of those that are kept to be shown."""

    def __init__(self) -> None:
        self._latest: deque[Solution] = deque(maxlen=_LATEST)
        self._kept: deque[Solution] = deque(maxlen=_KEPT)

    def add(self, solution: Solution) -> None:
        """Remember a solution until newer ones take its place."""
        self._latest.append(solution.states_only())

    def keep(self, solution: Solution) -> None:
        """Remember a solution until two others are kept."""
        if not any(_are_same(own.coordinates, solution.coordinates) for own in self._kept):
            self._kept.append(solution.states_only())

    def find(self, coordinates: FloatArray) -> Solution | None:
        """Return the solution at some coordinates, shape (k,), without views; None: unknown."""
        for own in (*self._latest, *self._kept):
            if _are_same(own.coordinates, coordinates):
                return own
        return None


def _are_same(one: FloatArray, other: FloatArray) -> bool:
    return bool(np.allclose(one, other, rtol=0.0, atol=_ROUNDING))
