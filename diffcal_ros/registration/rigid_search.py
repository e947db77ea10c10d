# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where in a depth image a rigid part may be: every turn and every measured point at first.

As `proposal.place_search` looks for a body, but with no gravity that leaves one turn open only.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.registration.image_score import ImageScore
from diffcal_ros.registration.rotations import spread_rotations
from diffcal_ros.registration.surface_sample import ShapeSample, spread, spread_over
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.scene.model import Fixture
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Counts = tuple[int, int]

# The thinned image is about so wide [px], and again when places are looked at closely.
_COARSE, _FINE = 128, 320
_TURNS = 1500
# Points of the surface and beside it: for a first look, for all places, and closely.
_FIRST, _COARSELY, _CLOSELY = 14, (60, 40), (220, 160)
_SAMPLED = 60
# After the first look this share of the places is left.
_KEPT = 0.1
# So many places are looked at, evenly among things that depth parts from each other by this share
# of the size.
_MOST_PLACES, _JUMP = 1200, 0.15
# Things of fewer pixels of the thinned image are none.
_SPECK = 25
# Depths that differ by less are the same: a share of the part's size, within bounds [m].
_SAME, _LEAST, _MOST = 0.12, 0.003, 0.008
# Poses whose points lie nearer than this share of the size are one.
_APART = 0.12
_CLOSER = 90
# First steps, of the size and in radians, and how often they are halved.
_SHIFT, _TURN, _HALVINGS, _ROUNDS = 0.1, float(np.deg2rad(9.0)), 3, 5
# It is drawn so many pixels large into a picture of that side, and the space so far beside it is
# looked at [px].
_DRAWN, _CANVAS, _BESIDE = 60.0, 120, (1.6, 3.2)
_NONE = np.zeros((0, 3))


@dataclass(frozen=True)
class RigidCandidate:
    """A pose of the part.

    Attributes:
        depth_from_object: shape (4, 4).
        score: how well the image agrees, 1 at best.
    """

    depth_from_object: FloatArray
    score: float


