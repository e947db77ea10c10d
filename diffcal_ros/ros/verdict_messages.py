# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A verdict as a message that every viewer reads."""

from diagnostic_msgs.msg import DiagnosticArray
from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis, NamedEffect
from diffcal_ros.live.health import Health, Level
from diffcal_ros.report.tables.verdict_text import effect_words, verdict_lines
from diffcal_ros.ros.diagnostics import status_message
from std_msgs.msg import Header

VERDICT = 'verdict'


def verdict_message(diagnosis: Diagnosis, header: Header) -> DiagnosticArray:
    """Put a verdict into one stamped snapshot: the whole first, then each effect by name.

    Args:
        diagnosis: the verdict.
        header: of the newest frame used.
    """
    message = DiagnosticArray(header=header)
    healths = [
        (VERDICT, _whole(diagnosis)),
        *((e.identifier, _effect(e)) for e in diagnosis.effects),
    ]
    message.status = [status_message(name, health) for name, health in healths]
    return message


def _whole(diagnosis: Diagnosis) -> Health:
    gap = diagnosis.gap_mm
    level = Level.OK if diagnosis.verdict is Verdict.AGREE else Level.WARN
    return Health(
        level,
        verdict_lines(diagnosis)[0],
        {
            'verdict': diagnosis.verdict.value,
            'evidence': diagnosis.evidence.value,
            'p_value': f'{diagnosis.p_value:.3g}',
            'effects': ', '.join(e.identifier for e in diagnosis.effects),
            'ambiguity_set': ', '.join(diagnosis.ambiguity_set),
            'unknown_class': diagnosis.unknown_class or '',
            'separating_recording': diagnosis.separating_recording or '',
            'where': diagnosis.where,
            'gap_nominal_mm': f'{gap.nominal:.4f}',
            'gap_added_mm': f'{gap.added:.4f}',
            'floor_sensor_mm': f'{gap.floor_sensor:.4f}',
            'floor_numerics_mm': f'{gap.floor_numerics:.4f}',
            'closure': f'{diagnosis.closure:.4f}',
        },
    )


def _effect(effect: NamedEffect) -> Health:
    values = {'group': effect.group, 'confidence': f'{effect.confidence:.3f}'}
    for name, value in effect.amplitude.items():
        values[f'{name} [{effect.unit[name]}]'] = f'{value:.6g}'
        values[f'{name} std_error [{effect.unit[name]}]'] = f'{effect.std_error[name]:.6g}'
    values.update({name: f'{value:g}' for name, value in effect.setting.items()})
    return Health(Level.WARN, effect_words(effect), values)
