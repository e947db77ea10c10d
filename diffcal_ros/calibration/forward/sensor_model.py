# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a depth camera reads a surface, and what of that surface its errors may depend on."""

from dataclasses import dataclass

from diffcal_ros.depth.trace import Trace
from diffcal_ros.effects import bands
from diffcal_ros.effects.effect import Numbers
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.effects.site import SeenPixels
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class SensorModel:
    """How a depth camera reads a true depth.

    Attributes:
        errors: effects that make it read wrong, with their amplitudes.
    """

    errors: tuple[tuple[str, Numbers], ...] = ()

    @property
    def is_exact(self) -> bool:
        """Tell whether it reads what is there."""
        return not self.errors

    def reading(self, seen: SeenPixels) -> FloatArray:
        """Return what is read [m] of pixels and their true depths."""
        read = seen.depth
        for identifier, own in self.errors:
            effect = EFFECTS[identifier]
            for part in effect.parts:
                amplitude = own.get(part.name, 0.0)
                mode = effect.depth_error_mode(part.name, seen) if amplitude else None
                if mode is not None:
                    read = read + amplitude * mode
        return read


EXACT_SENSOR = SensorModel()


@dataclass(frozen=True)
class SurfacePlaces:
    """What is where on a surface.

    Attributes:
        is_second: triangles of another material than the first, shape (F,).
        places: of the triangles on the body at rest, see `BodyAxes.places`, shape (F, 3); None:
            they are none of a body.
        shares: how far along the free part the corners of the triangles are, shape (F, 3); None:
            they are none of a body, or its materials end where elements do.
        borders: where materials end along it, see `bands`; empty: where elements do.
    """

    is_second: NDArray[np.bool_]
    places: FloatArray | None = None
    shares: FloatArray | None = None
    borders: tuple[float, ...] = ()

    def seen(
        self, trace: Trace, directions: FloatArray, pixels: NDArray[np.int32] | None = None
    ) -> SeenPixels:
        """Return pixels as errors of a sensor see them.

        Args:
            trace: of the view.
            directions: in which its pixels are seen, see `SeenPixels`, shape (h, w, 2).
            pixels: flat indices into the window, shape (M,); None: all, of shape (h, w).
        """
        depth, faces = trace.depth, trace.faces
        if pixels is not None:
            depth, faces = depth.ravel()[pixels], faces.ravel()[pixels]
            directions = directions.reshape(-1, 2)[pixels]
        shown = np.maximum(faces, 0)
        places = None if self.places is None else self.places[shown]
        is_second = self.is_second[shown]
        if self.borders:
            on = faces >= 0
            shares = self.shares_at(trace, faces[on], directions[on])
            is_second[on] = bands.is_between(shares, self.borders)
        return SeenPixels(depth, is_second, places, directions, trace.facing[shown])

    def shares_at(
        self, trace: Trace, faces: NDArray[np.int32], directions: FloatArray
    ) -> FloatArray:
        """Return how far along the free part pixels see the body, shape (n,).

        Args:
            trace: of the view.
            faces: triangle that each shows, shape (n,).
            directions: in which each is seen, shape (n, 2).
        """
        assert self.shares is not None
        weights = trace.corner_weights(faces, directions)
        return np.asarray((self.shares[faces] * weights).sum(axis=1))
