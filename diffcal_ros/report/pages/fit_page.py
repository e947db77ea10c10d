# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The report of a calibration: one page that needs nothing else."""

from dataclasses import replace
from html import escape
import math
from pathlib import Path
from typing import Any

from diffcal_ros import __version__
from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.field.fit import FieldFit
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import CalibrationResult, FittedParameter
from diffcal_ros.report.figures.along_body import along_body
from diffcal_ros.report.figures.along_body_figure import along_body_figure
from diffcal_ros.report.figures.convergence_figure import convergence_figure
from diffcal_ros.report.figures.depth_figure import depth_figure, depth_range, RESIDUAL_LIMIT
from diffcal_ros.report.figures.figure_png import figure_html
from diffcal_ros.report.figures.gap_over_time import gap_over_time_figure, motion_gaps
from diffcal_ros.report.figures.observed_view import observed_views, ObservedView
from diffcal_ros.report.figures.profile_figure import profile_figure
from diffcal_ros.report.naming import is_material, shown, title
from diffcal_ros.report.pages.alternatives import alternatives_section
from diffcal_ros.report.pages.field_section import field_section
from diffcal_ros.report.pages.page_style import document
from diffcal_ros.report.tables.effective_table import effective_section
from diffcal_ros.report.tables.page_tables import (
    correlation_table,
    details_table,
    interval_ends,
    number_text,
    parameter_table,
    plain,
    share_table,
)
from diffcal_ros.report.tables.result_table import profile_lines
import numpy as np

_PROFILE_CAPTION = (
    'The best fit with one parameter held: where the line passes 1, the 95 % interval ends. '
    'Dashed: the parabola of the curvature.'
)
_GOOD = (Outcome.CONVERGED,)
_CARE = (
    Outcome.AT_BOUND,
    Outcome.MODEL_DISAGREES,
    Outcome.AMBIGUOUS,
    Outcome.INTERRUPTED,
)


