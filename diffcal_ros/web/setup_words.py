# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the set-up page says, in Markdown."""

from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.result import CalibrationResult, IterationRecord
from diffcal_ros.report.naming import short_values, shown, title
from diffcal_ros.web.fit_words import gap_words
import numpy as np

COARSE = 'quick simulation with linear elements, which are too stiff; the right one follows'
FINE = "simulated with the scene's own elements"


def trial_words(gap: Gap | None, *, is_coarse: bool) -> str:
    """Say how far an arranged body is from what was measured, and how it was simulated."""
    how = COARSE if is_coarse else FINE
    if gap is None or gap.pixels == 0:
        return f'**Nothing measured lies on the body.**\n\n{how}'
    return f'**Gap {1e3 * gap.median:.3g} mm** (median) on {gap.coverage:.0%} of it\n\n{how}'


def step_words(record: IterationRecord) -> str:
    """Say where a fit is."""
    gap = record.gap
    words = 'body not found' if gap.pixels == 0 else f'gap {1e3 * gap.median:.2f} mm'
    return f'step {record.number}: {words}, {short_values(record.values)}'


def fitted_words(result: CalibrationResult) -> str:
    """Say what a fit found."""
    outcome = result.outcome
    modulus = result['youngs_modulus']
    values = {own.name: own.value for own in result.parameters}
    shift = np.linalg.norm([values.get(f'rigid_offset.{axis}', 0.0) for axis in 'xyz'])
    lines = [
        f'**{outcome.value.replace("_", " ")}**: {outcome.remedy}',
        f'{title(modulus.name)} {shown(modulus.value, modulus.std_error, modulus.unit).text("±")}'
        f', body shifted by {1e3 * float(shift):.2g} mm (blue)',
        gap_words(result.gap_end.as_dict()),
    ]
    return '\n\n'.join(lines)
