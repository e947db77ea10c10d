# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What may still hide: how large each effect may be without standing out, and where it hides.

Agreement says that no effect is seen, not that none is there. Many effects hide in the modulus: of
a body at rest only its ratio to the weight is seen. An upper limit for each says how large it may
be, and another one how far a parameter may have followed it.
"""

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.diagnosis.screening.screening import Score, Screen
import numpy as np

Limits = dict[str, dict[str, float]]
Drawn = dict[str, dict[str, float]]

_NORMAL_95 = 1.96
# Columns shorter than this against their prior are not seen at all.
_BLIND = 1e-9
# A logarithm of a share that is larger says no more.
_FARTHEST = 20.0


def upper_limits(screen: Screen) -> Limits:
    """Return how large each amplitude may be at most, 95 %, in the units that people use.

    To first order, with all nuisances and the effect's other amplitudes free. Infinite where data
    say nothing. An effect with several places or modes has the largest limit of each amplitude.
    Those have none that tangents at zero do not tell.
    """
    found: Limits = {}
    for score in screen.scores:
        if not score.candidate.effect.has_limit:
            continue
        own = found.setdefault(score.candidate.identifier, {})
        for name, limit in _of_one(score, screen.noise_scale).items():
            own[name] = max(limit, own.get(name, 0.0))
    return found


def drawn_parameters(screen: Screen, parameters: ParameterSet) -> Drawn:
    """Return how far each parameter may be off by what hides, 95 %, by parameter and effect.

    To first order, as shares: of the parameters that are fitted by their logarithms, which moduli
    and densities are. An effect is taken to be no larger than its bounds; of those with several
    places or modes the one that draws most counts. Those that tangents at zero do not tell are
    left out.

    Args:
        screen: scores of all candidates.
        parameters: of the nominal model.
    """
    listed = [s for s in screen.scores if s.candidate.effect.has_limit and s.follows.size]
    found: Drawn = {}
    for index, parameter in enumerate(parameters):
        if parameter.is_nuisance or not parameter.is_logarithmic:
            continue
        own = found.setdefault(parameter.name, {})
        for score in listed:
            name = score.candidate.identifier
            most = _drawn_by(score, index, screen.noise_scale)
            most = float(np.expm1(min(most, _FARTHEST)))
            own[name] = max(most, own.get(name, 0.0))
    return found


def _drawn_by(score: Score, index: int, noise_scale: float) -> float:
    """Return how far an effect may have drawn a coordinate at most, 95 %."""
    most = np.array([max(abs(part.lower), abs(part.upper)) for part in score.candidate.parts])
    columns, follows = score.plain_columns * most, score.follows[index] * most
    covariance = np.linalg.inv(columns.T @ columns / noise_scale + np.eye(len(most)))
    estimate = covariance @ (columns.T @ score.plain_residual) / noise_scale
    spread = np.sqrt(follows @ covariance @ follows)
    return float(np.abs(follows @ estimate) + _NORMAL_95 * spread)


def _of_one(score: Score, noise_scale: float) -> dict[str, float]:
    columns, candidate = score.plain_columns, score.candidate
    parts, scales = candidate.parts, candidate.scales
    scaled = columns * scales
    left, sizes, right = np.linalg.svd(scaled, full_matrices=False)
    seen = sizes > _BLIND
    estimate = right[seen].T @ ((left.T @ score.plain_residual)[seen] / sizes[seen])
    variance = (right[seen] ** 2 / sizes[seen, None] ** 2).sum(axis=0) * noise_scale
    variance[(right[~seen] ** 2).sum(axis=0) > _BLIND] = np.inf
    limits = scales * (np.abs(estimate) + _NORMAL_95 * np.sqrt(variance))
    return {
        part.name: float(limit * part.shown_factor)
        for part, limit in zip(parts, limits, strict=True)
    }
