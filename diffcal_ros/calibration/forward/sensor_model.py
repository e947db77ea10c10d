# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a depth camera reads a surface, and what of that surface its errors may depend on."""

from dataclasses import dataclass
from functools import cache

from diffcal_ros.depth.trace import Trace
from diffcal_ros.effects.effect import Numbers
from diffcal_ros.effects.picture_edge import PictureEdge
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.effects.site import SeenPixels
from diffcal_ros.effects.surface_parts import SeenPart
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
        corners: where on the body at rest those of the triangles are, see `BodyAxes.on_surface`,
            shape (F, 3, 3); None: they are none of a body.
        sides: which way the triangles face, see `SeenPixels`, shape (F, 2); None: likewise.
        parts: of the second material; empty: it is where elements are of it.
        edge: in the picture; None: there is none.
    """

    is_second: NDArray[np.bool_]
    corners: FloatArray | None = None
    sides: FloatArray | None = None
    parts: tuple[SeenPart, ...] = ()
    edge: PictureEdge | None = None

    @property
    def places(self) -> FloatArray | None:
        """Where the middles of the triangles are, as `corners`, shape (F, 3)."""
        return None if self.corners is None else self.corners.mean(axis=1)

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
        is_second, on = self.is_second[shown], faces >= 0

        @cache
        def locate() -> FloatArray:
            places = np.zeros((*faces.shape, 3))
            places[on] = self.places_at(trace, faces[on], directions[on])
            return places

        parts = None
        if self.parts:
            parts = np.stack([own.holds(locate()) for own in self.parts], axis=-1)
            parts &= on[..., None]
            is_second = np.asarray(parts.any(axis=-1))
        return SeenPixels(
            depth,
            is_second,
            directions,
            trace.facing[shown],
            None if self.sides is None else self.sides[shown],
            None if self.corners is None else locate,
            parts,
            np.array([own.times for own in self.parts]),
            None if self.edge is None else self.edge.beyond(directions),
        )

    def places_at(
        self, trace: Trace, faces: NDArray[np.int32], directions: FloatArray
    ) -> FloatArray:
        """Return where on the body at rest pixels see it, see `BodyAxes.on_surface`, shape (n, 3).

        Args:
            trace: of the view.
            faces: triangle that each shows, shape (n,).
            directions: in which each is seen, shape (n, 2).
        """
        assert self.corners is not None
        weights = trace.corner_weights(faces, directions)
        return np.einsum('nck,nc->nk', self.corners[faces], weights)
