# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What may still hide: how large each effect may be without standing out.

Agreement says that no effect is seen, not that none is there. Many effects hide in the modulus; an
upper limit for each says how much.
"""

from diffcal_ros.diagnosis.screening.screening import Score, Screen
import numpy as np

Limits = dict[str, dict[str, float]]

_NORMAL_95 = 1.96
# Columns shorter than this against their prior are not seen at all.
_BLIND = 1e-9


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


def _of_one(score: Score, noise_scale: float) -> dict[str, float]:
    columns, candidate = score.plain_columns, score.candidate
    parts = [candidate.effect.component(name) for name in candidate.components]
    scales = np.array([part.scale for part in parts])
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
