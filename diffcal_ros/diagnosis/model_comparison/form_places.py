# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where patches are along the body, in the picture and in time, and what is smooth there."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import Observation, pose_owners
from diffcal_ros.diagnosis.patch_fits.residual_location import nearest_nodes
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Over which the function changes: of the body's length, and of the picture of the body.
_LENGTH = 0.5
# Points between which it is interpolated, on the same scales.
ALONG = np.linspace(0.0, 1.0, 4)[:, None]
ACROSS = np.stack(np.meshgrid(*2 * [np.linspace(0.0, 1.0, 3)]), axis=-1).reshape(-1, 2)
# Of its variance that all poses share; load and posture change the rest.
_SHARED = 0.5
# In a motion that rest changes over this share of what is filmed of it, and half of it from frame
# to frame: stamps scatter.
_WHILE, _LASTING = 0.25, 0.5


@dataclass(frozen=True)
class Places:
    """Where the patches of one group are.

    Attributes:
        along: shares of the body's length, shape (n, 1).
        across: in the picture, as shares of the larger extent of all patches, shape (n, 2).
        own: how much their view has of independent parts, which views have in common as far as
            they are alike, shape (v,): its row of the root of their covariance.
        pose: number of their pose among those that are seen.
        pose_count: how many those are.
    """

    along: FloatArray
    across: FloatArray
    own: FloatArray
    pose: int
    pose_count: int

    def functions(self, effect_class: str) -> FloatArray:
        """Return functions whose sum with independent weights of size one is the process, (n, k).

        Args:
            effect_class: what a sensor's error is times varies over the picture.
        """
        if effect_class == 'sensor':
            return interpolated(self.across, ACROSS)
        return interpolated(self.along, ALONG)

    def times(self, moved: FloatArray, functions: FloatArray) -> FloatArray:
        """Return what moves times the functions, shared by all views and of each, (n, m).

        Args:
            moved: how far each patch moves [m], shape (n,).
            functions: shape (n, k).
        """
        own = np.sqrt(1.0 - _SHARED) * self.own[:, None] * functions[:, None]
        width = len(self.own) * functions.shape[1]
        both = np.hstack([np.sqrt(_SHARED) * functions, own.reshape(len(moved), width)])
        return np.asarray(moved[:, None] * both)

    def in_each(self, moved: FloatArray) -> FloatArray:
        """Return what moves in this pose, as one of as many independent columns, (n, p)."""
        found = np.zeros((len(moved), self.pose_count))
        found[:, self.pose] = moved
        return found


def places_of(
    model: ForwardModel, groups: Sequence[PatchGroup], points: Sequence[FloatArray]
) -> list[Places]:
    """Return where the patches of groups are.

    Args:
        model: whose body they show.
        groups: of all views.
        points: nodes of the body in each view [m], camera frame, shape (N, 3) each.
    """
    views = sorted({group.view for group in groups})
    seen = [model.observations[view] for view in views]
    owners = pose_owners(seen)
    poses = list(dict.fromkeys(owners))
    parts = np.linalg.cholesky(_likeness(seen, owners))
    centers = np.concatenate([group.patches.centers for group in groups])
    low, span = centers.min(axis=0), float(np.ptp(centers, axis=0).max())
    return [
        Places(
            along=along_body(model, group, points[group.view]),
            across=(group.patches.centers - low) / span,
            own=parts[number],
            pose=poses.index(owners[number]),
            pose_count=len(poses),
        )
        for group in groups
        for number in (views.index(group.view),)
    ]


def _likeness(seen: Sequence[Observation], owners: Sequence[int]) -> FloatArray:
    """Return how much views have in common of what is not the same in all, shape (v, v).

    Args:
        seen: the views.
        owners: see `pose_owners`: those of one recording, and no others, are alike.
    """
    times = np.array([0.0 if one.instant is None else one.instant.time for one in seen])
    is_one_pose = np.equal.outer(owners, owners)
    spans = np.array([np.ptp(times[own]) for own in is_one_pose])
    apart = np.subtract.outer(times, times) / np.maximum(_WHILE * spans, 1e-9)
    lasting = np.where(is_one_pose, _LASTING * np.exp(-(apart**2)), 0.0)
    return np.asarray(lasting + (1.0 - _LASTING) * np.eye(len(seen)))


def along_body(model: ForwardModel, group: PatchGroup, points: FloatArray) -> FloatArray:
    """Return which share of the body's length each patch of a group is at, shape (n, 1)."""
    observation = model.observations[group.view]
    rest = model.body(observation).discretisation.rest_nodes
    fraction = model.effects.axes(observation.setup_index).fraction(rest)
    return np.asarray(fraction[nearest_nodes(group, points, observation.camera)])[:, None]


def interpolated(locations: FloatArray, points: FloatArray) -> FloatArray:
    """Return functions whose sum with independent weights of size one is the process, (n, k)."""
    values, turns = np.linalg.eigh(kernel(points, points))
    return np.asarray(kernel(locations, points) @ turns / np.sqrt(values))


def kernel(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the process's covariance between two sets of places, shape (n, m)."""
    square = ((one[:, None] - other[None]) ** 2).sum(axis=-1)
    return np.exp(-square / _LENGTH**2)
