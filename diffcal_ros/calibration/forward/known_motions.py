# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The latest motions of a body with their tangents: models of other parameters ask for the same.

A fit, its mesh error, the fit of patches and the screening stand at the same place one after the
other, each with a model of its own.
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import fields, is_dataclass
from typing import Generic, TypeVar

from diffcal_ros.fem.statics.force_changes import Change
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
States = TypeVar('States')
Value = TypeVar('Value')

# A fit goes back and forth between two places.
_KEPT = 2
# Tangents of larger motions are found again [bytes].
_MOST_BYTES = 64_000_000


def fingerprint(value: object) -> Hashable:
    """Return what two values have in common when all numbers in them are the same.

    Args:
        value: dataclasses, tuples, lists and mappings of arrays, numbers and names. Anything else
            is the same as itself only.
    """
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    if is_dataclass(value) and not isinstance(value, type):
        return type(value), tuple(fingerprint(getattr(value, own.name)) for own in fields(value))
    if isinstance(value, tuple | list):
        return tuple(fingerprint(own) for own in value)
    if isinstance(value, dict):
        return tuple((key, fingerprint(own)) for key, own in value.items())
    return value if isinstance(value, Hashable) else _Itself(value)


class _Itself:
    """Something that is the same as itself only, kept so that nothing else takes its place."""

    def __init__(self, value: object) -> None:
        self._value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Itself) and other._value is self._value

    def __hash__(self) -> int:
        return id(self._value)


class KnownMotions(Generic[States]):
    """Keeps what is costly to find, by what it depends on."""

    def __init__(self) -> None:
        self._states: dict[Hashable, States] = {}
        self._tangents: dict[Hashable, dict[Hashable, FloatArray]] = {}

    def states(self, key: Hashable, find: Callable[[], States]) -> States:
        """Return the states of a key, found where they are not known.

        Args:
            key: what they depend on.
            find: simulates them.
        """
        found = self._states.pop(key) if key in self._states else find()
        _keep(self._states, key, found)
        return found

    def tangents(
        self,
        key: Hashable,
        changes: Sequence[Change],
        find: Callable[[Sequence[Change]], FloatArray],
    ) -> FloatArray:
        """Return how the states of a key follow changes, shape (k, S, N, 3).

        Args:
            key: what the states depend on.
            changes: of that.
            find: follows those that are not known, all at once.
        """
        known = self._tangents.pop(key, {})
        names = [fingerprint(change) for change in changes]
        missing = {n: c for n, c in zip(names, changes, strict=True) if n not in known}
        if missing:
            known.update(zip(missing, find(list(missing.values())), strict=True))
        found = np.stack([known[name] for name in names])
        if sum(field.nbytes for field in known.values()) <= _MOST_BYTES:
            _keep(self._tangents, key, known)
        return found


def _keep(kept: dict[Hashable, Value], key: Hashable, value: Value) -> None:
    """Keep a value as the latest one, and let the oldest go."""
    kept[key] = value
    if len(kept) > _KEPT:
        del kept[next(iter(kept))]