def write_report(
    path: Path,
    calibration: Calibration,
    result: CalibrationResult,
    field: FieldFit | None = None,
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: HTML file.
        calibration: that made the result; its model knows start and end.
        result: what it found.
        field: a modulus that varies over the body, with which the result was found.

    Raises:
        InputError: when the file cannot be written.
    """
    views = observed_views(calibration, result)
    name = escape(calibration.scene.name)
    sections = [
        _headline(name, result),
        _warnings(result),
        alternatives_section(calibration, result),
        _pictures(calibration, views),
        field_section(calibration, field) if field is not None else '',
        _over_time(calibration, result),
        _remaining_gap(calibration, views),
        _convergence(result),
        _parameters(calibration, result),
        effective_section(result),
        _inputs(calibration, result),
    ]
    title = f'{calibration.scene.name}: calibration'
    write_text_atomically(path, document(title, ''.join(sections)))


def _headline(name: str, result: CalibrationResult) -> str:
    outcome = result.outcome
    kind = 'good' if outcome in _GOOD else 'care' if outcome in _CARE else 'bad'
    cards = [_parameter_card(p) for p in result.parameters if is_material(p.name)]
    cards.append(_gap_card(result))
    cards.append(
        f'<div class="card outcome {kind}"><div class="label">outcome</div>'
        f'<div class="value">{escape(outcome.value.replace("_", " "))}</div>'
        f'<div class="more">{escape(outcome.remedy)}</div></div>'
    )
    return (
        f'<h1>{name}</h1>\n<p class="soft">Calibration with diffcal {escape(__version__)}: '
        f'{result.iterations} iterations in {result.seconds:.2f} s, '
        f'{escape(result.loss)} loss.</p>\n<div class="cards">{"".join(cards)}</div>\n'
    )


def _parameter_card(parameter: FittedParameter) -> str:
    """Draw the card of one parameter: of a material its own value, then what this mesh needs."""
    own = shown(parameter.value, parameter.std_error, parameter.unit)
    if parameter.has_mesh_correction:
        own = shown(parameter.fine_value, math.nan, parameter.unit)
    value = number_text(replace(own, unit='').text('±'))
    start = shown(parameter.start, 0.0, parameter.unit)
    return (
        f'<div class="card"><div class="label">{escape(title(parameter.name))}</div>'
        f'<div class="value">{value} <small>{escape(own.unit)}</small></div>'
        f'<div class="more">{_interval(parameter)}start: {plain(start.value, start.unit)}</div>'
        '</div>'
    )


def _interval(parameter: FittedParameter) -> str:
    if not np.isfinite(parameter.interval_95).all():
        return ''
    text = f'95 % {" to ".join(interval_ends(parameter))}; '
    if parameter.has_mesh_correction:
        here = shown(parameter.value, parameter.error_in_model, parameter.unit)
        text += f'{number_text(here.text("±"))} makes this mesh right; '
    return text


def _gap_card(result: CalibrationResult) -> str:
    start, end = result.gap_start, result.gap_end
    kept = ''
    if result.gap_held_out is not None:
        kept = f'; {_gap_words("on frames kept from the fit", result.gap_held_out)}'
    return (
        '<div class="card"><div class="label">gap on the body, median</div>'
        f'<div class="value">{_millimetres(end.median)} <small>mm</small></div>'
        f'<div class="more">{_gap_words("at the start", start)}; {_gap_words("now", end)}{kept}'
        '</div></div>'
    )


def _gap_words(when: str, gap: Gap) -> str:
    return (
        f'{when}: {_millimetres(gap.median)} mm, RMS {_millimetres(gap.rms)} mm, '
        f'coverage {gap.coverage:.1%}{_explained_words(gap)}'
    )


def _explained_words(gap: Gap) -> str:
    if not np.isfinite(gap.explained):
        return ''
    return f', {gap.explained:.1%} of the measured body explained'


def _millimetres(length: float) -> str:
    return f'{1e3 * length:.3g}' if np.isfinite(length) else '–'


def _warnings(result: CalibrationResult) -> str:
    notes = [str(note) for note in result.details.get('notes', [])]
    text = ''
    if result.warnings:
        items = ''.join(f'<li>{escape(warning)}</li>' for warning in result.warnings)
        text += f'<ul class="warnings">{items}</ul>\n'
    if notes:
        items = ''.join(f'<li>{escape(note)}</li>' for note in notes)
        text += f'<ul class="soft">{items}</ul>\n'
    return text


def _pictures(calibration: Calibration, views: list[ObservedView]) -> str:
    limits = depth_range(views)
    text = '<h2>Measured and simulated</h2>\n'
    for view in views:
        name = escape(view.observation.name)
        heading = f'<h3>{name}</h3>\n' if len(views) > 1 else ''
        caption = (
            f'{_source(view)} Top: depth, one scale. '
            'Bottom: outlines, and residuals, also in one scale; dark ends of the scale mark '
            f'residuals beyond {RESIDUAL_LIMIT:g} mm, pink marks simulated pixels without a '
            'measured depth, red the measured body that no simulated pixel covers, hatching what '
            'the fit leaves out.'
        )
        if view.fitted.cables:
            caption += ' Lines with dots: cables and their via points.'
        figure = depth_figure(view, limits)
        text += heading + figure_html(figure, f'Depth and residual images of {name}', caption)
    return text


def _source(view: ObservedView) -> str:
    instant = view.observation.instant
    if instant is None:
        return f'{view.observation.frame_count} depth frames made into one.'
    return f'The depth frame {instant.time:.3f} s after the first one.'


def _over_time(calibration: Calibration, result: CalibrationResult) -> str:
    motions = motion_gaps(calibration, result)
    if not motions:
        return ''
    text = '<h2>Frame by frame</h2>\n'
    for motion in motions:
        heading = f'<h3>{escape(motion.name)}</h3>\n' if len(motions) > 1 else ''
        caption = (
            'Each frame is compared at its own stamp. Frames kept from the fit show how well the '
            'others predict them; a gap that grows with time asks for another damping or law.'
        )
        figure = gap_over_time_figure(motion)
        text += heading + figure_html(figure, f'Gap over time of {escape(motion.name)}', caption)
    return text


def _remaining_gap(calibration: Calibration, views: list[ObservedView]) -> str:
    text = '<h2>Where on the body the gap is left</h2>\n'
    for view in views:
        name = escape(view.observation.name)
        along = along_body(calibration, view)
        heading = f'<h3>{name}</h3>\n' if len(views) > 1 else ''
        caption = (
            'Positive: the real body is farther from the camera than the simulated one. '
            'The outline tells of motion across the view, which depth hardly sees.'
        )
        text += heading + figure_html(
            along_body_figure(along), f'Gap along the body of {name}', caption
        )
        text += '<details><summary>As a table, at the fitted values</summary>'
        text += share_table(along.fitted, 'from the clamp') + '</details>\n'
        if len(along.regions) > 1:
            text += share_table(along.regions, 'region')
    return text


def _convergence(result: CalibrationResult) -> str:
    if not result.history:
        return ''
    caption = 'Bars: standard errors at the end.'
    if result.loss == 'robust':
        caption += (
            ' The robust loss is shown under scales that never change; the fit itself weighs by '
            'the noise that it finds on the way.'
        )
    figure = convergence_figure(result)
    return '<h2>Convergence</h2>\n' + figure_html(figure, 'Loss, gap and parameters', caption)


def _parameters(calibration: Calibration, result: CalibrationResult) -> str:
    text = '<h2>Parameters</h2>\n' + parameter_table(
        calibration.parameters, result.parameters, nuisances=False
    )
    if any(p.is_nuisance for p in result.parameters):
        text += (
            '<details><summary>Nuisance parameters, carried along for honest errors</summary>'
            + parameter_table(calibration.parameters, result.parameters, nuisances=True)
            + '</details>\n'
        )
    if result.profiles:
        lines = ''.join(f'<li>{escape(line)}</li>' for line in profile_lines(result))
        text += '<h3>Profile likelihood</h3>\n<p class="soft">Others fitted again at every '
        text += f'value; without the error of the mesh.</p>\n<ul>{lines}</ul>\n'
        text += figure_html(profile_figure(result), 'Likelihood profiles', _PROFILE_CAPTION)
    correlations = correlation_table(result)
    if correlations:
        text += (
            '<h3>Correlation of the errors</h3>\n<p class="soft">Near ±1: the data cannot tell '
            f'the two apart.</p>\n{correlations}'
        )
    return text


def _inputs(calibration: Calibration, result: CalibrationResult) -> str:
    scene = calibration.scene
    known: dict[str, Any] = {
        key: value for key, value in result.details.items() if key not in ('notes',)
    }
    known.setdefault('scene', {'name': scene.name, 'tet_count': scene.mesh.tet_count})
    return f'<h2>Inputs</h2>\n{details_table(known)}\n'
