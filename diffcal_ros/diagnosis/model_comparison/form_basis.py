# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What effects in other forms may do besides: found once, around a model that fits about."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from diffcal_ros.diagnosis.patch_fits.free_fields import bend_fields
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.strain import unstrained
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import columns_of, PatchGroup, Rows, rows_of
from diffcal_ros.effects.effect import Effect
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What moves patches less than this share of what others of its kind do is hardly seen, and is not
# made as large as they are.
_LEAST = 0.03


@dataclass(frozen=True)
class FormBasis:
    """A model as it is, and what effects in other forms may do to its patches.

    Attributes:
        base: fit of the model as it is, as it would be if nothing strained what is known.
        points: nodes of the body in each view [m], camera frame, shape (N, 3) each.
        besides: by effect, what it may do besides in each pose: tangents by name of the patch.
        bends: what bends at rest do, likewise, the same in all poses.
        known: what was judged by it: the same models are held against others again and again.
    """

    base: Refit
    points: tuple[FloatArray, ...]
    besides: dict[str, Rows]
    bends: Rows
    known: dict[Hashable, Any] = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def of(cls, evaluator: PatchEvaluator, fit: Refit, base: Refit) -> 'FormBasis':
        """Return it: for bodies at rest with what effects may do besides, for motions without.

        Args:
            evaluator: of a model that stands about where the measured body does.
            fit: of it.
            base: fit of the model as it is.
        """
        model, coordinates = evaluator.model, fit.coordinates
        strained = replace(base, groups=unstrained(base))
        points = tuple(view.points for view in model.views(coordinates))
        if model.is_moving:
            return cls(strained, points, {}, {})
        index, posture = next(iter(model.bodies.items()))
        listed = [
            (effect, len(_otherwise(evaluator, effect, index, posture.body)))
            for effect in EFFECTS.values()
        ]

        def changes(index: int, body: StaticBody) -> list[Change]:
            return [c for own, _ in listed for c in _otherwise(evaluator, own, index, body)]

        fields = [
            np.concatenate(own)
            for own in zip(
                model.tangents_of(changes, coordinates),
                bend_fields(model, coordinates),
                strict=True,
            )
        ]
        groups, first = evaluator.groups(coordinates, fields), len(coordinates)
        besides: dict[str, Rows] = {}
        for effect, count in listed:
            if count:
                besides[effect.identifier] = _rows(groups, first, first + count)
            first += count
        return cls(strained, points, besides, _rows(groups, first, None))

    def besides_of(
        self, effect: Effect, groups: Sequence[PatchGroup], moved: Sequence[FloatArray]
    ) -> list[FloatArray]:
        """Return what an effect may do besides in each pose, as large as what it does there.

        Args:
            effect: whose.
            groups: patches.
            moved: what it does to each group [m], shape (n,) each.

        Returns:
            Of each group, shape (n, k).
        """
        columns = columns_of(self.besides.get(effect.identifier, {}), groups)
        found = list(columns)
        for view in {group.view for group in groups}:
            own = [number for number, group in enumerate(groups) if group.view == view]
            scaled = _as_large([columns[n] for n in own], [moved[n] for n in own])
            for number, column in zip(own, scaled, strict=True):
                found[number] = column
        return found

    def bends_of(
        self, effect: Effect, groups: Sequence[PatchGroup], moved: Sequence[FloatArray]
    ) -> list[FloatArray]:
        """Return what other bends do, as large as what an effect on the shape does, (n, k)."""
        return _as_large(columns_of(self.bends if effect.group == 'shape' else {}, groups), moved)


def _otherwise(
    evaluator: PatchEvaluator, effect: Effect, index: int, body: StaticBody
) -> tuple[Change, ...]:
    return effect.otherwise(evaluator.model.effects.site(index, body.discretisation.rest_nodes))


def _rows(groups: Sequence[PatchGroup], first: int, last: int | None) -> Rows:
    return rows_of(groups, [group.patches.jacobian[:, first:last] for group in groups])


def _as_large(columns: Sequence[FloatArray], moved: Sequence[FloatArray]) -> list[FloatArray]:
    """Return columns each of which moves the patches as far as an effect, root mean square."""
    whole, done = np.concatenate(columns), np.concatenate(moved)
    if not whole.size:
        return list(columns)
    own = np.sqrt(np.mean(whole**2, axis=0))
    least = max(_LEAST * float(own.max()), 1e-300)
    scale = float(np.sqrt(np.mean(done**2))) / np.maximum(own, least)
    return [column * scale for column in columns]
