# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A verdict in seven lines."""

from collections.abc import Mapping, Sequence
import math

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis, NamedEffect
from diffcal_ros.effects import picture_edge, spots, surface_parts
from diffcal_ros.effects.registry import EFFECTS, what_settles
from diffcal_ros.report.naming import shown, title

_WORDS = {
    Verdict.AGREE: 'AGREE',
    Verdict.DISAGREE: 'DISAGREE',
    Verdict.BELOW_MARGIN: 'SMALL',
    Verdict.CANNOT_TELL: 'UNSURE',
}
_WIDTH = 10
# Parameters whose change a person asks for first.
_MATERIAL = ('youngs_modulus', 'density')
# Effects of which it is told by how much they may draw a parameter.
_MOST_DRAWN = 3
# Of a share that is larger nothing is known.
_ANY = 10.0


def verdict_lines(diagnosis: Diagnosis) -> list[str]:
    """Write what a person should read first: one line a question."""
    lines = [_gap_line(diagnosis), *_name_lines(diagnosis)]
    if diagnosis.runner_up is not None:
        lines.append(_line('NEXT', diagnosis.runner_up))
    if diagnosis.ambiguity_set:
        gap = diagnosis.gap_mm
        words = f'held-out RMS {gap.nominal:.2f} -> {gap.added:.2f} mm'
        words += f', median {gap.median_nominal:.2f} -> {gap.median_added:.2f}'
        if diagnosis.closure == diagnosis.closure:
            words += f': {max(diagnosis.closure, 0.0):.0%} of the gap closed'
        lines.append(_line('ADDED', words))
        lines += [_line('FITTED', words) for words in _changes(diagnosis)]
    if diagnosis.effects or diagnosis.verdict is not Verdict.DISAGREE:
        lines += [_line('DRAWN', words) for words in _drawn(diagnosis)]
    if diagnosis.unknown_class is not None:
        lines += [_line('FITTED', words) for words in _not_known(diagnosis)]
    if diagnosis.separating_recording is not None:
        lines.append(_line('CHECK', diagnosis.separating_recording))
    elif diagnosis.effects:
        lines.append(_line('CHECK', what_settles(e.identifier for e in diagnosis.effects)))
    lines += [_line('NOTE', note) for note in diagnosis.notes]
    return lines


def effect_words(effect: NamedEffect) -> str:
    """Write an effect with its amplitudes: `<effect> 4.2 +- 0.3 g at 0.75`."""
    parts = []
    for name, value in effect.amplitude.items():
        own = shown(value, effect.std_error[name], effect.unit[name]).text()
        parts.append(own if len(effect.amplitude) == 1 else f'{name} {own}')
    return f'{effect.identifier} {", ".join(parts)}{_place_words(effect.setting)}'


def _place_words(setting: Mapping[str, float]) -> str:
    if spots.spots_of(setting) is not None:
        return f' on {surface_parts.in_words(setting)}'
    if picture_edge.has_edge(setting):
        return f' {picture_edge.in_words(setting)}'
    if 'until' in setting or surface_parts.SETTINGS.keys() & setting.keys():
        return f' at {surface_parts.in_words(setting)}'
    return ''.join(f' at {value:g} of the length' for value in setting.values())


def _line(word: str, text: str) -> str:
    return f'{word:<{_WIDTH}}{text}'


