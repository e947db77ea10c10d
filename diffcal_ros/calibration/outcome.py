# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a fit ended, in words, each with its remedy."""

from enum import Enum


class Outcome(str, Enum):
    """The ways a fit can end."""

    CONVERGED = 'converged'
    AT_BOUND = 'at_bound'
    NOT_IDENTIFIABLE = 'not_identifiable'
    MODEL_DISAGREES = 'model_disagrees'
    NOT_CONVERGED = 'not_converged'
    DIVERGED = 'diverged'
    INTERRUPTED = 'interrupted'

    @property
    def is_fitted(self) -> bool:
        """Tell whether the parameters may be used."""
        return self in (Outcome.CONVERGED, Outcome.AT_BOUND, Outcome.MODEL_DISAGREES)

    @property
    def remedy(self) -> str:
        """Say what to do about it."""
        return _REMEDIES[self]


_REMEDIES = {
    Outcome.CONVERGED: 'The fit is done.',
    Outcome.AT_BOUND: (
        'A parameter stopped at its bound: widen the bound in the scene if that value is '
        'possible, else look for what the model lacks.'
    ),
    Outcome.NOT_IDENTIFIABLE: (
        'The data cannot tell these parameters apart: fit fewer of them, give a prior in the '
        'scene, or record another posture or load.'
    ),
    Outcome.MODEL_DISAGREES: (
        'The fit converged but leaves a gap that the sensor does not explain: look at the '
        'residual image, check placement, clamp and pose, and allow a rigid offset.'
    ),
    Outcome.NOT_CONVERGED: (
        'The iterations ran out while the fit was still moving: start closer, or allow more.'
    ),
    Outcome.DIVERGED: (
        'No step made the fit better: check that the rendered body lies on the observed one '
        '(the start image of the report), the pose, the units and the start values.'
    ),
    Outcome.INTERRUPTED: 'The fit was stopped; the last complete state is kept.',
}
