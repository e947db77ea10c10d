# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From world positions to camera points: the measured pose, its error and the rigid offset."""

from collections.abc import Sequence

from diffcal_ros.calibration.observations.observation import Observation, pose_owners
from diffcal_ros.calibration.parameters.lens import lens_moves, lens_slopes, through_lens
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.effects.camera_offset import LENS_MODES, stated_lens, stated_offset
from diffcal_ros.rigid_motion import moved, moved_by
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class CameraOffsets:
    """Where each observation's camera sees points of the world, as the parameters have it."""

    def __init__(
        self,
        scene: Scene,
        observations: Sequence[Observation],
        parameters: ParameterSet,
        pivots: Sequence[FloatArray],
    ) -> None:
        """Take down what offsets turn about.

        Args:
            scene: states an offset, or none.
            observations: with their poses.
            parameters: of the fit.
            pivots: the middle of the held part in each camera's frame [m], shape (3,) each.
        """
        self._scene = scene
        self._observations = observations
        self._parameters = parameters
        self._pivots = pivots
        self._owners = pose_owners(observations)
        self._stated_lens, modes = stated_lens(scene.effects), list(LENS_MODES)
        lenses = {index: parameters.parameters[index] for index in parameters.find(Kind.LENS)}
        # By their places, and the only posture where each counts: on top of what it is in all.
        self._lens_modes = {
            index: (modes.index(own.amplitude), own.posture) for index, own in lenses.items()
        }
        # One camera that is elsewhere is elsewhere in every view: its offset has one pivot [m].
        poses = sorted(set(self._owners))
        self.offset_pivot: FloatArray = np.mean([pivots[owner] for owner in poses], axis=0)

    def rigid_offset(
        self, coordinates: FloatArray, posture: int | None = None, time: float | None = None
    ) -> FloatArray:
        """Return the offset's translation [m] and rotation vector [rad], shape (6,).

        Args:
            coordinates: shape (k,).
            posture: number of the one that is seen; None: what it is in all.
            time: after the first frame [s], where it is seen in motion.
        """
        stated = stated_offset(self._scene.effects)
        return self._parameters.twist(
            Kind.RIGID_OFFSET, coordinates, stated=stated, posture=posture, time=time
        )

    def points(self, number: int, world: FloatArray, coordinates: FloatArray) -> FloatArray:
        """Return world positions in the frame of one observation's camera [m], shape (N, 3)."""
        points = self._placed(number, world, coordinates)
        lens = self.lens(number, coordinates)
        return through_lens(points, lens) if lens.any() else points

    def lens(self, number: int, coordinates: FloatArray) -> FloatArray:
        """Return by how much a picture is another one, of each of `LENS_MODES`, shape (m,).

        Args:
            number: of the observation.
            coordinates: shape (k,).
        """
        amounts, more = self._stated_lens.copy(), np.zeros(len(LENS_MODES))
        seen = self._posture(number)
        for index, (mode, posture) in self._lens_modes.items():
            if posture is None:
                amounts[mode] = coordinates[index]
            elif posture == seen:
                more[mode] = coordinates[index]
        return np.asarray(amounts + more)

    def _posture(self, number: int) -> int:
        return self._observations[number].setup_index

    def _placed(self, number: int, world: FloatArray, coordinates: FloatArray) -> FloatArray:
        """Return positions before what the lens does to them [m], shape (N, 3)."""
        points = apply(self._observations[number].depth_from_world, world)
        for twist, pivot in self._both(number, coordinates):
            points = moved(points, twist, pivot)
        return points

    def carried(
        self, number: int, world: FloatArray, moves: FloatArray, coordinates: FloatArray
    ) -> FloatArray:
        """Return how one observation's camera sees points move [m], shape (..., N, 3).

        Args:
            number: of the observation.
            world: the points in the world frame [m], shape (N, 3).
            moves: how they move there [m], shape (..., N, 3).
            coordinates: shape (k,).
        """
        moves = moves @ self.rotation(number, coordinates).T
        slopes = self._lens_slopes(number, world, coordinates)
        if slopes is None:
            return moves
        # Point by point, of all moves at once: a third of the time of one sum over all.
        turned = np.moveaxis(moves, -2, 0).reshape(len(world), -1, 3) @ slopes.mT
        shape = (len(world), *moves.shape[:-2], 3)
        return np.moveaxis(turned.reshape(shape), 0, -2)

    def carried_back(
        self, number: int, world: FloatArray, by_points: FloatArray, coordinates: FloatArray
    ) -> FloatArray:
        """Pull a derivative by the points of `points` back to the world [1/m], shape (N, 3)."""
        slopes = self._lens_slopes(number, world, coordinates)
        if slopes is not None:
            by_points = np.einsum('nij,ni->nj', slopes, by_points)
        return by_points @ self.rotation(number, coordinates)

    def _lens_slopes(
        self, number: int, world: FloatArray, coordinates: FloatArray
    ) -> FloatArray | None:
        """Return how points follow what the lens is shown, shape (N, 3, 3); None: it is exact."""
        lens = self.lens(number, coordinates)
        if not lens.any():
            return None
        return lens_slopes(self._placed(number, world, coordinates), lens)

    def rotation(self, number: int, coordinates: FloatArray) -> FloatArray:
        """Return the rotation from the world to the camera, offsets included, shape (3, 3)."""
        rotation = self._observations[number].depth_from_world[:3, :3]
        for twist, _ in self._both(number, coordinates):
            rotation = rotation_matrix(twist[3:]) @ rotation
        return rotation

    def pose(self, number: int, coordinates: FloatArray) -> FloatArray:
        """Return depth_from_world of one observation's camera, offsets included, (4, 4)."""
        origin = self.points(number, np.zeros((1, 3)), coordinates)[0]
        return transform(self.rotation(number, coordinates), origin)

    def motions(
        self, number: int, world: FloatArray, coordinates: FloatArray
    ) -> dict[int, FloatArray]:
        """Return how camera parameters move the points [m], shape (N, 3) each.

        Args:
            number: of the observation.
            world: positions in the world frame [m], shape (N, 3).
            coordinates: shape (k,).

        Returns:
            By the parameters' indices; without those of other cameras and of no camera.
        """
        (pose, point), (offset, pivot) = self._both(number, coordinates)
        start = apply(self._observations[number].depth_from_world, world)
        between, turned = moved(start, pose, point), rotation_matrix(offset[3:])
        owner, seen = self._owners[number], self._posture(number)
        found = {}
        for index, own in enumerate(self._parameters):
            if own.kind is Kind.CAMERA_POSE and own.target == owner:
                found[index] = moved_by(start, pose, point, own.axis) @ turned.T
            elif own.kind is Kind.RIGID_OFFSET:
                weight = own.weight_in(seen, self._observations[number].time)
                if weight:
                    found[index] = weight * moved_by(between, offset, pivot, own.axis)
        placed = moved(between, offset, pivot)
        lens = self.lens(number, coordinates)
        if lens.any():
            slopes = lens_slopes(placed, lens)
            found = {i: np.einsum('nij,nj->ni', slopes, one) for i, one in found.items()}
        for index, (mode, posture) in self._lens_modes.items():
            if posture in (None, seen):
                found[index] = lens_moves(placed, np.eye(len(LENS_MODES))[mode])
        return found

    def _both(self, number: int, coordinates: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        """Return translation and rotation vector, shape (6,), and pivot, in order of use."""
        pivot = self._pivots[number]
        measured = self._observations[number].pose_pivot
        return [
            (
                self._parameters.twist(Kind.CAMERA_POSE, coordinates, self._owners[number]),
                pivot if measured is None else measured,
            ),
            (
                self.rigid_offset(
                    coordinates, self._posture(number), self._observations[number].time
                ),
                self.offset_pivot,
            ),
        ]
