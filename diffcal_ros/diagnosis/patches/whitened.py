# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Patches of all views in units of their own noise, uncorrelated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

from diffcal_ros.diagnosis.patches.noise_model import CommonError
from diffcal_ros.diagnosis.patches.patch_group import of_the_body, PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.least_squares.normal_equations import NormalEquations
from diffcal_ros.least_squares.residual_channel import ResidualChannel, Weights
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cholesky, solve_triangular

FloatArray = NDArray[np.float64]


# Standard deviations beyond which a patch counts less.
_FAR = 5.0


class Part(Enum):
    """Which patches are looked at."""

    FIT = 'fit'
    REPORT = 'report'
    ALL = 'all'


@dataclass(frozen=True)
class Whitened:
    """Patches in units of their noise.

    Attributes:
        values: shape (n,).
        jacobian: shape (n, k).
        views: number of the view of each, shape (n,).
        volumes: by how much the log determinant of their covariance exceeds that of even patches,
            shape (n,); what views have in common is in the last of them.
        tolerances: by how much that of patches that are far off exceeds it, since they count less,
            shape (n,), likewise.
        sizes: log determinant of the covariance without either, in square metres, shape (n,),
            likewise.
    """

    values: FloatArray
    jacobian: FloatArray
    views: NDArray[np.int64]
    volumes: FloatArray
    tolerances: FloatArray
    sizes: FloatArray

    @property
    def tolerance(self) -> float:
        """Twice the log of how much less likely it makes the data that patches count less.

        It is a price between models. In a fit it would stop steps that begin far off.
        """
        return float(self.tolerances.sum())

    @property
    def has_far_off(self) -> bool:
        """Tell whether some patches are so far off that they count less."""
        return self.tolerance > 0.0

    @property
    def volume(self) -> float:
        """What being uneven costs: twice the log of how much less likely it makes the data.

        A patch over which residuals run has a larger variance, which the model is the cause of.
        Without this the model that is farther off would be held to less.
        """
        return float(self.volumes.sum())

    @property
    def chi_square(self) -> float:
        """Sum of squares."""
        return float(self.values @ self.values)

    def equations(self) -> NormalEquations:
        """Return what the patches say to second order, without priors."""
        weights = Weights.of_squares(np.ones(len(self)))
        return ResidualChannel(
            self.values, self.jacobian, weights, 0.5 * self.chi_square
        ).equations()

    def __len__(self) -> int:
        return len(self.values)


def whiten(
    groups: Sequence[PatchGroup], part: Part, slack: float = 0.0, *, is_apart: bool = False
) -> Whitened:
    """Put the patches of one part together.

    Those of different recordings share nothing but what stands in the image of all.

    Args:
        groups: of all views.
        part: which patches.
        slack: further error of each patch [m]: what a model that is still far off, or tangents
            far from where they were taken, cannot be held to.
        is_apart: whether what stands in all is taken for another one in each view: views then do
            not mix.
    """
    recordings = [_recording(own, part, slack) for own in _recordings(groups)]
    recordings = [recording for recording in recordings if len(recording.values)]
    if not any(recording.standing.spread.any() for recording in recordings):
        parts = [_whitened(recording) for recording in recordings]
    elif is_apart:
        parts = [_whitened(_with_own(recording)) for recording in recordings]
    else:
        parts = [_whitened(_all_together(recordings))]
    return Whitened(
        np.concatenate([part.values for part in parts]),
        np.concatenate([part.jacobian for part in parts]),
        np.concatenate([part.views for part in parts]),
        np.concatenate([part.volumes for part in parts]),
        np.concatenate([part.tolerances for part in parts]),
        np.concatenate([part.sizes for part in parts]),
    )


def independent_count(groups: Sequence[PatchGroup], part: Part) -> float:
    """Return how many independent patches tell as much of how large noise is as the body's do.

    Neighbours, and poses, have errors in common (Satterthwaite, *An approximate distribution of
    estimates of variance components*, Biometrics Bulletin 2, 1946).
    """
    recordings = [_recording(own, part, 0.0) for own in _recordings(of_the_body(groups))]
    covariance = _all_together(recordings).covariance
    return float(np.trace(covariance) ** 2 / np.square(covariance).sum())


def precision_of(groups: Sequence[PatchGroup]) -> FloatArray:
    """Return the inverse covariance of all patches, in the order of the groups [1/m^2], (n, n).

    What stands in all images is taken for another error in each view.
    """
    firsts = np.cumsum([0, *(len(group.patches.values) for group in groups)])
    found = np.zeros((firsts[-1], firsts[-1]))
    numbers = {id(group): number for number, group in enumerate(groups)}
    for own in _recordings(groups):
        recording = _with_own(_recording(own, Part.ALL, 0.0))
        indices = np.concatenate(
            [np.arange(firsts[n], firsts[n + 1]) for n in (numbers[id(group)] for group in own)]
        )
        covariance = _tolerant(recording.covariance, recording.left)
        found[np.ix_(indices, indices)] = np.linalg.inv(covariance)
    return found


def _recordings(groups: Sequence[PatchGroup]) -> list[list[PatchGroup]]:
    return [
        sorted((b for b in groups if b.recording == recording), key=lambda group: group.kind)
        for recording in dict.fromkeys(group.recording for group in groups)
    ]


