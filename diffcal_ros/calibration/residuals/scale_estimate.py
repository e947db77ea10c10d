# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Weigh residuals by what they show: how wide they lie, their noise, and how many say the same."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.observations.observation import Instant
from diffcal_ros.calibration.residuals.correlation import correlation_lengths
from diffcal_ros.calibration.residuals.residual_scales import Scale, Scales, spread, WIDE_REACH
from diffcal_ros.calibration.residuals.robust_residual import (
    Comparison,
    Reach,
    ResidualKind,
    Residuals,
)
from diffcal_ros.calibration.residuals.time_correlation import (
    part_means,
    repeated_frames,
    surface_parts,
)
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_FINEST_NOISE = 0.0002
# Noise that is hardly finer than what is taken for it changes nothing.
_CLEARLY_FINER = 0.7
_CLIPPED = 3.0  # Outliers are not what residuals have in common [noise].
_EDGE_REACH = 30


@dataclass(frozen=True)
class SeenView:
    """One view compared with its observation, without the sensor's bias of edges.

    Attributes:
        view: the rendered body.
        instant: at which it was seen; None at rest.
        comparison: of it.
    """

    view: View
    instant: Instant | None
    comparison: Comparison


def annealed(scales: Scales, views: Sequence[SeenView], truncation: float) -> Scales:
    """Return scales whose widths follow the residuals down to their final value.

    Args:
        scales: so far.
        views: all.
        truncation: residuals beyond this belong to something else than the body [m].
    """
    depth, edge = (
        scales.of(kind).annealed(_groups([one.comparison.of(kind) for one in views], views))
        for kind in ResidualKind
    )
    reach = WIDE_REACH
    if max(depth.width, edge.width) < truncation / 2.0:
        reach = Reach(truncation, 1.5 * truncation, _EDGE_REACH)
    return replace(scales, depth=depth, edge=edge, reach=reach)


def refined(scales: Scales, views: Sequence[SeenView]) -> Scales:
    """Return scales by the noise and correlation that the residuals show, where they are finer.

    Args:
        scales: so far; the very same are returned where nothing is finer and nothing has leeway,
            which ends here.
        views: all.
    """
    finer: dict[ResidualKind, Scale] = {}
    for kind in ResidualKind:
        residuals = [one.comparison.of(kind) for one in views]
        noise = max(spread(_joined(residuals)), _FINEST_NOISE)
        scale = scales.of(kind)
        if not any(len(own.values) for own in residuals) or noise > _CLEARLY_FINER * scale.noise:
            continue
        limit = _CLIPPED * noise
        finer[kind] = scale.refined(
            noise, _longest_correlation(residuals, limit), _repeats(kind, views, limit)
        )
    if not finer and scales.leeway == 1.0:
        return scales
    depth, edge = (finer.get(kind, scales.of(kind)) for kind in ResidualKind)
    return Scales(depth, edge, scales.reach)


def _groups(residuals: Sequence[Residuals], views: Sequence[SeenView]) -> list[Residuals]:
    """Put residuals of one kind together: of all bodies at rest, and of each frame of a motion."""
    both = list(zip(residuals, views, strict=True))
    still = [own for own, one in both if one.instant is None]
    moving = [own for own, one in both if one.instant is not None]
    return [_joined(still), *moving] if still else moving


def _longest_correlation(residuals: Sequence[Residuals], limit: float) -> float:
    """Return the longest correlation length over the views [px], of an area's side or a line."""
    lengths = [1.0]
    for own in residuals:
        if len(own.values) == 0:
            continue
        low = own.pixels.min(axis=0)
        columns, rows = (own.pixels - low).T
        shape = (int(rows.max()) + 1, int(columns.max()) + 1)
        image, mask = np.zeros(shape), np.zeros(shape, dtype=bool)
        image[rows, columns] = np.clip(own.values, -limit, limit)
        mask[rows, columns] = True
        square, line = correlation_lengths(image, mask)
        lengths.append(square if own.kind.dimension == 2 else line)
    return max(lengths)


def _repeats(kind: ResidualKind, views: Sequence[SeenView], limit: float) -> float:
    """Return how many frames of a recording say the same; 1 without a motion."""
    recordings: dict[int, list[tuple[float, FloatArray]]] = {}
    for one in views:
        if one.instant is None:
            continue
        residuals = one.comparison.of(kind)
        parts, count = surface_parts(one.view.trace, residuals)
        means = part_means(np.clip(residuals.values, -limit, limit), parts, count)
        recordings.setdefault(one.instant.recording, []).append((one.instant.time, means))
    alike = [
        repeated_frames([means for _, means in sorted(frames, key=lambda frame: frame[0])])
        for frames in recordings.values()
    ]
    return max(alike, default=1.0)


def _joined(parts: Sequence[Residuals]) -> Residuals:
    return Residuals(
        kind=parts[0].kind,
        values=np.concatenate([part.values for part in parts]),
        weights=np.concatenate([part.weights for part in parts]),
        pixels=np.concatenate([part.pixels for part in parts]),
        indices=np.concatenate([part.indices for part in parts]),
        missing=sum(part.missing for part in parts),
    )
