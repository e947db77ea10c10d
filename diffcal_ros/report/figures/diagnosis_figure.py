# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Figures of a diagnosis: depth measured, and what is left before and after; scores."""

from typing import Any

from diffcal_ros.diagnosis.diagnose import DiagnosisTrace
from diffcal_ros.diagnosis.screening.screening import Screen
from diffcal_ros.report.figure_text import as_text
from diffcal_ros.report.figures.figure_png import new_figure
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_ROW_HEIGHT, _WIDTH = 2.7, 11.0
# The residuals' scale ends at this quantile of the nominal ones, within these [mm].
_QUANTILE = 0.95
_LEAST_LIMIT, _MOST_LIMIT = 0.5, 20.0
_MARGIN = 8
_SHOWN_SCORES = 12
_MOST_VIEWS = 8


def residual_figure(trace: DiagnosisTrace) -> Any:
    """Draw each view: measured depth, nominal residual, residual with what was added."""
    model = trace.evaluator.model
    nominal = trace.evaluator.residual_images(trace.nominal.coordinates)
    best = trace.selection.best if trace.selection is not None else None
    added = nominal
    if best is not None:
        added = best.evaluator.residual_images(best.fit.coordinates)
    limit = _limit(nominal)
    shown = _shown(len(model.observations))
    count = len(shown)
    figure = new_figure(_WIDTH, _ROW_HEIGHT * count + 0.6)
    axes = figure.subplots(count, 3, squeeze=False)
    heads = ('measured', 'left by the model as it was', 'left with what was added')
    for row, number in zip(axes, shown, strict=True):
        observation = model.observations[number]
        window = _window(nominal[number])
        seen = np.where(np.isfinite(nominal[number]), observation.depth.astype(np.float64), np.nan)
        depth = row[0].imshow(1e3 * seen[window], cmap='viridis_r', interpolation='nearest')
        figure.colorbar(depth, ax=row[0], label='depth [mm]', shrink=0.8)
        row[0].set_ylabel(as_text(observation.name))
        for panel, residual in zip(row[1:], (nominal[number], added[number]), strict=True):
            image = panel.imshow(
                1e3 * residual[window],
                cmap='PuOr_r',
                vmin=-limit,
                vmax=limit,
                interpolation='nearest',
            )
        figure.colorbar(image, ax=list(row[1:]), label='measured - simulated [mm]', shrink=0.8)
        for panel in row:
            panel.set_xticks([])
            panel.set_yticks([])
    for panel, head in zip(axes[0], heads, strict=True):
        panel.set_title(head, fontsize=10)
    return figure


def score_figure(screen: Screen) -> Any:
    """Draw the scores of the candidates, best variant of each effect."""
    best: dict[str, float] = {}
    for score in screen.scores:
        best.setdefault(score.candidate.identifier, score.plain_gain / screen.noise_scale)
    names = sorted(best, key=lambda name: best[name])[-_SHOWN_SCORES:]
    figure = new_figure(8.0, 0.32 * len(names) + 1.0)
    panel = figure.subplots()
    panel.barh(names, [max(best[name], 0.5) for name in names], color='#3b82a6')
    panel.set_xscale('log')
    panel.axvline(20.0, color='#b45309', linewidth=1.0)
    panel.set_xlabel('fall of chi-square that it could explain; line: what chance does not give')
    panel.spines[['top', 'right']].set_visible(False)
    return figure


def _shown(count: int) -> list[int]:
    """Return the views to draw: evenly chosen where a motion has many."""
    indices = np.linspace(0, count - 1, min(count, _MOST_VIEWS)).round()
    return [int(index) for index in indices]


def _limit(residuals: list[FloatArray]) -> float:
    sizes = 1e3 * np.abs(np.concatenate([r[np.isfinite(r)] for r in residuals]))
    near = sizes[sizes < 60.0]
    size = float(np.quantile(near, _QUANTILE)) if len(near) else _LEAST_LIMIT
    return float(np.clip(size, _LEAST_LIMIT, _MOST_LIMIT))


def _window(residual: FloatArray) -> tuple[slice, slice]:
    rows, columns = np.nonzero(np.isfinite(residual))
    if len(rows) == 0:
        return slice(None), slice(None)
    return (
        slice(max(int(rows.min()) - _MARGIN, 0), int(rows.max()) + _MARGIN),
        slice(max(int(columns.min()) - _MARGIN, 0), int(columns.max()) + _MARGIN),
    )