class RigidSearch:
    """Looks for one rigid part in one depth image."""

    def __init__(
        self, fixture: Fixture, depth: NDArray[np.float32], camera: PinholeCamera
    ) -> None:
        """Thin the image and choose points on the part.

        Args:
            fixture: the part.
            depth: z [m], shape (H, W), NaN where invalid or left out.
            camera: of the image.
        """
        self._positions, self._triangles = fixture.positions, fixture.triangles
        self.middle = 0.5 * (fixture.positions.min(axis=0) + fixture.positions.max(axis=0))
        self._points = surface_points(fixture, _SAMPLED)
        self.size = float(np.linalg.norm(np.ptp(fixture.positions, axis=0)))
        self._coarse = ImageScore(depth, camera, max(1, round(camera.width / _COARSE)))
        self._fine = ImageScore(depth, camera, max(1, round(camera.width / _FINE)))
        chosen, self._things = balanced(self._coarse.depth, _JUMP * self.size, _MOST_PLACES)
        self._places = self._coarse.surface_points()[chosen]
        self._tolerance = float(np.clip(_SAME * self.size, _LEAST, _MOST))

    def candidates(self, count: int) -> list[RigidCandidate]:
        """Return the best poses on each thing in view, the best first.

        Args:
            count: of poses of one thing at most.
        """
        found: list[list[RigidCandidate]] = [[] for _ in np.unique(self._things)]
        if not len(found):
            return []
        for own in self._anywhere():
            for thing, candidate in own.items():
                found[thing].append(candidate)
        closer = max(_CLOSER // len(found), count)
        best: list[RigidCandidate] = []
        for poses in found:
            chosen = self.apart(sorted(poses, key=lambda own: -own.score), closer)
            near = sorted((self._closer(own) for own in chosen), key=lambda own: -own.score)
            best += self.apart(near, count)
        return sorted(best, key=lambda own: -own.score)

    def apart(self, candidates: list[RigidCandidate], most: int) -> list[RigidCandidate]:
        """Return candidates, the best first, without those that are nearly the same pose."""
        some = self._points
        kept: list[RigidCandidate] = []
        seen = np.zeros((0, len(some), 3))
        for own in candidates:
            here = apply(own.depth_from_object, some)
            if (np.linalg.norm(seen - here, axis=2).mean(axis=1) < _APART * self.size).any():
                continue
            kept.append(own)
            seen = np.concatenate([seen, here[None]])
            if len(kept) == most:
                break
        return kept

    def _anywhere(self) -> Iterator[dict[int, RigidCandidate]]:
        """Return the best place of the part on each thing, at each turn."""
        middle = np.median(self._places, axis=0)
        members = [np.flatnonzero(self._things == own) for own in np.unique(self._things)]
        for rotation in spread_rotations(_TURNS):
            sample = self._look(rotation, middle, _COARSELY)
            if sample is None:
                continue
            rough = self._coarse.roughly_at(sample.surface[:_FIRST], self._places, self._tolerance)
            kept = np.concatenate([own[_highest(rough[own], _KEPT)] for own in members])
            scores = self._coarse.at(sample, self._places[kept], self._tolerance, goes_on=True)
            best = {}
            for number in np.argsort(scores):
                place = self._places[kept[number]]
                pose = transform(rotation, place - sample.origin)
                best[int(self._things[kept[number]])] = RigidCandidate(pose, float(scores[number]))
            yield best

    def _closer(self, candidate: RigidCandidate) -> RigidCandidate:
        """Move and turn the part by steps that become smaller until nothing agrees better."""
        best = replace(candidate, score=-np.inf)
        for halvings in range(_HALVINGS):
            pose = best.depth_from_object
            middle = apply(pose, self.middle)
            sample = self._look(pose[:3, :3], middle, _CLOSELY)
            if sample is None:
                return best
            start = self._rescored(best, sample, np.zeros(6), middle)
            best, twist = start, np.zeros(6)
            for _ in range(_ROUNDS):
                steps = [twist + own for own in self._steps(0.5**halvings)]
                tried = [self._rescored(start, sample, own, middle, pose) for own in steps]
                number = int(np.argmax([own.score for own in tried]))
                if tried[number].score <= best.score + 1e-6:
                    break
                best, twist = tried[number], steps[number]
        return best

    def _steps(self, share: float) -> list[FloatArray]:
        lengths = np.repeat([share * _SHIFT * self.size, share * _TURN], 3)
        return [sign * own for own in np.diag(lengths) for sign in (1.0, -1.0)]

    def _rescored(
        self,
        candidate: RigidCandidate,
        sample: ShapeSample,
        twist: FloatArray,
        pivot: FloatArray,
        pose: FloatArray | None = None,
    ) -> RigidCandidate:
        """Return a candidate turned about a pivot and shifted, with its score."""
        start = candidate.depth_from_object if pose is None else pose
        turn = rotation_matrix(twist[3:])
        moved = transform(turn @ start[:3, :3], turn @ (start[:3, 3] - pivot) + pivot + twist[:3])
        own = replace(sample, surface=sample.surface @ turn.T, beside=sample.beside @ turn.T)
        place = turn @ (sample.origin + start[:3, 3] - pivot) + pivot + twist[:3]
        score = self._fine.at(own, place[None], self._tolerance, goes_on=True)
        return RigidCandidate(moved, float(score[0]))

    def _look(
        self, rotation: FloatArray, middle: FloatArray, counts: Counts
    ) -> ShapeSample | None:
        """Return points as a camera has them that sees the part at a place.

        Args:
            rotation: camera_from_object, shape (3, 3).
            middle: of the part in the camera's frame [m], shape (3,).
            counts: of points on the surface and beside it, at most.
        """
        distance = float(np.linalg.norm(middle))
        view = middle / distance
        right = np.cross([0.0, 1.0, 0.0], view)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(view, right), view])
        focal = _DRAWN * distance / self.size
        tracer = self._tracer(focal)
        ahead = np.array([0.0, 0.0, max(distance, self.size)])
        turned = (self._positions - self.middle) @ (axes @ rotation).T
        depth = tracer.trace(turned + ahead).full_depth()
        inside = np.isfinite(depth)
        if np.count_nonzero(inside) < 10:
            return None
        away, near = ndimage.distance_transform_edt(~inside, return_indices=True)
        points = _points(depth, inside, focal)
        ring = (away >= _BESIDE[0]) & (away <= _BESIDE[1])
        around = _points(depth[tuple(near)], ring, focal)
        # From the view's axes to the camera's, and from the middle of the part.
        points, around = ((own - ahead) @ axes for own in (points, around))
        first = points[np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1))]
        chosen = points[spread(len(points), counts[0])]
        return ShapeSample(
            np.vstack([first, chosen]) - first,
            around[spread(len(around), counts[1])] - first,
            _NONE,
            _NONE,
            first + rotation @ self.middle,
        )

    def _tracer(self, focal: float) -> DepthTracer:
        side = _CANVAS
        camera = PinholeCamera(side, side, focal, focal, 0.5 * (side - 1), 0.5 * (side - 1))
        return DepthTracer(self._triangles, len(self._positions), camera)


