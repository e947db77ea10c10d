# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where in a depth image a bent body may be: everywhere at first, then more closely.

Gravity leaves one turn open, and the camera's image the place: a point in the middle of the body
lies on something that was measured. Every shape is tried at every turn and every such point, and
the best places are moved and turned a little until they agree no better.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.proposal.bent_shape import BentShape
from diffcal_ros.proposal.shape_sample import ShapeSampler
from diffcal_ros.registration.image_score import ImageScore
from diffcal_ros.registration.surface_sample import ShapeSample
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# The thinned image is about so wide [px], and again when places are looked at closely.
_COARSE, _FINE = 128, 320
_TURNS = 24
# Points of the surface and beside it: for a first look, for all places, and closely.
_FIRST, _COARSELY, _CLOSELY = 14, (60, 40), (220, 160)
_SAMPLED = 1500
# After the first look this share of the places is left.
_KEPT = 0.12
# At most so many places, evenly chosen among the measured points.
_MOST_PLACES = 2000
# Depths that differ by less are the same [m].
_COARSE_TOLERANCE, _FINE_TOLERANCE = 0.008, 0.005
# So many places of different bodies are looked at closely, one from each so-large part of space.
_CLOSER, _APART = 80, 0.025
# A clamp is within a hand's breadth of the marker on it [m]; beyond, a place loses so much.
_HAND, _PER_METRE = 0.08, 1.0
# First steps [m], [rad], and how often they are halved.
_SHIFT, _TURN, _HALVINGS = 0.008, np.deg2rad(10.0), 3


@dataclass(frozen=True)
class Candidate:
    """A place of a bent body.

    Attributes:
        shape: which.
        depth_from_object: pose of the held part, shape (4, 4).
        score: how well the image agrees, 1 at best.
    """

    shape: BentShape
    depth_from_object: FloatArray
    score: float

    @property
    def points(self) -> FloatArray:
        """Vertices of the bent body in the camera's frame [m], shape (V, 3)."""
        return apply(self.depth_from_object, self.shape.positions)


