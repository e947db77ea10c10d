# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The report's section on other places at which the model fits: values, gaps and pictures."""

from html import escape

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.results.result import Alternative, CalibrationResult
from diffcal_ros.report.figures.depth_figure import alternative_figure
from diffcal_ros.report.figures.figure_png import figure_html
from diffcal_ros.report.figures.observed_view import views_at
from diffcal_ros.report.naming import is_material, shown, title

_CAPTION = (
    'Measured less simulated, in the scale of the residuals below. Red: measured body that no '
    'simulated pixel covers; pink: simulated body that was not measured.'
)


def alternatives_section(calibration: Calibration, result: CalibrationResult) -> str:
    """Write the section; empty where the answer is the only one."""
    if not result.alternatives:
        return ''
    head = ''.join(f'<th>{escape(title(p.name))}</th>' for p in _asked(result))
    rows = ''.join(_row(result, own) for own in (None, *result.alternatives))
    text = (
        '<h2>Other answers</h2>\n<p class="soft">Fits from other starts that ended elsewhere. '
        'The misfit is half chi-square above that of the answer: below 4.5 nothing tells two '
        f'apart.</p>\n<table><tr><th></th>{head}<th>median [mm]</th><th>RMS [mm]</th>'
        f'<th>coverage</th><th>explained</th><th>misfit above</th></tr>{rows}</table>\n'
    )
    for number, own in enumerate(result.alternatives, start=1):
        for view in views_at(calibration, own.values):
            name = f'answer {number + 1}, {view.observation.name}'
            text += figure_html(alternative_figure(view), escape(f'Residual of {name}'), _CAPTION)
    return text


def _asked(result: CalibrationResult):  # type: ignore[no-untyped-def]
    return [p for p in result.parameters if not p.is_nuisance and is_material(p.name)]


def _row(result: CalibrationResult, own: Alternative | None) -> str:
    cells = []
    for p in _asked(result):
        pair = (p.value, p.std_error)
        if own is not None:
            pair = (own.values[p.name], own.std_errors[p.name])
        cells.append(escape(shown(*pair, p.unit).text('±')))
    gap = result.gap_end if own is None else own.gap
    if own is None:
        word = 'the answer'
    else:
        word = 'about as good' if own.is_as_good else 'worse'
    cells += [f'{1e3 * gap.median:.3g}', f'{1e3 * gap.rms:.3g}']
    cells += [f'{gap.coverage:.1%}', f'{gap.explained:.1%}']
    cells.append('0' if own is None else f'{own.misfit:.3g}')
    return f'<tr><td>{word}</td>{"".join(f"<td>{cell}</td>" for cell in cells)}</tr>'
