# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The gap: how far the observed surface is from the rendered one, in metres on the body."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.residuals.measured_body import MeasuredShares
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Gap:
    """The figure of merit of a fit.

    Attributes:
        median: of |observed - rendered| over the pixels that count [m].
        rms: of the same [m].
        coverage: share of the rendered, unmasked pixels that count: those with an observed depth
            within the truncation.
        pixels: number of pixels that count.
        explained: share of the measured body that the rendered one covers: of its surface that
            goes on beside the rendered body, see `measured_body`; NaN where it was not measured.
        hidden: share of the rendered, unmasked pixels behind something else that was seen.
    """

    median: float
    rms: float
    coverage: float
    pixels: int
    explained: float = float('nan')
    hidden: float = 0.0

    @property
    def coverage_in_sight(self) -> float:
        """Coverage of what nothing hides."""
        return min(1.0, self.coverage / max(1.0 - self.hidden, 1e-6))

    def as_dict(self) -> dict[str, float | int]:
        """Return the gap for result.json, in millimetres."""
        return {
            'median_mm': 1e3 * self.median,
            'rms_mm': 1e3 * self.rms,
            'coverage': self.coverage,
            'explained': self.explained,
            'hidden': self.hidden,
            'pixels': self.pixels,
        }


def measure_gap(
    residuals: list[FloatArray],
    counted: list[NDArray[np.bool_]],
    truncation: float,
    fractions: Sequence[MeasuredShares] | None = None,
) -> Gap:
    """Measure the gap over all views.

    Args:
        residuals: observed less rendered depth [m], any shape, NaN where nothing was observed.
        counted: rendered, unmasked pixels, same shapes.
        truncation: residuals beyond this belong to something else than the body [m].
        fractions: of what is measured beside the rendered body, one a view; None: not looked for.
    """
    unmasked = sum(int(mask.sum()) for mask in counted)
    kept = [
        np.abs(residual[mask & (np.abs(residual) < truncation)])
        for residual, mask in zip(residuals, counted, strict=True)
    ]
    sizes = np.concatenate(kept) if kept else np.zeros(0)
    if unmasked == 0 or len(sizes) == 0:
        return Gap(float('nan'), float('nan'), 0.0, 0)
    unexplained = sum(fraction.unexplained for fraction in fractions or ())
    return Gap(
        median=float(np.median(sizes)),
        rms=float(np.sqrt(np.mean(sizes**2))),
        coverage=len(sizes) / unmasked,
        pixels=len(sizes),
        explained=float('nan')
        if fractions is None
        else float(len(sizes) / (len(sizes) + unexplained)),
        hidden=float(min(1.0, sum(fraction.hidden for fraction in fractions or ()) / unmasked)),
    )