def _name_lines(diagnosis: Diagnosis) -> list[str]:
    """Say what is missing, what may be, or what may hide."""
    lines = []
    if diagnosis.effects:
        names = ' and '.join(effect_words(effect) for effect in diagnosis.effects)
        confidence = min(effect.confidence for effect in diagnosis.effects)
        groups = ', '.join(dict.fromkeys(effect.group for effect in diagnosis.effects))
        lines.append(_line('NAME', f'{names}   confidence {confidence:.2f}   [{groups}]'))
    elif diagnosis.unknown_class is not None:
        classes = ' or '.join(diagnosis.unknown_classes or (diagnosis.unknown_class,))
        lines.append(_line('NAME', f'unknown effect, most like one of the class {classes}'))
    elif diagnosis.ambiguity_set and diagnosis.verdict is not Verdict.DISAGREE:
        lines.append(_line('NEAREST', ', '.join(diagnosis.ambiguity_set)))
    elif diagnosis.ambiguity_set:
        lines.append(_line('NAME', _one_of(diagnosis.ambiguity_set)))
    elif hidden := _hidden(diagnosis):
        lines.append(_line('HIDDEN', f'at most {hidden} (95 %)'))
    return lines


def _one_of(names: Sequence[str]) -> str:
    """Say which effects it may be, where none of them is sure."""
    return f'one of {", ".join(names)}' if len(names) > 1 else f'{names[0]}, or something else'


def _gap_line(diagnosis: Diagnosis) -> str:
    gap = diagnosis.gap_mm
    chance = 'p < 0.001' if diagnosis.p_value < 0.001 else f'p = {diagnosis.p_value:.3f}'
    when = diagnosis.when
    swing = ''
    if when is not None and when.frequency_hz is not None:
        swing = f'; residuals {when.part} swing at {when.frequency_hz:.1f} Hz'
    return _line(
        _WORDS[diagnosis.verdict],
        f'held-out RMS {gap.nominal:.2f} mm; floor {gap.floor_sensor:.2f} mm sensor, '
        f'{gap.floor_numerics:.2f} mm mesh ({chance}, {diagnosis.evidence.value}); largest '
        f'{diagnosis.where}{swing}',
    )


def _hidden(diagnosis: Diagnosis) -> str:
    """Say how large effects may be that do not stand out, where one number tells."""
    found = []
    for identifier, limits in diagnosis.limits.items():
        effect = EFFECTS[identifier]
        units = {part.shown_unit for part in effect.components}
        largest = max(limits.values())
        if effect.group != 'sensor' and len(units) == 1 and math.isfinite(largest):
            found.append(f'{identifier} {largest:.2g} {units.pop()}')
    return ', '.join(found)


def _drawn(diagnosis: Diagnosis) -> list[str]:
    """Say by how much what does not show may have drawn parameters, where that is more than known.

    A load that hides, and a modulus that has followed it, look as if there were none.
    """
    lines, told = [], diagnosis.parameters['after' if diagnosis.effects else 'before']
    for name, by_effect in diagnosis.drawn.items():
        known = told[name]
        error = float(known['std_error']) / float(known['value'])
        most = sorted(by_effect.items(), key=lambda own: -own[1])[:_MOST_DRAWN]
        by = [f'{_share(own)} ({effect})' for effect, own in most if own > 2.0 * error]
        if by:
            lines.append(f'{title(name)} by what does not show, at most {", ".join(by)} (95 %)')
    return lines


def _share(share: float) -> str:
    return f'{share:.0%}' if share < _ANY else 'any amount'


def _not_known(diagnosis: Diagnosis) -> list[str]:
    """Say which parameters may be anything as long as what is missing has no name."""
    return [
        f'{title(name)} {shown(float(old["value"]), 0.0, str(old["unit"])).text()} is that of a '
        'model that lacks something: not known'
        for name, old in diagnosis.parameters['before'].items()
        if name.partition('.')[0] in _MATERIAL
    ]


def _changes(diagnosis: Diagnosis) -> list[str]:
    before, after = diagnosis.parameters['before'], diagnosis.parameters['after']
    lines = []
    for name, old in before.items():
        if name not in after or name.partition('.')[0] not in _MATERIAL:
            continue
        new = after[name]
        unit = str(old['unit'])
        start = shown(float(old['value']), 0.0, unit)
        end = shown(float(new['value']), float(new['std_error']), unit)
        lines.append(f'{title(name)} {start.value:.4g} -> {end.text()}')
    return lines
