# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted field in the report and on a terminal."""

from html import escape

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.field.fit import FieldFit
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.report.figures.field_figure import field_figure
from diffcal_ros.report.figures.figure_png import figure_html
from diffcal_ros.report.tables.page_tables import plain, table
import numpy as np


def field_section(calibration: Calibration, field: FieldFit) -> str:
    """Write the section: the drawing, and what each weight of the roughness gave."""
    caption = (
        f'{escape(field.kind.describe().capitalize())}, {field.unknown_count} unknowns. What '
        f'decided how smooth it is: {escape(field.weights.reason)}. A smooth field blurs a sudden '
        'change of material, and draws it too small rather than too large.'
    )
    header = ['weight', 'misfit', 'roughness', 'gap, median', 'gap, RMS', 'coverage', '']
    rows = [
        [
            plain(trial.fraction),
            plain(trial.misfit),
            plain(trial.roughness),
            f'{1e3 * trial.gap.median:.3f} mm',
            f'{1e3 * trial.gap.rms:.3f} mm',
            f'{trial.gap.coverage:.1%}',
            'taken' if number == field.weights.chosen else '',
        ]
        for number, trial in enumerate(field.weights.trials)
    ]
    return (
        "<h2>Young's modulus over the body</h2>\n"
        + figure_html(field_figure(calibration, field), "Young's modulus on the body", caption)
        + '<details><summary>Weights of the roughness that were tried</summary>'
        + table(header, rows)
        + '</details>\n'
    )


def field_text(field: FieldFit) -> str:
    """Write the field in a few lines."""
    low, middle, high = 1e-3 * np.percentile(field.youngs_modulus, [5.0, 50.0, 95.0])
    before, after = field.uniform.gap_end, field.result.gap_end
    fraction = field.weights.trials[field.weights.chosen].fraction
    return (
        f'field       {field.kind.describe()}, {field.unknown_count} unknowns, '
        f'weight {fraction:.2g}: {field.weights.reason}\n'
        f"            Young's modulus 5 % {low:.3g}, median {middle:.3g}, 95 % {high:.3g} kPa, "
        f'error a factor {np.exp(np.median(field.log_std)):.2f}\n'
        f'            without it: {_gap(before)}\n            with it:    {_gap(after)}\n'
    )


def _gap(gap: Gap) -> str:
    return (
        f'gap median {1e3 * gap.median:.3g} mm, RMS {1e3 * gap.rms:.3g} mm on '
        f'{gap.coverage:.1%} of the body in view'
    )
