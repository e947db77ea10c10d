# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What effects may know of the body, of its pixels, and of the fit they are missing from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from diffcal_ros.effects import bands
from diffcal_ros.fem.body_axes import BodyAxes
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Site:
    """The body in one posture.

    Attributes:
        object_axes: the body's axes in the object frame.
        world_from_object: shape (4, 4).
        rest_nodes: at rest, world frame [m], shape (N, 3).
        stated_gravity: as the scene has it [m/s^2], world frame, shape (3,).
        gravity: as it acts, shape (3,).
        pivot: a point at the body of all postures, world frame [m], shape (3,); the origin where
            that is near.
        camera_pivot: about which the camera's offset turns, in its frame [m], shape (3,).
    """

    object_axes: BodyAxes
    world_from_object: FloatArray
    rest_nodes: FloatArray
    stated_gravity: FloatArray
    gravity: FloatArray
    pivot: FloatArray
    camera_pivot: FloatArray | None = None

    @cached_property
    def axes(self) -> BodyAxes:
        """The body's axes in the world frame."""
        return self.object_axes.placed(self.world_from_object)

    def to_world(self, vectors: FloatArray) -> FloatArray:
        """Turn vectors of the object frame into the world frame, shape (..., 3)."""
        return vectors @ self.world_from_object[:3, :3].T

    def weights_at(self, at: float, width: float) -> FloatArray:
        """Return weights of the free nodes around a place; they sum to one, shape (N,).

        Args:
            at: share of the free length.
            width: standard deviation, as a share of it.
        """
        fraction = self.axes.fraction(self.rest_nodes)
        weights: FloatArray = np.exp(-0.5 * ((fraction - at) / width) ** 2)
        weights[fraction == 0.0] = 0.0
        return weights / weights.sum()


@dataclass(frozen=True)
class Tets:
    """The body's tetrahedra.

    Attributes:
        fraction: how far along the free part each is, 0 at the clamp, 1 at the tip, shape (T,).
        is_second: which are of another region than the first, shape (T,); None: there is one.
    """

    fraction: FloatArray
    is_second: BoolArray | None

    def second(self, settings: Mapping[str, float]) -> BoolArray:
        """Tell which are of another material than the first, shape (T,).

        Args:
            settings: where a scene of one region has its borders, see `bands`.
        """
        return (
            bands.is_second(self.fraction, settings) if self.is_second is None else self.is_second
        )


@dataclass(frozen=True)
class SeenPixels:
    """Pixels that show the body.

    Attributes:
        depth: true one, or what a model leaves of it [m].
        is_second: which show another material than the first, as `depth`.
        directions: in which they are seen, x / z and y / z, shape (..., 2); None: nobody asks.
        facing: cosine of the angle at which the surface is met, as `depth`; None: nobody asks.
        sides: which way the surface of the body at rest faces: its unit normal by the body's axes
            across it, shape (..., 2); None: they show something else, or nobody asks.
        locate: finds `places`; None: likewise.
        parts: in which parts of the surface they are, see `surface_parts`, shape (..., p); None:
            materials end where regions do, or nobody asks.
        times: how many times as much each part adds as the first, shape (p,).
        beyond: by how much they are beyond an edge in the picture, 0 to 1, as `depth`; None:
            there is no edge, or nobody asks.
    """

    depth: FloatArray
    is_second: BoolArray
    directions: FloatArray | None = None
    facing: FloatArray | None = None
    sides: FloatArray | None = None
    locate: Callable[[], FloatArray] | None = None
    parts: BoolArray | None = None
    times: FloatArray | None = None
    beyond: FloatArray | None = None

    @cached_property
    def places(self) -> FloatArray | None:
        """Where on the body at rest they are, see `BodyAxes.on_surface`, shape (..., 3).

        None: they show something else, or nobody asks.
        """
        return None if self.locate is None else self.locate()


class FitsSeen(Protocol):
    """The nominal fit as effects see it that propose starts.

    Attributes:
        begin: its parameters where it began, by name.
        end: where it ended.
    """

    begin: Mapping[str, float]
    end: Mapping[str, float]

    def heights(self, at: float | None) -> list[FloatArray]:
        """Return how high the body's surface is in each view, in the world [m], (n,) each.

        Args:
            at: share of the free length around which; None: all of the surface.
        """

    def residuals(self, values: Mapping[str, float]) -> list[SeenPixels]:
        """Return what each view leaves at some parameters; none where they are not simulated."""
