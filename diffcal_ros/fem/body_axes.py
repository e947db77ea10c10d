# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body's own axes: along it from the clamp to the tip, and across it."""

from dataclasses import dataclass, replace

from diffcal_ros.errors import InputError
from diffcal_ros.fem.body_line import body_line, BodyLine, is_branched
from diffcal_ros.fem.load_path import load_path
from diffcal_ros.rigid_transform import apply
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# Where sections of a body are known, as shares of its free length: its ends may lean to them.
_STATIONS = np.linspace(0.03, 0.97, 25)
# Of its extent along its axis: less than this beyond a clamp is no free end, and more than that
# behind one is a second arm.
_NO_END, _TWO_ARMS = 0.05, 0.25
# So many times as long as it reaches along its axis is the line of a body that is bent.
_BENT = 1.05


@dataclass(frozen=True)
class BodyAxes:
    """A slender body's frame at rest.

    Attributes:
        root: where the free part begins, in the middle of the section [m], shape (3,): at the
            clamp, or at one end of a body that is held at both ends or amid its length.
        axes: unit rows: along the body away from the clamp, then across it, the wider side
            first, shape (3, 3).
        length: of the free part along the first axis [m].
        center: middle of the held part [m], shape (3,).
        section: unit rows: across the section where the clamp ends, towards the free part, then
            within it, the wider side first, shape (3, 3).
        line: which a bent body follows, in the frame of these axes; None: it follows its axis.
    """

    root: FloatArray
    axes: FloatArray
    length: float
    center: FloatArray
    section: FloatArray
    line: BodyLine | None = None

    @property
    def at_root(self) -> FloatArray:
        """Unit rows as `axes`, but as the body goes on where its free part begins."""
        return self.axes if self.line is None else self.line.frames[0] @ self.axes

    def own(self, points: FloatArray) -> FloatArray:
        """Return points in the frame of the axes [m], shape (n, 3)."""
        return np.asarray((points - self.root) @ self.axes.T)

    def fraction(self, points: FloatArray) -> FloatArray:
        """Return how far along the free part points are, 0 at the clamp, 1 at the tip."""
        if self.line is not None:
            return self.line.fraction(self.own(points))
        return np.clip((points - self.root) @ self.axes[0] / self.length, 0.0, 1.0)

    def across(self, points: FloatArray, extent: FloatArray) -> FloatArray:
        """Return how far across the section points are, in units of half widths, shape (n, 2).

        Args:
            points: at rest [m], shape (n, 3).
            extent: points that are as wide as the body [m], shape (N, 3).
        """
        across, whole = (self._beside(own) for own in (points, extent))
        return np.asarray(across / np.abs(whole).max(axis=0))

    def _beside(self, points: FloatArray) -> FloatArray:
        """Return how far across the body points are [m], shape (n, 2)."""
        own = self.own(points)
        return own[:, 1:] if self.line is None else self.line.across(own, self.fraction(points))

    def places(self, points: FloatArray, extent: FloatArray) -> FloatArray:
        """Return where on the body points are: how far along its free part, and across, (n, 3).

        Args:
            points: see `across`.
            extent: see `across`.
        """
        return np.column_stack([self.fraction(points), self.across(points, extent)])

    def on_surface(self, points: FloatArray, triangles: NDArray[np.int32]) -> FloatArray:
        """Return where on the body the corners of triangles are, shape (F, 3, 3).

        How far along its free part, and how far across the section there, in half widths of that,
        whose middle need not be on the axis: what goes along a bent or waisted body does not
        change its place across.

        Args:
            points: nodes at rest [m], shape (N, 3).
            triangles: of the surface, shape (F, 3).
        """
        if self.line is None:
            along = (points - self.root) @ self.axes[0] / self.length
        else:
            along = self.fraction(points)
        own = np.column_stack([along, self._beside(points)])
        low, high = _sections(own, triangles)
        along = np.clip(own[:, 0], 0.0, 1.0)
        for way in (0, 1):
            ends = [np.interp(along, _STATIONS, side[:, way]) for side in (low, high)]
            middle, half = 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])
            across = (own[:, 1 + way] - middle) / np.maximum(half, 1e-9)
            own[:, 1 + way] = np.clip(across, -1.0, 1.0)
        own[:, 0] = along
        return own[triangles]

    def sides(self, points: FloatArray, triangles: NDArray[np.int32]) -> FloatArray:
        """Return which way triangles face: what of their unit normals is across, shape (F, 2).

        Args:
            points: at rest [m], shape (N, 3).
            triangles: outward ones, shape (F, 3).
        """
        a, b, c = (points[triangles[:, corner]] for corner in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        if self.line is None:
            return np.asarray(normals @ self.axes[1:].T)
        ways = self.line.frame(self.fraction((a + b + c) / 3.0))[:, 1:] @ self.axes
        return np.einsum('nij,nj->ni', ways, normals)

    def moved(self, shift: FloatArray) -> 'BodyAxes':
        """Return the axes of a body that is shifted [m], shape (3,)."""
        return replace(self, root=self.root + shift, center=self.center + shift)

    def placed(self, to_from_here: FloatArray) -> 'BodyAxes':
        """Return the axes of a body that is moved to another frame, shape (4, 4)."""
        return replace(
            self,
            root=apply(to_from_here, self.root),
            axes=self.axes @ to_from_here[:3, :3].T,
            center=apply(to_from_here, self.center),
            section=self.section @ to_from_here[:3, :3].T,
        )


def _sections(points: FloatArray, triangles: NDArray[np.int32]) -> tuple[FloatArray, FloatArray]:
    """Return from where to where a surface reaches across at stations along it, (s, 2) each.

    Args:
        points: how far along its free part, and across, shape (N, 3).
        triangles: of the surface, shape (F, 3).
    """
    pairs = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]))
    first, second = points[np.unique(pairs, axis=0)].transpose(1, 0, 2)
    way = second[:, :1] - first[:, :1]
    shares = (_STATIONS - first[:, :1]) / np.where(way == 0.0, np.inf, way)
    is_met = (shares >= 0.0) & (shares <= 1.0) & (way != 0.0)
    across = first[:, None, 1:] + shares[..., None] * (second - first)[:, None, 1:]
    whole = points[:, 1:].min(axis=0), points[:, 1:].max(axis=0)
    low = np.where(is_met[..., None], across, np.inf).min(axis=0)
    high = np.where(is_met[..., None], across, -np.inf).max(axis=0)
    is_none = ~is_met.any(axis=0)[:, None]
    return np.where(is_none, whole[0], low), np.where(is_none, whole[1], high)


