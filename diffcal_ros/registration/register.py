# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find the pose of a stated rigid part in a depth image, or say why it cannot be told."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.registration.agreement import body_merit, merit
from diffcal_ros.registration.held_body import BodyAtRest
from diffcal_ros.registration.rigid_fit import approach, RigidFit, settle
from diffcal_ros.registration.rigid_search import RigidSearch, surface_points
from diffcal_ros.registration.rigid_view import RigidImage
from diffcal_ros.registration.symmetry import PartAxes
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import Fixture, Masks
import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
Tell = Callable[[str], None]

# Poses of one thing that are fitted, and of those that are settled in the end.
_FITTED, _SETTLED = 6, 4
# With less merit the image does not show the part.
_LEAST = 0.6
# Poses that come so near may be the right one as well.
_ALIKE = 0.06
# Poses are different that put the part's surface so far apart, of its size.
_DIFFERENT = 0.06
# Fewer pixels that agree are too few.
_FEWEST = 300
# The body decides where it is met so well, and other poses lose so much.
_MET, _LOST = 0.45, 0.2
# Turns about an axis of revolution that are tried [degrees]; those that lose less may be, too.
_TURN, _TURN_ALIKE = 4.0, 0.1
# A direction is told that is known no better than this [m], [rad].
_LOOSE, _LOOSE_TURN = 0.01, float(np.deg2rad(10.0))
_SAMPLED = 1500


@dataclass(frozen=True)
class RegisteredPart:
    """Where a part is.

    Attributes:
        depth_from_object: shape (4, 4).
        covariance: of a shift of `pivot` [m] and a turn about it [rad], as vectors in the camera's
            frame, shape (6, 6).
        pivot: middle of the part in the camera's frame [m], shape (3,).
        merit: how well the image agrees, 1 at best.
        notes: what a person should know.
        is_only: no other pose came near, nor turn of a part of revolution.
    """

    depth_from_object: FloatArray
    covariance: FloatArray
    pivot: FloatArray
    merit: float
    notes: tuple[str, ...] = ()
    is_only: bool = True


@dataclass(frozen=True)
class _Pose:
    fit: RigidFit
    merit: float

    @property
    def matrix(self) -> FloatArray:
        return self.fit.depth_from_object


def register_part(
    fixture: Fixture,
    depth: NDArray[np.float32],
    camera: PinholeCamera,
    *,
    body: BodyAtRest | None = None,
    masks: Masks | None = None,
    noise: float = 0.0,
    known: RegisteredPart | None = None,
    tell: Tell = lambda _: None,
) -> RegisteredPart:
    """Find a rigid part with no start value.

    Every turn and every measured point is tried coarsely, the best poses are fitted to depth and
    outline, and where several agree alike the body decides, whose root must be where the pose puts
    it.

    Args:
        fixture: the part.
        depth: z [m], shape (H, W), NaN where invalid.
        camera: of the image, without distortion.
        body: what it holds, at rest; None: it is not known.
        masks: pixels to leave out.
        noise: of a pixel, one standard deviation [m].
        known: where it was before; there it is looked for first.
        tell: told what is being done.

    Raises:
        PoseError: when the image does not show it, or does not tell which of several poses it is.
    """
    registration = _Registration(fixture, depth, camera, body, masks or Masks(), noise)
    again = None if known is None else registration.again(known)
    if again is not None:
        return again
    tell('looking for the fixture in the depth image')
    poses = registration.poses()
    registration.require_seen(poses)
    tell('comparing the poses of the fixture that agree best')
    return registration.decided(poses)