def _highest(values: FloatArray, share: float) -> IntArray:
    """Return which of some values are the highest, a share of them, one at least."""
    count = max(1, int(share * len(values)))
    return np.argpartition(-values, count - 1)[:count]


def _points(depth: FloatArray, chosen: BoolArray, focal: float) -> FloatArray:
    """Return chosen pixels of a small drawing as points [m], shape (N, 3)."""
    rows, columns = np.nonzero(chosen)
    own = depth[rows, columns]
    middle = 0.5 * (_CANVAS - 1)
    return np.stack([(columns - middle) / focal * own, (rows - middle) / focal * own, own], axis=1)


def balanced(depth: FloatArray, jump: float, most: int) -> tuple[IntArray, IntArray]:
    """Choose measured pixels so that a wall does not outnumber what stands before it.

    Args:
        depth: [m], shape (h, w), NaN where invalid.
        jump: neighbours that differ by more belong to different things [m].
        most: how many are chosen, about.

    Returns:
        Which of the valid pixels, row by row, in ascending order, and the number of the thing
        that each belongs to, from 0 on.
    """
    filled = np.where(np.isfinite(depth), depth, np.inf)
    # Pixels of one thing hang together without a jump between any two neighbours.
    with np.errstate(invalid='ignore'):
        step = np.maximum(
            ndimage.maximum_filter(filled, 3) - filled, filled - ndimage.minimum_filter(filled, 3)
        )
    things, count = ndimage.label(~(step > jump) & np.isfinite(depth))
    # A jump's own pixels go with the thing that is nearest.
    near = ndimage.distance_transform_edt(things == 0, return_distances=False, return_indices=True)
    own = things[tuple(near)][np.isfinite(depth)] if count else np.zeros(0, dtype=np.int64)
    if not count:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    sizes = np.bincount(own, minlength=count + 1)
    sizes[sizes < _SPECK] = 0
    share = most / max(1, int(np.count_nonzero(sizes)))
    # What smaller things do not need the larger ones get.
    for _ in range(5):
        taken = np.minimum(sizes, share).sum()
        open_things = np.count_nonzero(sizes > share)
        if not open_things or taken >= most - 1:
            break
        share += (most - taken) / open_things
    random = np.random.default_rng(5)
    chosen = np.flatnonzero((random.random(len(own)) * sizes[own] < share) & (sizes[own] > 0))
    return chosen, np.unique(own[chosen], return_inverse=True)[1]


def surface_points(fixture: Fixture, count: int) -> FloatArray:
    """Return points spread over a surface [m], shape (count, 3)."""
    corners = fixture.positions[fixture.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(across, axis=1)
    chosen, shares = spread_over(areas, count)
    points: FloatArray = np.einsum('nc,ncx->nx', shares, corners[chosen])
    return points