@dataclass(frozen=True)
class _Recording:
    """Patches with their covariance, and what of it stands in the image of other groups as well.

    Attributes:
        values: [m], shape (n,).
        jacobian: shape (n, k).
        views: number of the view of each, shape (n,).
        covariance: without what stands [m^2], shape (n, n).
        standing: what does.
        centers: in the image [px], shape (n, 2).
        uneven: what of the variances patches are uneven by [m^2], shape (n,).
        left: what of the values tells how far off patches are [m], shape (n,).
    """

    values: FloatArray
    jacobian: FloatArray
    views: NDArray[np.int64]
    covariance: FloatArray
    standing: CommonError
    centers: FloatArray
    uneven: FloatArray
    left: FloatArray


def _recording(groups: Sequence[PatchGroup], part: Part, slack: float) -> _Recording:
    """Put the patches of one recording together."""
    chosen = [chosen_patches(group, part) for group in groups]
    patches = [b.patches.chosen(w) for b, w in zip(groups, chosen, strict=True)]
    mesh = np.concatenate([b.mesh[w] for b, w in zip(groups, chosen, strict=True)])
    covariance = block_diag(*(p.covariance for p in patches)) + _common(groups, patches)
    return _Recording(
        values=np.concatenate([p.values for p in patches]),
        jacobian=np.concatenate([p.jacobian for p in patches]),
        views=np.concatenate(
            [np.full(len(p.values), b.view) for b, p in zip(groups, patches, strict=True)]
        ),
        # The mesh's error is one number a recording: it moves depth and outline together.
        covariance=covariance + np.outer(mesh, mesh) + slack**2 * np.eye(len(mesh)),
        standing=_standing(patches),
        centers=np.concatenate([p.centers for p in patches]),
        uneven=np.concatenate(
            [np.zeros(len(p.values)) if p.uneven is None else p.uneven for p in patches]
        ),
        left=np.concatenate([p.values if p.left is None else p.left for p in patches]),
    )


def _with_own(recording: _Recording) -> _Recording:
    """Return a group with what stands in all images as an error of its own."""
    standing = recording.standing
    return replace(
        recording,
        covariance=recording.covariance + standing.covariance(recording.centers),
        standing=standing.of(np.zeros_like(standing.spread)),
    )


def _all_together(recordings: Sequence[_Recording]) -> _Recording:
    """Return all groups as one, with what stands in all of their images."""
    one = max((recording.standing for recording in recordings), key=lambda error: error.length)
    whole = _Recording(
        values=np.concatenate([recording.values for recording in recordings]),
        jacobian=np.concatenate([recording.jacobian for recording in recordings]),
        views=np.concatenate([recording.views for recording in recordings]),
        covariance=np.asarray(block_diag(*(recording.covariance for recording in recordings))),
        standing=one.of(np.concatenate([own.standing.spread for own in recordings])),
        centers=np.concatenate([recording.centers for recording in recordings]),
        uneven=np.concatenate([recording.uneven for recording in recordings]),
        left=np.concatenate([recording.left for recording in recordings]),
    )
    return _with_own(whole)


def _whitened(recording: _Recording) -> Whitened:
    covariance = _tolerant(recording.covariance, recording.left)
    factor = cholesky(covariance, lower=True)
    even = factor
    if recording.uneven.any():
        even = cholesky(covariance - np.diag(recording.uneven), lower=True)
    volumes = 2.0 * np.log(np.diag(factor) / np.diag(even))
    wide = np.hstack([recording.values[:, None], recording.jacobian])
    both = solve_triangular(factor, wide, lower=True)
    tolerances = np.zeros(len(volumes))
    if np.any(covariance != recording.covariance):
        held = cholesky(recording.covariance, lower=True)
        tolerances = 2.0 * np.log(np.diag(factor) / np.diag(held))
    sizes = 2.0 * np.log(np.diag(factor)) - volumes - tolerances
    return Whitened(both[:, 0], both[:, 1:], recording.views, volumes, tolerances, sizes)


def _common(groups: Sequence[PatchGroup], patches: Sequence[Patches]) -> FloatArray:
    """Return the covariance of what frames of one recording have in common, shape (n, n)."""
    parts = []
    for kind in dict.fromkeys(group.kind for group in groups):
        own = [p for b, p in zip(groups, patches, strict=True) if b.kind == kind]
        spread = np.concatenate([p.common.spread for p in own])
        common = own[0].common.of(spread)
        parts.append(common.covariance(np.concatenate([p.centers for p in own])))
    return np.asarray(block_diag(*parts))


def _standing(patches: Sequence[Patches]) -> CommonError:
    """Return what stands in the image of all recordings, in all of these patches."""
    own = [p.standing for p in patches if p.standing is not None]
    one = own[0] if own else CommonError(np.zeros(0), 1.0)
    spreads = [
        np.zeros(len(p.values)) if p.standing is None else p.standing.spread for p in patches
    ]
    return one.of(np.concatenate(spreads))


def _tolerant(covariance: FloatArray, values: FloatArray) -> FloatArray:
    """Let patches that are far off count in proportion to that, not to its square."""
    return covariance + np.diag(more_by_far_off(values, np.diag(covariance)))


def more_by_far_off(values: FloatArray, variances: FloatArray) -> FloatArray:
    """Return by how much variances are larger of what is far off, shape (n,).

    It counts in proportion to that so, and not to its square.

    Args:
        values: how far off it is, shape (n,).
        variances: as they are known, shape (n,).
    """
    beyond = np.abs(values) / (_FAR * np.sqrt(variances))
    return variances * np.maximum(beyond - 1.0, 0.0)


def chosen_patches(group: PatchGroup, part: Part) -> NDArray[np.int64]:
    """Return the indices of a group's patches of one part."""
    if part is Part.ALL:
        return np.arange(len(group.is_report))
    return np.flatnonzero(group.is_report == (part is Part.REPORT))