class PlaceSearch:
    """Looks for bent shapes of one body in one depth image."""

    def __init__(
        self,
        mesh: TetMesh,
        depth: NDArray[np.float32],
        camera: PinholeCamera,
        gravity: FloatArray,
        marker: FloatArray | None = None,
    ) -> None:
        """Thin the image.

        Args:
            mesh: the body at rest.
            depth: z [m], shape (H, W), NaN where invalid.
            camera: of the image.
            gravity: its direction in the camera's frame, unit, shape (3,).
            marker: middle of a marker on the rig in the camera's frame [m], shape (3,); None:
                there is none.
        """
        self._mesh, self._gravity, self._marker = mesh, gravity, marker
        self._coarse = ImageScore(depth, camera, max(1, round(camera.width / _COARSE)))
        self._fine = ImageScore(depth, camera, max(1, round(camera.width / _FINE)))
        points = self._coarse.surface_points()
        self._places = points[:: max(1, -(-len(points) // _MOST_PLACES))]

    def candidates(
        self, shapes: Sequence[BentShape], tell: Callable[[str], None] = lambda _: None
    ) -> list[Candidate]:
        """Return places of the body, the best first, each part of space and each shape once.

        Args:
            shapes: of the body.
            tell: told what is being done.
        """
        if not len(self._places):
            return []
        found: list[Candidate] = []
        for number, shape in enumerate(shapes, start=1):
            found += self._anywhere(shape)
            if number % 25 == 0 or number == len(shapes):
                tell(f'looked for {number} of {len(shapes)} shapes in the depth image')
        chosen = _apart(found, _CLOSER)
        tell(f'looking at {len(chosen)} places more closely')
        return sorted((self._closer(own) for own in chosen), key=lambda own: -own.score)

    def _anywhere(self, shape: BentShape) -> list[Candidate]:
        """Return the best place of one shape at each turn."""
        sampler = ShapeSampler(self._mesh, shape, _SAMPLED)
        upright = turn_onto(shape.gravity, self._gravity)
        middle = self._places.mean(axis=0)
        view = middle / np.linalg.norm(middle)
        held = shape.positions[shape.hold.vertices(self._mesh)].mean(axis=0)
        found = []
        for angle in np.arange(_TURNS) * (2.0 * np.pi / _TURNS):
            rotation = rotation_matrix(angle * self._gravity) @ upright
            sample = sampler.look(rotation, view, *_COARSELY)
            if sample is None:
                continue
            place, score = self._best_place(sample, rotation @ held - sample.origin)
            found.append(Candidate(shape, transform(rotation, place - sample.origin), score))
        return found

    def _best_place(self, sample: ShapeSample, held: FloatArray) -> tuple[FloatArray, float]:
        away = self._away_from_marker(self._places + held)
        rough = self._coarse.roughly_at(sample.surface[:_FIRST], self._places, _COARSE_TOLERANCE)
        rough = rough - away
        count = max(1, int(_KEPT * len(rough)))
        kept = np.argpartition(-rough, count - 1)[:count]
        scores = self._coarse.at(sample, self._places[kept], _COARSE_TOLERANCE) - away[kept]
        best = int(np.argmax(scores))
        return self._places[kept[best]], float(scores[best])

    def _closer(self, candidate: Candidate) -> Candidate:
        """Move and turn a body by steps that become smaller until the image agrees no better."""
        sampler = ShapeSampler(self._mesh, candidate.shape, 3 * _SAMPLED)
        best = self._scored(sampler, candidate)
        for halvings in range(_HALVINGS):
            for _ in range(6):
                moved = max(
                    (self._scored(sampler, own) for own in _neighbours(best, 0.5**halvings)),
                    key=lambda own: own.score,
                )
                if moved.score <= best.score + 1e-6:
                    break
                best = moved
        return best

    def score(self, candidate: Candidate) -> float:
        """Return how well image and marker agree with a body in its place, 1 at best."""
        sampler = ShapeSampler(self._mesh, candidate.shape, 3 * _SAMPLED)
        return self._scored(sampler, candidate).score

    def _scored(self, sampler: ShapeSampler, candidate: Candidate) -> Candidate:
        pose = candidate.depth_from_object
        middle = candidate.points.mean(axis=0)
        view = middle / max(float(np.linalg.norm(middle)), 1e-9)
        sample = sampler.look(pose[:3, :3], view, *_CLOSELY)
        if sample is None:
            return replace(candidate, score=-np.inf)
        place = (sample.origin + pose[:3, 3])[None]
        held = candidate.points[candidate.shape.hold.vertices(self._mesh)].mean(axis=0)
        score = self._fine.at(sample, place, _FINE_TOLERANCE) - self._away_from_marker(held[None])
        return replace(candidate, score=float(score[0]))

    def _away_from_marker(self, held: FloatArray) -> FloatArray:
        """Return what held parts lose that are beyond the reach of the marker, shape (P,).

        Args:
            held: their middles in the camera's frame [m], shape (P, 3).
        """
        if self._marker is None:
            return np.zeros(len(held))
        away = np.linalg.norm(held - self._marker, axis=1)
        loss: FloatArray = _PER_METRE * np.maximum(0.0, away - _HAND)
        return loss


def turn_onto(source: FloatArray, target: FloatArray) -> FloatArray:
    """Return the shortest rotation of one unit vector onto another, shape (3, 3)."""
    axis = np.cross(source, target)
    sine, cosine = float(np.linalg.norm(axis)), float(source @ target)
    if sine < 1e-9:
        if cosine > 0.0:
            return np.eye(3)
        axis = np.cross(source, np.eye(3)[int(np.argmin(np.abs(source)))])
        return rotation_matrix(np.pi * axis / np.linalg.norm(axis))
    return rotation_matrix(axis / sine * np.arctan2(sine, cosine))


def _apart(candidates: Iterable[Candidate], most: int) -> list[Candidate]:
    """Return the best candidates, the best of those that are nearly one only."""
    kept: list[Candidate] = []
    points: list[FloatArray] = []
    for own in sorted(candidates, key=lambda own: -own.score):
        here = own.points
        some = here[:: max(1, len(here) // 60)]
        if any(np.linalg.norm(some - other, axis=1).mean() < _APART for other in points):
            continue
        kept.append(own)
        points.append(some)
        if len(kept) == most:
            break
    return kept


def _neighbours(candidate: Candidate, share: float) -> list[Candidate]:
    """Return a body shifted along the camera's axes, and turned about them in its middle."""
    pose, middle = candidate.depth_from_object, candidate.points.mean(axis=0)
    found = []
    for axis in np.eye(3):
        for sign in (1.0, -1.0):
            shifted = pose.copy()
            shifted[:3, 3] += sign * share * _SHIFT * axis
            turn = rotation_matrix(sign * share * _TURN * axis)
            turned = transform(turn @ pose[:3, :3], turn @ (pose[:3, 3] - middle) + middle)
            found += [shifted, turned]
    return [replace(candidate, depth_from_object=own) for own in found]
