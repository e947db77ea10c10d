# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One case's answer beside its label."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

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
        is_unnamed = not self.verdict.get('effects')
        return self.is_alarm and is_unnamed and bool(self.verdict.get('unknown_class'))

    @property
    def named(self) -> tuple[str, ...]:
        """Effects that it names without offering another in their place."""
        if not self.is_alarm or len(self.verdict.get('ambiguity_set') or ()) > 1:
            return ()
        return tuple(effect['identifier'] for effect in self.verdict.get('effects') or ())

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
        """Return relative error and what the 95 % intervals cover, of a rightly named effect."""
        if not self.is_right or len(self.truth) != 1:
            return None
        label, effect = self.label['effects'][0], self.verdict['effects'][0]
        names = _compared(label)
        true = np.array([float(label['amplitude'][name]) for name in names])
        found = _components(effect['amplitude'], names)
        spread = _components(effect.get('std_error'), names)
        if found is None:
            return None
        error = _relative_error(label, names, true, found)
        if spread is None:
            return error, []
        return error, (np.abs(found - true) <= _NORMAL_95 * spread).tolist()


def _modulus(parameters: Mapping[str, Any]) -> float | None:
    for name, value in parameters.items():
        if name.startswith('youngs_modulus'):
            return float(value['value'] if isinstance(value, Mapping) else value)
    return None


def _compared(label: Mapping[str, Any]) -> list[str]:
    """Return the components of an amplitude that are scored."""
    if label['identifier'] == 'contact_plane':
        return ['height']
    # The place of an added mass is no size, a mode no number.
    return [name for name in label['amplitude'] if name not in ('at', 'mode')]


def _components(value: Any, names: Sequence[str]) -> Any:
    """Read components by name, in order, or a single number; None where they do not match."""
    if value is None:
        return None
    if isinstance(value, Mapping):
        if all(name in value for name in names):
            return np.array([float(value[name]) for name in names])
        value = list(value.values())
    numbers = np.atleast_1d(np.asarray(value, dtype=float)).ravel()
    return numbers[: len(names)] if len(numbers) >= len(names) else None


def _relative_error(label: Mapping[str, Any], names: list[str], true: Any, found: Any) -> float:
    """Return the error of each vector by its size, averaged over vectors of different units."""
    if label['identifier'] == 'contact_plane':
        return float(1e3 * abs(found[0] - true[0]) / label['amplitude']['lift'])
    if label['identifier'] == 'depth_affine':
        groups = [[0], [1]]
    else:
        heads = [name.split('_')[0] if name[:-2] in ('shift', 'turn') else '' for name in names]
        groups = [[i for i, own in enumerate(heads) if own == head] for head in sorted(set(heads))]
    errors = [np.linalg.norm((found - true)[g]) / np.linalg.norm(true[g]) for g in groups]
    return float(np.mean(errors))
