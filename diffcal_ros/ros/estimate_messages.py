# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fitted parameters as messages that every plotter and viewer reads."""

from collections.abc import Iterator, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.result import (
    CalibrationResult,
    FittedParameter,
    IterationRecord,
)
from diffcal_ros.calibration.tracking.body_change import BodyChange
from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.tasks.track_task import TrackStep
from diffcal_ros.live.tracking import in_words
from diffcal_ros.ros.conversion import header_message
from diffcal_ros.ros.diagnostics import status_message
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import Float64MultiArray, Header, MultiArrayDimension, MultiArrayLayout

FloatArray = NDArray[np.float64]

_MATERIAL = (('youngs_modulus', 'Pa'), ('poissons_ratio', '1'), ('density', 'kg/m^3'))
TRACKING = 'tracking'
FIT = 'fit'  # Name of the status that tells how the fit itself stands.


def estimates_message(
    scene: Scene,
    parameters: Sequence[FittedParameter],
    record: IterationRecord,
    result: CalibrationResult | None,
    header: Header,
) -> DiagnosticArray:
    """Put all that is known after a step into one stamped snapshot.

    Args:
        scene: gives what is not fitted.
        parameters: fitted ones.
        record: of the last step.
        result: at the end; None before.
        header: of the newest frame used.
    """
    message = DiagnosticArray(header=header)
    stage = f'iteration {record.number}' if result is None else result.outcome.value
    healths = [
        (FIT, _fit_health(record, result, stage)),
        *((p.name, _parameter_health(p, stage)) for p in parameters),
        *_fixed(scene, {p.name for p in parameters}),
    ]
    message.status = [status_message(name, health) for name, health in healths]
    return message


def tracked_message(
    scene: Scene, step: TrackStep, change: BodyChange | None, change_count: int
) -> DiagnosticArray:
    """Put all that is known after a frame into one stamped snapshot.

    Args:
        scene: gives what is not fitted.
        step: of the newest frame.
        change: of the body, the last one.
        change_count: changes so far.
    """
    tracked = step.tracked
    message = DiagnosticArray(header=header_message(tracked.stamp_ns, step.frame_id))
    values = {
        'frame': str(step.number),
        'loss': f'{tracked.cost:.9g}',
        **_gap_values(tracked.gap),
        'frames_worth': f'{tracked.frames_worth:.6g}',
        'used': str(tracked.is_taken).lower(),
        'found': str(tracked.is_found).lower(),
        'changes': str(change_count),
        'change': '' if change is None else in_words(change),
        'outcome': TRACKING,
    }
    level = Level.OK if tracked.is_found else Level.WARN
    healths = [
        (FIT, Health(level, TRACKING, values)),
        *((p.name, _parameter_health(p, TRACKING)) for p in tracked.parameters),
        *_fixed(scene, {p.name for p in tracked.parameters}),
    ]
    message.status = [status_message(name, health) for name, health in healths]
    return message


def change_message(change: BodyChange, count: int, frame_id: str) -> DiagnosticArray:
    """Tell of a change of the body: one status a parameter that changed.

    Args:
        change: what was seen.
        count: changes so far, this one included.
        frame_id: optical frame of the depth images.
    """
    message = DiagnosticArray(header=header_message(change.stamp_ns, frame_id))
    summary = {
        'number': str(count),
        'sudden': str(change.is_sudden).lower(),
        'gap_median_before_mm': f'{1e3 * change.gap_before:.6g}',
        'gap_median_after_mm': f'{1e3 * change.gap_after:.6g}',
    }
    healths = [('change', Health(Level.WARN, in_words(change), summary))]
    for name, before in change.before.items():
        values = {'before': f'{before:.9g}', 'after': f'{change.after[name]:.9g}'}
        healths.append((name, Health(Level.WARN, 'changed', values)))
    message.status = [status_message(name, health) for name, health in healths]
    return message


def covariance_message(
    parameters: Sequence[FittedParameter], correlation: FloatArray
) -> Float64MultiArray:
    """Return the covariance of all parameters in SI units; each axis is labelled with names."""
    errors = np.array([p.std_error for p in parameters])
    covariance = correlation * np.outer(errors, errors)
    names = ','.join(p.name for p in parameters)
    count = len(errors)
    axes = [
        MultiArrayDimension(label=names, size=count, stride=count * count),
        MultiArrayDimension(label=names, size=count, stride=count),
    ]
    return Float64MultiArray(layout=MultiArrayLayout(dim=axes), data=covariance.ravel().tolist())


def topic_of(parameter_name: str) -> str:
    """Return a parameter's part of a topic name: `youngs_modulus.tip` → `youngs_modulus/tip`."""
    tokens = parameter_name.split('.')
    # A token of a topic name must not start with a digit.
    return '/'.join(f'_{token}' if token[:1].isdigit() else token for token in tokens)


def _fit_health(record: IterationRecord, result: CalibrationResult | None, stage: str) -> Health:
    values = {
        'iteration': str(record.number),
        'loss': f'{record.loss:.9g}',
        **_gap_values(record.gap),
        'seconds': f'{record.seconds:.3f}',
        'outcome': 'running' if result is None else result.outcome.value,
    }
    if result is None:
        return Health(Level.OK, stage, values)
    values['remedy'] = result.outcome.remedy
    values['warnings'] = '; '.join(result.warnings)
    return Health(Level.OK if result.outcome.is_usable else Level.WARN, stage, values)


def _gap_values(gap: Gap) -> dict[str, str]:
    return {
        'gap_median_mm': f'{1e3 * gap.median:.6g}',
        'gap_rms_mm': f'{1e3 * gap.rms:.6g}',
        'coverage': f'{gap.coverage:.6g}',
        'explained': f'{gap.explained:.6g}',
        'hidden': f'{gap.hidden:.6g}',
        'pixels': str(gap.pixels),
    }


def _parameter_health(parameter: FittedParameter, stage: str) -> Health:
    return Health(
        Level.WARN if parameter.at_bound else Level.OK,
        f'at its bound, {stage}' if parameter.at_bound else stage,
        {
            'value': f'{parameter.value:.9g}',
            'std_error': f'{parameter.std_error:.9g}',
            'low_95': f'{parameter.interval_95[0]:.9g}',
            'high_95': f'{parameter.interval_95[1]:.9g}',
            'unit': parameter.unit,
            'fixed': 'false',
            'at_bound': str(parameter.at_bound).lower(),
            'start': f'{parameter.start:.9g}',
            'nuisance': str(parameter.is_nuisance).lower(),
        },
    )


def _fixed(scene: Scene, fitted: set[str]) -> Iterator[tuple[str, Health]]:
    """Tell the material numbers that are taken as they stand in the scene."""
    for region in scene.regions:
        for kind, unit in _MATERIAL:
            name = kind if len(scene.regions) == 1 else f'{kind}.{region.name}'
            if name not in fitted:
                value = getattr(region, kind).start
                yield (
                    name,
                    Health(
                        Level.OK,
                        'as in the scene',
                        {
                            'value': f'{value:.9g}',
                            'std_error': '0',
                            'unit': unit,
                            'fixed': 'true',
                            'at_bound': 'false',
                            'start': f'{value:.9g}',
                            'nuisance': 'false',
                        },
                    ),
                )