def body_axes(
    rest: FloatArray,
    held: NDArray[np.int32],
    border: NDArray[np.int32] | None = None,
    mesh: TetMesh | None = None,
) -> BodyAxes:
    """Find the axes of a clamped body.

    Args:
        rest: nodes at rest [m], shape (N, 3).
        held: indices of the held ones.
        border: those of them where the clamp ends; None: all.
        mesh: whose vertices the nodes are, along which the line of a bent body is looked for;
            None: it is taken for straight.

    Raises:
        InputError: when nothing is left to deform.
    """
    if len(held) == len(rest):
        raise InputError(
            f'all {len(rest)} nodes are held, by the clamp and what supports the body until it is '
            'let go: leave some of them free to deform'
        )
    free = np.delete(rest, held, axis=0)
    middle = free.mean(axis=0)
    # Fewer than three points have fewer rows than a frame needs, unless all are asked for.
    _, _, axes = np.linalg.svd(free - middle, full_matrices=len(free) < 3)
    section = _section_axes(rest[held if border is None else border], middle)
    found = _along(rest, held, middle, axes, section)
    if mesh is None:
        return found
    is_amid = _is_amid(rest @ found.axes[0], held)
    line = body_line(found.own(rest), mesh, held, is_amid=is_amid)
    if line is None and not is_amid and is_branched(mesh, held):
        path = load_path(mesh, held)
        if path is None:
            return found
        frame = _axes_by(path.way, free - path.middle)
        return _along(rest, held, path.middle, frame, section)
    if line is None or line.length < _BENT * np.ptp(line.middles[:, 0]):
        return found
    return replace(found, length=line.length, line=line)


def _along(
    rest: FloatArray,
    held: NDArray[np.int32],
    middle: FloatArray,
    axes: FloatArray,
    section: FloatArray,
) -> BodyAxes:
    """Return the axes of a body that goes straight through a point, along the first of some axes.

    Args:
        rest: nodes at rest [m], shape (N, 3).
        held: indices of the held ones.
        middle: point of the axis [m], shape (3,).
        axes: unit rows, of either sign, shape (3, 3).
        section: where the clamp ends, see `BodyAxes`.
    """
    own, axes = rest[held], axes.copy()
    center = 0.5 * (own.min(axis=0) + own.max(axis=0))
    # Signs that do not depend on the mesh: along away from the clamp, across towards larger
    # coordinates, and right-handed.
    if (middle - center) @ axes[0] < 0.0:
        axes[0] *= -1.0
    if axes[1][np.argmax(np.abs(axes[1]))] < 0.0:
        axes[1] *= -1.0
    axes[2] = np.cross(axes[0], axes[1])
    along = rest @ axes[0]
    begin, end = float(along[held].max()), float(along.max())
    # Held at both ends, or amid its length: from one end of what is free to the other one.
    if _is_amid(along, held):
        begin, end = float(np.delete(along, held).min()), float(np.delete(along, held).max())
    root = middle + (begin - middle @ axes[0]) * axes[0]
    return BodyAxes(root, axes, max(end - begin, 1e-9), center, section)


def _is_amid(along: FloatArray, held: NDArray[np.int32]) -> bool:
    """Tell whether a body is held at both ends, or goes on to both sides of its clamp.

    Args:
        along: how far along its axis nodes are [m], shape (N,).
        held: indices of the held ones.
    """
    begin, end = float(along[held].max()), float(along.max())
    behind, extent = float(along[held].min() - along.min()), float(np.ptp(along))
    return end - begin < _NO_END * extent or behind > _TWO_ARMS * extent


def _axes_by(way: FloatArray, points: FloatArray) -> FloatArray:
    """Return unit rows: a way, and across it, the direction first in which points are spread."""
    beside = points - np.outer(points @ way, way)
    _, _, axes = np.linalg.svd(beside, full_matrices=len(points) < 3)
    across = axes[0] - (axes[0] @ way) * way
    across /= np.linalg.norm(across)
    return np.stack([way, across, np.cross(way, across)])


def _section_axes(points: FloatArray, free: FloatArray) -> FloatArray:
    """Return axes of a flat set of points [m], shape (n, 3), the first towards another point."""
    middle = points.mean(axis=0)
    _, axes = np.linalg.eigh((points - middle).T @ (points - middle))
    across, narrow, wide = axes.T
    return np.stack([across if (free - middle) @ across > 0.0 else -across, wide, narrow])
