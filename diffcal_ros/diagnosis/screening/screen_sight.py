# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whitened patches as candidates are scored by, what nuisances explain taken out."""

from collections.abc import Callable
from dataclasses import dataclass

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.projection import Projection
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ScreenSight:
    """Residual and columns with the nuisances projected out.

    Attributes:
        names: of the columns.
        residual: shape (n,).
        columns: shape (n, k).
        follows: by how much a fit of the parameters follows each column, shape (p, k).
        views: number of the view of each patch, shape (n,).
        project: takes out what nuisances explain.
    """

    names: tuple[str, ...]
    residual: FloatArray
    columns: FloatArray
    follows: FloatArray
    views: NDArray[np.int64]
    project: Callable[[FloatArray], FloatArray]

    def of(self, candidate: Candidate) -> FloatArray:
        """Return the columns of a candidate's amplitudes, shape (n, c)."""
        return self._own(candidate, self.columns)

    def follows_of(self, candidate: Candidate) -> FloatArray:
        """Return how parameters follow a candidate's amplitudes, shape (p, c)."""
        return self._own(candidate, self.follows)

    def _own(self, candidate: Candidate, columns: FloatArray) -> FloatArray:
        effect = candidate.effect
        own = [index for index, name in enumerate(self.names) if name == effect.identifier]
        is_screened = candidate.at in effect.screened_at
        if is_screened:
            own = [own[effect.screened_at.index(candidate.at)]]
        if not effect.has_tangent:
            return columns[:, own]
        if is_screened:
            # Where nothing is there, its time changes nothing.
            found = np.zeros((len(columns), len(candidate.components)))
            found[:, :1] = columns[:, own]
            return found
        return columns[:, [self.names.index(name) for name in candidate.names]]


def seen_through(
    groups: list[PatchGroup],
    nominal: ParameterSet,
    names: tuple[str, ...],
    beyond: FloatArray,
    slack: float,
) -> ScreenSight:
    """Look at patches through what nuisances leave of them.

    Args:
        groups: with the tangents of the parameters, of what may be missing and of what is beside.
        nominal: the parameters.
        names: of the columns of what may be missing.
        beyond: how far the parameters are off their priors' means, shape (p,).
        slack: see `tangent_slack` [m].
    """
    seen = whiten(groups, Part.FIT, slack)
    _, precision = regularised_prior(nominal)
    count = len(nominal) + len(names)
    own, beside = seen.jacobian[:, : len(nominal)], seen.jacobian[:, count:]
    known = block_diag(precision, np.eye(beside.shape[1]))
    project = Projection(np.hstack([own, beside]), known)
    missing = seen.jacobian[:, len(nominal) : count]
    columns, follows = project(missing), project.followed(missing)[: len(nominal)]
    # Seen from the priors' means, so that what strains a prior has to be explained, too.
    residual = project(seen.values + own @ beyond)
    return ScreenSight(names, residual, columns, follows, seen.views, project)
