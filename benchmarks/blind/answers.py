# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One case's answer beside its label."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.blind.conventions import true_components

CONFIDENT = 0.8
_NORMAL_95 = 1.96


@dataclass(frozen=True)
class Answer:
    """A verdict and what is true.

    Attributes:
        label: of the case.
        verdict: content of the workflow's verdict.json.
    """

    label: Mapping[str, Any]
    verdict: Mapping[str, Any]

    @property
    def truth(self) -> tuple[str, ...]:
        """Identifiers of the true effects."""
        return tuple(effect['identifier'] for effect in self.label['effects'])

    @property
    def is_alarm(self) -> bool:
        """Whether the workflow says that something is missing."""
        return bool(self.verdict['verdict'] == 'disagree')

    @property
    def is_unknown(self) -> bool:
        """Whether it says that the missing effect is none of its library."""
        return self.is_alarm and self.is_told_unknown

    @property
    def is_told_unknown(self) -> bool:
        """Whether it says so, be what is missing below the margin."""
        is_unnamed = not self.verdict.get('effects')
        has_gap = self.verdict['verdict'] in ('disagree', 'below_margin')
        return has_gap and is_unnamed and bool(self.verdict.get('unknown_class'))

    @property
    def named(self) -> tuple[str, ...]:
        """Effects that it names without offering another in their place."""
        return self.told if self.is_alarm else ()

    @property
    def told(self) -> tuple[str, ...]:
        """The same, also where it says that what they do is too small to matter."""
        effects = tuple(effect['identifier'] for effect in self.verdict.get('effects') or ())
        others = set(self.verdict.get('ambiguity_set') or ()) - set(effects)
        return () if others else effects

    @property
    def reported(self) -> set[str]:
        """Every effect that it names or does not rule out."""
        named = {effect['identifier'] for effect in self.verdict.get('effects') or ()}
        return named | set(self.verdict.get('ambiguity_set') or ())

    @property
    def column(self) -> str:
        """Column of the confusion matrix."""
        if self.verdict['verdict'] == 'agree':
            return 'agree'
        if self.named:
            return self.named[0]
        return 'unknown' if self.is_unknown else 'abstain'

    @property
    def is_right(self) -> bool:
        """Whether exactly the true effects are named."""
        return bool(self.truth) and set(self.named) == set(self.truth)

    @property
    def is_told_right(self) -> bool:
        """Whether exactly the true effects are named, be they below the margin."""
        return bool(self.truth) and set(self.told) == set(self.truth)

    @property
    def is_confidently_wrong(self) -> bool:
        """Whether an effect that is not there is named with confidence."""
        if not self.named:
            return False
        return any(
            effect['identifier'] not in self.truth
            and float(effect.get('confidence') or 0.0) >= CONFIDENT
            for effect in self.verdict['effects']
        )

    def times_detectable(self) -> float | None:
        """Return amplitude over the smallest detectable one; None where it was not published."""
        ratios = self.verdict.get('times_detectable') or {}
        values = [ratios.get(name) for name in self.truth]
        known = [float(value) for value in values if value is not None]
        return min(known) if known and len(known) == len(values) else None

    def largest_cosine(self) -> float | None:
        """Return the true effect's largest cosine to another; None where not published."""
        cosines = self.verdict.get('largest_cosine') or {}
        values = [cosines[name] for name in self.truth if name in cosines]
        return max(values) if values else None

    def modulus_errors(self) -> tuple[float, float] | None:
        """Return the relative error of E before and after the effect was added."""
        true = self.label['parameters']['youngs_modulus']
        parameters = self.verdict.get('parameters') or {}
        found = [_modulus(parameters.get(when) or {}) for when in ('before', 'after')]
        if found[0] is None or found[1] is None:
            return None
        return abs(found[0] / true - 1.0), abs(found[1] / true - 1.0)

    def amplitude_score(self) -> tuple[float, list[bool]] | None:
        """Return relative error and what the 95 % intervals cover, of a rightly named effect.

        A component that the verdict leaves out is one that it takes for absent.
        """
        if not self.is_right or len(self.truth) != 1:
            return None
        effect = self.verdict['effects'][0]
        true = true_components(self.label, effect)
        found = {name: float(effect['amplitude'].get(name, 0.0)) for name in true}
        spread = effect.get('std_error') or {}
        covered = [
            abs(found[name] - true[name]) <= _NORMAL_95 * float(spread.get(name, 0.0))
            for name in true
        ]
        return _relative_error(self.label, true, found), covered if spread else []


def _modulus(parameters: Mapping[str, Any]) -> float | None:
    for name, value in parameters.items():
        if name.startswith('youngs_modulus'):
            return float(value['value'] if isinstance(value, Mapping) else value)
    return None


def _relative_error(
    label: Mapping[str, Any], true: Mapping[str, float], found: Mapping[str, float]
) -> float:
    """Return the error of each vector by its size, averaged over vectors of different units."""
    amplitude = label['effects'][0]['amplitude']
    if 'lift' in amplitude:
        return abs(found['height'] - true['height']) / float(amplitude['lift'])
    errors = []
    for names in _vectors(true):
        size = np.linalg.norm([true[name] for name in names])
        errors.append(np.linalg.norm([found[name] - true[name] for name in names]) / size)
    return float(np.mean(errors))


def _vectors(true: Mapping[str, float]) -> list[list[str]]:
    """Group components that have one unit: shifts, turns, and all of most effects."""
    if 'scale' in true:
        return [['scale'], ['bias']]
    turns = [name for name in true if name.startswith('r') and name[1:] in ('x', 'y', 'z')]
    return [names for names in ([n for n in true if n not in turns], turns) if names]
