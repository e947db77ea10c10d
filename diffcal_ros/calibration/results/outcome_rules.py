# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a fit ended, and what a person should know before using its numbers."""

from collections.abc import Sequence

from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import FittedParameter
from diffcal_ros.calibration.uncertainty.uncertainty import Uncertainty
from diffcal_ros.least_squares.levenberg_marquardt import Minimum, Stop
import numpy as np

# A fit that leaves more than this, or covers less in either direction, calls for an explanation.
_LARGE_GAP = 0.003
_LOW_COVERAGE = 0.90
# Where body and cameras are stated to be, they are not if that is less likely.
_HARDLY_POSSIBLE = 1e-4
# Of a body that is found, more is seen where it is rendered.
_FOUND = 0.10
_STRONG_CORRELATION = 0.95
_RESTING_RATIO = "a body at rest shows only the ratio of Young's modulus to density"
_MOVING_RATIOS = (
    "motion under gravity shows only the ratios of Young's modulus and damping to density: weigh "
    'the body and give its density a prior, or keep density fixed'
)


def leaves_body_out(gap: Gap) -> bool:
    """Tell whether a part of the simulated or of the measured body has no counterpart."""
    return gap.coverage_in_sight < _LOW_COVERAGE or gap.explained < _LOW_COVERAGE


def judge(
    minimum: Minimum,
    gap: Gap,
    fitted: Sequence[FittedParameter],
    uncertainty: Uncertainty,
    *,
    is_ambiguous: bool = False,
    placement: float = 1.0,
) -> Outcome:
    """Say how a fit ended.

    Args:
        minimum: where the optimiser stopped.
        gap: there, in both directions.
        fitted: values and errors.
        uncertainty: of them.
        is_ambiguous: another minimum explains the data about as well.
        placement: chance of placement and poses under what is stated of them.
    """
    if minimum.stop is Stop.INTERRUPTED:
        return Outcome.INTERRUPTED
    if minimum.stop is Stop.STUCK or not np.isfinite(gap.median) or gap.coverage < _FOUND:
        return Outcome.DIVERGED
    asked = {p.name for p in fitted if not p.is_nuisance}
    if asked & set(uncertainty.blind):
        return Outcome.NOT_IDENTIFIABLE
    if minimum.stop is Stop.EXHAUSTED:
        return Outcome.NOT_CONVERGED
    if any(p.at_bound and not p.is_nuisance for p in fitted):
        return Outcome.AT_BOUND
    if gap.median > _LARGE_GAP or leaves_body_out(gap) or placement < _HARDLY_POSSIBLE:
        return Outcome.MODEL_DISAGREES
    return Outcome.AMBIGUOUS if is_ambiguous else Outcome.CONVERGED


def warn(
    gap: Gap,
    fitted: Sequence[FittedParameter],
    uncertainty: Uncertainty,
    *,
    placement: float = 1.0,
) -> list[str]:
    """List what a person should know before using the numbers; arguments as of `judge`."""
    warnings = []
    if uncertainty.blind:
        warnings.append(f'the data cannot tell apart: {", ".join(uncertainty.blind)}')
        kinds = {name.partition('.')[0] for name in uncertainty.blind}
        if {'youngs_modulus', 'density'} <= kinds:
            warnings.append(_MOVING_RATIOS if 'damping' in kinds else _RESTING_RATIO)
    if uncertainty.prior_bound:
        names = ', '.join(uncertainty.prior_bound)
        warnings.append(f'known more from its prior than from the data: {names}')
    warnings.extend(
        f'{p.name} stopped at its bound {p.value:.4g} {p.unit}' for p in fitted if p.at_bound
    )
    warnings.extend(
        f'the mesh is coarse for {p.name}: halving it would move the value by about '
        f'{100.0 * p.mesh_error / abs(p.value):.0f} %'
        for p in fitted
        if p.name.startswith('youngs_modulus') and p.mesh_error > 0.1 * abs(p.value)
    )
    if np.isfinite(gap.median) and gap.median > _LARGE_GAP:
        warnings.append(f'a median gap of {1e3 * gap.median:.1f} mm is left on the body')
    if placement < _HARDLY_POSSIBLE:
        warnings.append(
            'body or camera stand where the scene says that they are not (chance '
            f'{placement:.0e}): correct placement, poses, or the standard deviations stated of '
            'them (rigid_offset, pose); a wrong pose can look like another modulus'
        )
    if gap.coverage_in_sight < _LOW_COVERAGE:
        warnings.append(
            f'only {gap.coverage_in_sight:.0%} of the rendered body was found in the depth image'
        )
    if gap.explained < _LOW_COVERAGE:
        warnings.append(
            f'{1.0 - gap.explained:.0%} of the measured body lies beside the rendered one: it may '
            'have slid along itself, or the mesh lacks a part of it'
        )
    warnings.extend(_strong_pairs(fitted, uncertainty))
    return warnings


def _strong_pairs(fitted: Sequence[FittedParameter], uncertainty: Uncertainty) -> list[str]:
    asked = [index for index, p in enumerate(fitted) if not p.is_nuisance]
    return [
        f'{fitted[i].name} and {fitted[j].name} are hard to tell apart '
        f'(correlation {uncertainty.correlation[i, j]:+.2f})'
        for i in asked
        for j in asked
        if i < j and abs(uncertainty.correlation[i, j]) > _STRONG_CORRELATION
    ]
