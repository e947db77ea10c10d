# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a fit ended, in words, each with its remedy."""

from enum import Enum

# Exit codes beside 0, done, and 2, bad input.
EXIT_NOT_FITTED, EXIT_MODEL_DISAGREES, EXIT_AMBIGUOUS = 3, 4, 5


class Outcome(str, Enum):
    """The ways a fit can end."""

    CONVERGED = 'converged'
    AT_BOUND = 'at_bound'
    NOT_IDENTIFIABLE = 'not_identifiable'
    MODEL_DISAGREES = 'model_disagrees'
    AMBIGUOUS = 'ambiguous'
    NOT_CONVERGED = 'not_converged'
    DIVERGED = 'diverged'
    INTERRUPTED = 'interrupted'

    @property
    def is_fitted(self) -> bool:
        """Tell whether a minimum was found: whether there is something to look at and to save."""
        return self in _FOUND

    @property
    def is_usable(self) -> bool:
        """Tell whether a script may use the numbers without a person who looks at them."""
        return self is Outcome.CONVERGED

    @property
    def exit_code(self) -> int:
        """Exit code of a command whose result this is."""
        return _EXIT_CODES.get(self, EXIT_NOT_FITTED)

    @property
    def remedy(self) -> str:
        """Say what to do about it."""
        return _REMEDIES[self]


_FOUND = (Outcome.CONVERGED, Outcome.AT_BOUND, Outcome.MODEL_DISAGREES, Outcome.AMBIGUOUS)
_EXIT_CODES = {
    Outcome.CONVERGED: 0,
    Outcome.MODEL_DISAGREES: EXIT_MODEL_DISAGREES,
    Outcome.AMBIGUOUS: EXIT_AMBIGUOUS,
}
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
        'The fit converged but leaves a gap that the sensor does not explain, or a part of the '
        'simulated or of the measured body without its counterpart: look at the residual image, '
        'check placement, clamp and pose, and allow a rigid offset.'
    ),
    Outcome.AMBIGUOUS: (
        'Several answers explain the data about as well; all are listed under alternatives. Look '
        'at them in the report, state the placement or the modulus more closely (a prior, '
        'bounds), or record another posture or load.'
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