class _Registration:
    """One part, one image."""

    def __init__(
        self,
        fixture: Fixture,
        depth: NDArray[np.float32],
        camera: PinholeCamera,
        body: BodyAtRest | None,
        masks: Masks,
        noise: float,
    ) -> None:
        own = None if body is None else (body.positions, body.triangles)
        self._image = RigidImage(fixture, depth, camera, masks, own)
        self._fixture, self._noise, self._camera = fixture, noise, camera
        self._axes = PartAxes(fixture)
        self._points = surface_points(fixture, _SAMPLED)
        self._root = None if body is None else body.root(self._points)
        self._hanging = [] if body is None or self._root is None else body.hanging(self._root)
        self._size = float(np.linalg.norm(np.ptp(fixture.positions, axis=0)))

    def again(self, known: RegisteredPart) -> RegisteredPart | None:
        """Return the part where it was, moved a little; None where that agrees less."""
        fit = settle(self._image, known.depth_from_object) if known.is_only else None
        if fit is None:
            return None
        pose = _Pose(fit, self._merit(fit.depth_from_object))
        return self._result(pose, ()) if pose.merit > known.merit - _ALIKE else None

    def poses(self) -> list[_Pose]:
        """Return fitted poses that differ, the best first."""
        search = RigidSearch(self._fixture, self._image.left, self._camera)
        near = [approach(self._image, own.depth_from_object) for own in search.candidates(_FITTED)]
        ranked = self._ranked(near)
        if not ranked:
            return []
        # What a near symmetry of the part may have hidden from the search.
        others = self._axes.near_symmetric(ranked[0][1], self._fixture)
        ranked = self._ranked(
            [pose for _, pose in ranked] + [approach(self._image, own) for own in others]
        )
        chosen = [pose for value, pose in ranked if value > ranked[0][0] - 2.0 * _ALIKE]
        settled = [settle(self._image, pose) for pose in chosen[: 2 * _SETTLED]]
        found = [_Pose(own, self._merit(own.depth_from_object)) for own in settled if own]
        return self._different(sorted(found, key=lambda own: -own.merit))

    def require_seen(self, poses: Sequence[_Pose]) -> None:
        """Refuse an image that does not show the part.

        Raises:
            PoseError: saying what was found.
        """
        size = ' x '.join(f'{1e3 * own:.0f}' for own in np.ptp(self._fixture.positions, axis=0))
        needed = (
            "the fixture (its CAD must be in the mesh's frame and unit) must be in view, some "
            'hundred pixels of it, with edges that the camera sees before something farther away; '
            'correct the file, film it from nearer, or use a marker'
        )
        if not poses or poses[0].merit < _LEAST:
            best = poses[0].merit if poses else 0.0
            raise PoseError(
                f'nothing in the depth image looks like the fixture of {size} mm (the best pose '
                f'agrees by {best:.2f}, {_LEAST:g} are needed): {needed}'
            )
        if poses[0].fit.pixels < _FEWEST:
            raise PoseError(
                f'only {poses[0].fit.pixels:.0f} pixels show the fixture of {size} mm, {_FEWEST} '
                f'are needed: {needed}'
            )

    def decided(self, poses: Sequence[_Pose]) -> RegisteredPart:
        """Return the pose that image and body leave.

        Raises:
            PoseError: when they leave several.
        """
        alike = [own for own in poses if own.merit > poses[0].merit - _ALIKE]
        free = self._axes.free_axes(alike[0].matrix, self._merit)
        if len(free):
            return self._turned(alike, free)
        if len(alike) == 1:
            return self._result(alike[0], ())
        met = self._met_each([own.matrix for own in alike])
        best = int(np.argmax(met))
        if met[best] < _MET or np.partition(met, -2)[-2] > met[best] - _LOST:
            raise PoseError(self._undecided(len(alike), met))
        note = (
            f'{len(alike)} poses of the fixture agree with the depth image about as well; the '
            'body, which is seen where one of them puts it, decides'
        )
        return self._result(alike[best], (note,))

    def _turned(self, alike: Sequence[_Pose], free: FloatArray) -> RegisteredPart:
        """Let the body decide how a part of revolution is turned."""
        angles = np.deg2rad(np.arange(0.0, 360.0, _TURN))
        bases = self._by_axis(alike, free[0])
        met = self._met_each(
            [self._axes.turned(own.matrix, free[0], angle) for own in bases for angle in angles]
        ).reshape(len(bases), -1)
        row, column = np.unravel_index(int(np.argmax(met)), met.shape)
        best = float(met[row, column])
        away = np.abs((angles - angles[column] + np.pi) % (2.0 * np.pi) - np.pi)
        as_well = met > best - _TURN_ALIKE
        as_well_here = away[as_well[row]]
        elsewhere = np.delete(met, row, axis=0)
        spread = max(float(as_well_here.max()), 0.5 * float(np.deg2rad(_TURN)))
        lost = elsewhere.size and float(elsewhere.max()) > best - _LOST
        if len(free) > 1 or best < _MET or spread > np.deg2rad(30.0) or lost:
            raise PoseError(
                'the fixture looks the same however it is turned about an axis of its own, and '
                f'the body does not tell how it is turned ({self._met_words(met)}): state more of '
                'the fixture, what breaks its symmetry included, let the camera see the body '
                'where it leaves the fixture, or use a marker'
            )
        # As many turns to one side as to the other agree.
        middle = float(_signed(angles, angles[column])[as_well[row]].mean())
        pose = self._axes.turned(bases[row].matrix, free[0], float(angles[column]) + middle)
        axis = pose[:3, :3] @ free[0]
        arm = apply(pose, self._image.pivot) - apply(pose, self._axes.middle)
        way = np.concatenate([np.cross(axis, arm), axis])
        fit = replace(
            bases[row].fit,
            depth_from_object=pose,
            covariance=bases[row].fit.covariance + spread**2 * np.outer(way, way),
        )
        note = (
            'the fixture looks the same however it is turned about an axis of its own; the body '
            f'tells the turn to {np.rad2deg(spread):.0f} degrees'
        )
        return self._result(replace(bases[row], fit=fit), (note,))

    def _by_axis(self, alike: Sequence[_Pose], axis: FloatArray) -> list[_Pose]:
        """Return one pose for each direction of the axis."""
        kept: list[_Pose] = []
        for own in alike:
            directions = [other.matrix[:3, :3] @ axis for other in kept]
            if all(own.matrix[:3, :3] @ axis @ other < 0.95 for other in directions):
                kept.append(own)
        # Turned end for end it may look the same, and the search need not have found both.
        if len(kept) == 1:
            for other in self._axes.near_symmetric(kept[0].matrix, self._fixture):
                if kept[0].matrix[:3, :3] @ axis @ (other[:3, :3] @ axis) > -0.99:
                    continue
                pose = approach(self._image, other)
                fit = None if pose is None else settle(self._image, pose)
                value = 0.0 if fit is None else self._merit(fit.depth_from_object)
                if fit is not None and value > kept[0].merit - _ALIKE:
                    kept.append(_Pose(fit, value))
                break
        return kept

    def _result(self, pose: _Pose, notes: tuple[str, ...]) -> RegisteredPart:
        fit = pose.fit
        spread = np.sqrt(
            [np.linalg.eigvalsh(fit.covariance[own, own])[-1] for own in (_SHIFT, _SPIN)]
        )
        told: tuple[str, ...] = (
            f'pose of the fixture from {fit.pixels:.0f} pixels, known to {1e3 * spread[0]:.2g} mm '
            f'and {np.rad2deg(spread[1]):.2g} degrees',
        )
        if spread[0] > _LOOSE or spread[1] > _LOOSE_TURN:
            told = (
                *told,
                'that leaves a direction open: fit rigid_offset as well, or let the camera see '
                'more of the fixture and its edges',
            )
        return RegisteredPart(
            fit.depth_from_object,
            fit.covariance,
            apply(fit.depth_from_object, self._image.pivot),
            pose.merit,
            (*told, *notes),
            is_only=not notes,
        )

    def _merit(self, pose: FloatArray) -> float:
        return merit(self._image, pose, self._noise)

    def _met(self, pose: FloatArray) -> float:
        """Return how well the body's root is met; less than enough where that is not seen."""
        if self._root is None:
            return 0.0
        found = body_merit(self._image, pose, self._root)
        return 0.0 if np.isnan(found) else found

    def _met_each(self, poses: Sequence[FloatArray]) -> FloatArray:
        """Return how well the body is met at each pose: its root, and how it hangs from there."""
        root = np.array([self._met(own) for own in poses])
        near = np.flatnonzero(root > root.max() - _LOST)
        if len(near) < 2 or root.max() < _MET or not self._hanging:
            return root
        return np.array(
            [
                own * self._hangs(pose) if number in near else 0.0
                for number, (own, pose) in enumerate(zip(root, poses, strict=True))
            ]
        )

    def _hangs(self, pose: FloatArray) -> float:
        """Return how well the body is met that hangs along gravity, as far as suits it."""
        assert self._root is not None
        everything = np.ones_like(self._root)
        found = [body_merit(self._image, pose, everything, own) for own in self._hanging]
        return float(np.nan_to_num(found).max())

    def _ranked(self, poses: Sequence[FloatArray | None]) -> list[tuple[float, FloatArray]]:
        """Return poses that differ with their merits, the best first."""
        valued = [(self._merit(own), own) for own in poses if own is not None]
        kept: list[tuple[float, FloatArray]] = []
        for value, own in sorted(valued, key=lambda one: -one[0]):
            if all(self._is_other(own, other) for _, other in kept):
                kept.append((value, own))
        return kept

    def _different(self, poses: Sequence[_Pose]) -> list[_Pose]:
        kept: list[_Pose] = []
        for own in poses:
            if all(self._is_other(own.matrix, other.matrix) for other in kept):
                kept.append(own)
        return kept

    def _is_other(self, first: FloatArray, second: FloatArray) -> bool:
        some = self._points[::20]
        apart = np.linalg.norm(apply(first, some) - apply(second, some), axis=1).mean()
        return bool(apart > _DIFFERENT * self._size)

    def _undecided(self, count: int, met: FloatArray) -> str:
        return (
            f'{count} poses of the fixture agree with the depth image about as well, and the body '
            f'does not tell which it is ({self._met_words(met)}): state more of the fixture, what '
            'breaks its symmetry included, let the camera see the body where it leaves the '
            'fixture and hangs from there, or use a marker'
        )

    def _met_words(self, met: FloatArray) -> str:
        if self._root is None:
            return 'no body is known'
        best = ', '.join(f'{own:.2f}' for own in np.sort(met.ravel())[::-1][:2])
        return f'it is met by {best} at best'


_SHIFT, _SPIN = slice(0, 3), slice(3, 6)


def _signed(angles: FloatArray, middle: float) -> FloatArray:
    return (angles - middle + np.pi) % (2.0 * np.pi) - np.pi
