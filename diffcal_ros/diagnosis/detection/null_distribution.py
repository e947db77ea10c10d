# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How often clean data would look as bad: a parametric bootstrap with a linear refit.

Noise is drawn from the floors, what the nuisances would take up of it is taken out, and every
candidate is scored as it was on the data. The least likely of all scores is compared with the
least likely one of the data, so that the number of looks is paid for exactly, as the chi-square
distributions would only bound it.
"""

from collections.abc import Sequence

from diffcal_ros.chi_square import chance_beyond
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.screening.screening import gains, Score, Screen
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

DRAWS = 4000
_SEED = 20_230_421


def chance_of_clean(
    nominal: Refit, screen: Screen, draws: int = DRAWS, *, misstated: float = 1.0
) -> float:
    """Return the chance that clean data look as bad over all candidates.

    Chances below what so many draws can show are bounded by the number of looks.

    Args:
        nominal: the fit.
        screen: scores around it.
        draws: of the noise.
        misstated: how many times larger the errors of sensor, mesh and poses are than they are
            stated.
    """
    return chances_of_clean(nominal, screen, (misstated,), draws)[0]


def chances_of_clean(
    nominal: Refit, screen: Screen, misstated: Sequence[float], draws: int = DRAWS
) -> list[float]:
    """Return that chance for errors that are misstated so many times each, by the same draws.

    Args:
        nominal: see `chance_of_clean`.
        screen: likewise.
        misstated: likewise, of each.
        draws: likewise.
    """
    freedom = max(nominal.patch_count - len(nominal.coordinates), 1)
    scored = [s for s in screen.scores if s.candidate.effect.has_tangent]
    drawn = _least_chances(screen, scored, freedom, draws)
    found = []
    for scale in np.square(misstated):
        whole = float(chance_beyond(nominal.chi_square / scale, freedom))
        # What nothing explains is in units of the errors as stated: larger ones have a part in it.
        noise = max(float(scale), screen.noise_scale)
        observed = [_tail(s.plain_gain / noise, s) for s in scored]
        least = min([whole, *map(float, observed)])
        bound = min(1.0, least * (1 + len(scored)))
        as_bad = int((drawn <= least).sum())
        found.append(as_bad / draws if as_bad else min(bound, 1.0 / draws))
    return found


def _least_chances(
    screen: Screen, scored: Sequence[Score], freedom: int, draws: int
) -> FloatArray:
    """Return the least likely of all scores of each draw of clean data, shape (draws,)."""
    random = np.random.default_rng(_SEED)
    noise = screen.project(random.standard_normal((screen.patch_count, draws)))
    least = chance_beyond((noise**2).sum(axis=0), freedom)
    for score in scored:
        found = gains(score.candidate, score.plain_columns, noise)
        least = np.minimum(least, _tail(found, score))
    return least


def _tail(gain: FloatArray | float, score: Score) -> FloatArray:
    return chance_beyond(gain, len(score.amplitudes))
