# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where along a body of one region the depth camera begins to read too far or too near."""

from collections.abc import Iterable
from dataclasses import replace

from diffcal_ros.depth.tracer import OutOfViewError
from diffcal_ros.diagnosis.evidence import Evidence
from diffcal_ros.fem.equilibrium import EquilibriumError
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

BORDER_EFFECTS = ('depth_bias_by_region', 'stiffness_contrast')

_BINS = 50
# A border is sought this far from clamp and tip.
_MARGIN = 0.15
_LEAST_PIXELS = 20  # In a bin.
# A step stands out when it is at least so high [m], leaves at most this share of what no step
# leaves, and of what one in the middle leaves.
_LEAST_STEP = 0.005
_LEFT, _LEFT_OF_MIDDLE = 0.5, 0.7


def with_border(scene: Scene, evidence: Evidence, candidates: Iterable[FloatArray]) -> Scene:
    """Return a scene whose effects of two materials have their border where a step is seen.

    Args:
        scene: one that has several regions knows its borders, and is returned as it is.
        evidence: of its model.
        candidates: coordinates at which the residual is read: a fit may have followed the step.
    """
    if len(scene.regions) > 1 or any(name in scene.effects for name in BORDER_EFFECTS):
        return scene
    best, at = 0.0, None
    for coordinates in candidates:
        try:
            found = _best_border(*_profile(evidence, coordinates))
        except (EquilibriumError, OutOfViewError):
            continue
        if found is not None and found[1] > best:
            at, best = found
    if at is None:
        return scene
    return _with_setting(scene, at)


def _with_setting(scene: Scene, at: float) -> Scene:
    settings = {name: {'at': at} for name in BORDER_EFFECTS}
    return replace(scene, effects={**scene.effects, **settings})


def _profile(evidence: Evidence, coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the median residual of depth [m] and the pixels by share of length, (n,) each."""
    model = evidence.model
    shares, residuals = [], []
    compared = evidence.comparisons(coordinates)
    views = model.views(coordinates)
    for number, (view, comparison) in enumerate(zip(views, compared, strict=True)):
        observation, tracer = model.observations[number], model.tracers[number]
        axes = model.effects.axes(observation.setup_index)
        along = axes.share(model.body(observation).discretisation.rest_nodes)
        seen = np.isfinite(comparison.difference) & comparison.counted
        faces = along[tracer.triangles].mean(axis=1)
        shares.append(faces[view.trace.faces[seen]])
        own = comparison.difference[seen]
        residuals.append(own - np.median(own) if len(own) else own)
    place = np.minimum((np.concatenate(shares) * _BINS).astype(int), _BINS - 1)
    values = np.concatenate(residuals)
    counts = np.bincount(place, minlength=_BINS).astype(np.float64)
    counts[counts < _LEAST_PIXELS] = 0.0
    medians = np.zeros(_BINS)
    for number in np.flatnonzero(counts).tolist():
        medians[number] = np.median(values[place == number])
    return medians, counts


def _best_border(medians: FloatArray, counts: FloatArray) -> tuple[float, float] | None:
    """Return the share where a step stands out, and its height [m]; None where none does."""
    borders = range(int(_MARGIN * _BINS), int((1.0 - _MARGIN) * _BINS) + 1)
    left = {border: _left_by_step(medians, counts, border) for border in borders}
    border = min(left, key=left.__getitem__)
    sides = [_middle(medians[part], counts[part]) for part in _parts(border)]
    if not abs(sides[1] - sides[0]) > _LEAST_STEP:
        return None
    without = _left_by_step(medians, counts, 0)
    middle = _left_by_step(medians, counts, _BINS // 2)
    if left[border] >= min(_LEFT * without, _LEFT_OF_MIDDLE * middle):
        return None
    return border / _BINS, abs(sides[1] - sides[0])


def _left_by_step(medians: FloatArray, counts: FloatArray, border: int) -> float:
    """Return the sum of absolute residuals that a step at a border leaves [m]."""
    parts = [(medians[part], counts[part]) for part in _parts(border)]
    return sum(float((c * np.abs(m - _middle(m, c))).sum()) for m, c in parts if c.any())


def _parts(border: int) -> tuple[slice, slice]:
    return slice(0, border), slice(border, _BINS)


def _middle(values: FloatArray, weights: FloatArray) -> float:
    """Return the weighted median; NaN without weight."""
    order = np.argsort(values)
    summed = np.cumsum(weights[order])
    if len(summed) == 0 or summed[-1] == 0.0:
        return float('nan')
    return float(values[order][np.searchsorted(summed, 0.5 * summed[-1])])
