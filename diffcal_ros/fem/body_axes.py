# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body's own axes: along it from the clamp to the tip, and across it."""

from dataclasses import dataclass, replace

from diffcal_ros.errors import InputError
from diffcal_ros.rigid_transform import apply
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class BodyAxes:
    """A slender body's frame at rest.

    Attributes:
        root: where the free part begins, in the middle of the section [m], shape (3,).
        axes: unit rows: along the body away from the clamp, then across it, the wider side
            first, shape (3, 3).
        length: of the free part along the first axis [m].
        center: middle of the held part [m], shape (3,).
        section: unit rows: across the section where the clamp ends, towards the free part, then
            within it, the wider side first, shape (3, 3).
    """

    root: FloatArray
    axes: FloatArray
    length: float
    center: FloatArray
    section: FloatArray

    def fraction(self, points: FloatArray) -> FloatArray:
        """Return how far along the free part points are, 0 at the clamp, 1 at the tip."""
        return np.clip((points - self.root) @ self.axes[0] / self.length, 0.0, 1.0)

    def across(self, points: FloatArray, extent: FloatArray) -> FloatArray:
        """Return how far across the section points are, in units of half widths, shape (n, 2).

        Args:
            points: at rest [m], shape (n, 3).
            extent: points that are as wide as the body [m], shape (N, 3).
        """
        across, whole = ((own - self.root) @ self.axes[1:].T for own in (points, extent))
        return np.asarray(across / np.abs(whole).max(axis=0))

    def places(self, points: FloatArray, extent: FloatArray) -> FloatArray:
        """Return where on the body points are: how far along its free part, and across, (n, 3).

        Args:
            points: see `across`.
            extent: see `across`.
        """
        return np.column_stack([self.fraction(points), self.across(points, extent)])

    def moved(self, shift: FloatArray) -> 'BodyAxes':
        """Return the axes of a body that is shifted [m], shape (3,)."""
        return replace(self, root=self.root + shift, center=self.center + shift)

    def placed(self, to_from_here: FloatArray) -> 'BodyAxes':
        """Return the axes of a body that is moved to another frame, shape (4, 4)."""
        return BodyAxes(
            root=apply(to_from_here, self.root),
            axes=self.axes @ to_from_here[:3, :3].T,
            length=self.length,
            center=apply(to_from_here, self.center),
            section=self.section @ to_from_here[:3, :3].T,
        )


def body_axes(
    rest: FloatArray, held: NDArray[np.int32], border: NDArray[np.int32] | None = None
) -> BodyAxes:
    """Find the axes of a clamped body.

    Args:
        rest: nodes at rest [m], shape (N, 3).
        held: indices of the held ones.
        border: those of them where the clamp ends; None: all.

    Raises:
        InputError: when nothing is left to deform.
    """
    if len(held) == len(rest):
        raise InputError(
            f'all {len(rest)} nodes are held, by the clamp and what supports the body until it is '
            'let go: leave some of them free to deform'
        )
    own = rest[held]
    center = 0.5 * (own.min(axis=0) + own.max(axis=0))
    free = np.delete(rest, held, axis=0)
    middle = free.mean(axis=0)
    # Fewer than three points have fewer rows than a frame needs, unless all are asked for.
    _, _, axes = np.linalg.svd(free - middle, full_matrices=len(free) < 3)
    # Signs that do not depend on the mesh: along away from the clamp, across towards larger
    # coordinates, and right-handed.
    if (middle - center) @ axes[0] < 0.0:
        axes[0] *= -1.0
    if axes[1][np.argmax(np.abs(axes[1]))] < 0.0:
        axes[1] *= -1.0
    axes[2] = np.cross(axes[0], axes[1])
    along = rest @ axes[0]
    begin, end = float(along[held].max()), float(along.max())
    if end - begin < 0.05 * float(np.ptp(along)):  # Held at both ends.
        begin, end = float(np.delete(along, held).min()), float(np.delete(along, held).max())
    root = middle + (begin - middle @ axes[0]) * axes[0]
    return BodyAxes(
        root=root,
        axes=axes,
        length=max(end - begin, 1e-9),
        center=center,
        section=_section_axes(own if border is None else rest[border], middle),
    )


def _section_axes(points: FloatArray, free: FloatArray) -> FloatArray:
    """Return axes of a flat set of points [m], shape (n, 3), the first towards another point."""
    middle = points.mean(axis=0)
    _, axes = np.linalg.eigh((points - middle).T @ (points - middle))
    across, narrow, wide = axes.T
    return np.stack([across if (free - middle) @ across > 0.0 else -across, wide, narrow])
