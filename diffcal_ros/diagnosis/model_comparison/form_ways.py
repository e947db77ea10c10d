# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The ways in which what effects do may differ from the library's form of it.

In its form: what an effect does times a smooth function, over the body's length for what acts on
the body, over the picture for what is the sensor's. A picture that a camera moves may be warped as
smoothly, by as much as it is moved, and what is read wrong of one material need not begin at once
where that does. And from pose to pose: each amplitude by itself, by as much as amplitudes of its
kind are. Frames of one motion are of one pose: what differs among them differs smoothly over time.

Some effects say what else they may do (`Effect.otherwise`), and a body that is bent at rest may be
bent by another curve than an arc; this is as large as what the effect does.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_places import Places, places_of
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import (
    full_names,
    FullName,
    PatchGroup,
    with_columns,
)
from diffcal_ros.diagnosis.screening.candidates import Candidate, parameters_of
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A border that is soft: over so much of the body's length, and by how much more than the usual
# tolerance what sets in there may differ: by a quarter of itself.
_BORDER_WIDTH, _BORDER_SIZE = 0.15, 2.5
# Of the patches on one side of a border that stay on it.
_MOSTLY = 0.95


@dataclass(frozen=True)
class Ways:
    """Columns that are the ways in which some effects may differ, by groups of patches.

    Attributes:
        by_pose: from pose to pose [m], shape (n, p) each.
        form: in their form [m], shape (n, f) each.
    """

    by_pose: tuple[FloatArray, ...]
    form: tuple[FloatArray, ...]

    @property
    def pose_count(self) -> int:
        """How many differ from pose to pose."""
        return self.by_pose[0].shape[1] if self.by_pose else 0

    def joined(self, groups: Sequence[PatchGroup]) -> list[PatchGroup]:
        """Return patches with the ways behind their tangents."""
        return with_columns(groups, self.scaled(1.0, 1.0))

    def scaled(self, share: float, fraction: float) -> list[FloatArray]:
        """Return all columns by groups, those from pose to pose first, each kind times a size."""
        return [
            np.hstack([share * by_pose, fraction * form])
            for by_pose, form in zip(self.by_pose, self.form, strict=True)
        ]


def ways_of(model: ForwardModel, fit: Refit, basis: FormBasis, added: Sequence[Candidate]) -> Ways:
    """Return the ways of effects of a fitted model.

    Args:
        model: with its effects.
        fit: of it.
        basis: of the model without them.
        added: the effects.
    """
    return ways_at(places_of(model, fit.groups, basis.points), fit, basis, added)


def ways_at(
    places: Sequence[Places], fit: Refit, basis: FormBasis, added: Sequence[Candidate]
) -> Ways:
    """Return the ways of effects where the places of the patches are known.

    Args:
        places: of the groups of the fit.
        fit: see `ways_of`.
        basis: likewise.
        added: likewise.
    """
    done = [_Done.of(fit, basis, own, places) for own in added]
    by_pose, form = [], []
    for number, (group, place) in enumerate(zip(fit.groups, places, strict=True)):
        empty = np.zeros((len(place.along), 0))
        several = place.pose_count > 1
        pose_ways = [own.by_pose(number, place) for own in done] if several else []
        by_pose.append(np.hstack([empty, *pose_ways]))
        form.append(np.hstack([empty, *(own.of_form(number, group, place) for own in done)]))
    return Ways(tuple(by_pose), tuple(form))


@dataclass(frozen=True)
class _Done:
    """What one effect does to the patches of each group.

    Attributes:
        candidate: the effect.
        moved: how far it moves them [m], shape (n,) each.
        usual: how far amplitudes do that are as large as its own, each by itself [m], (n, a) each.
        amount: of a sensor's error of one of the materials, its size [m].
        border: share of the body's length where that begins; None: it is none.
        besides: what else it may do in each pose [m], shape (n, b) each.
        bends: what bends of other curves do [m], shape (n, c) each.
        is_set_anew: whether its amplitudes are others in each pose as they were fitted.
    """

    candidate: Candidate
    moved: list[FloatArray]
    usual: list[FloatArray]
    amount: float
    border: float | None
    besides: list[FloatArray]
    bends: list[FloatArray]
    is_set_anew: bool = False

    @classmethod
    def of(
        cls, fit: Refit, basis: FormBasis, candidate: Candidate, places: Sequence[Places]
    ) -> '_Done':
        """Return it for an effect of a fitted model."""
        effect = candidate.effect
        indices = [fit.parameters.names.index(name) for name in candidate.names]
        values = fit.coordinates[indices]
        if not effect.has_tangent:
            # Its amplitudes are places: what they do is told from the model without.
            moved = _done_by(fit, basis.base)
            besides = basis.besides_of(effect, fit.groups, moved)
            nothing = [np.zeros((len(own), 0)) for own in moved]
            return cls(
                candidate, moved, [own[:, None] for own in moved], 0.0, None, besides, nothing
            )
        scales = candidate.scales
        sizes = scales * float(np.linalg.norm(values / scales))
        slopes = [group.patches.jacobian[:, indices] for group in fit.groups]
        brought = parameters_of(fit.parameters, [candidate])
        own = [fit.parameters.names.index(name) for name in brought]
        # A time alone does nothing, and is no multiple of anything.
        amounts = [i for i in own if fit.parameters.parameters[i].quantity.prior_std is not None]
        is_step = effect.has_boundary and effect.group == 'sensor'
        moved = [g.patches.jacobian[:, amounts] @ fit.coordinates[amounts] for g in fit.groups]
        return cls(
            candidate,
            moved,
            [slope * sizes for slope in slopes],
            float(np.abs(values[0])) if is_step else 0.0,
            _border(fit, slopes, places) if is_step else None,
            basis.besides_of(effect, fit.groups, moved),
            basis.bends_of(effect, fit.groups, moved),
            any(fit.parameters.parameters[index].posture is not None for index in own),
        )

    def by_pose(self, number: int, place: Places) -> FloatArray:
        """Return what amplitudes that are other ones in each pose do to one group, (n, p)."""
        if self.is_set_anew:
            return np.zeros((len(place.along), 0))
        most = self.candidate.effect.most_by_pose
        return np.hstack([place.in_each(most * own) for own in self.usual[number].T])

    def of_form(self, number: int, group: PatchGroup, place: Places) -> FloatArray:
        """Return what it does in other forms to one group, shape (n, f)."""
        effect = self.candidate.effect
        functions = place.functions(effect.group)
        found = [place.times(effect.most_along * self.moved[number], functions)]
        names = self.candidate.components
        across = [names.index(own) for own in effect.across_picture if own in names]
        # What it moves across the picture may point elsewhere, too: a lens moves all outwards.
        found += [place.times(self.usual[number][:, own], functions) for own in across]
        if self.border is not None:
            is_read = float(group.kind == 'depth')
            found.append(is_read * self._soft_border(place))
            read = np.full(len(place.along), is_read * self.amount)
            found.append(place.times(read, place.functions('body')))
        found += [place.in_each(effect.most_besides * own) for own in self.besides[number].T]
        return np.hstack([*found, self.bends[number]])

    def _soft_border(self, place: Places) -> FloatArray:
        """Return what a sensor's error does that sets in before or after the border, (n, 2)."""
        beyond = place.along[:, 0] - (self.border or 0.0)
        near = _BORDER_SIZE * self.amount * np.exp(-0.5 * (beyond / _BORDER_WIDTH) ** 2)
        return np.stack([np.where(beyond < 0.0, near, 0.0), np.where(beyond < 0.0, 0.0, near)], 1)


def _border(fit: Refit, slopes: Sequence[FloatArray], places: Sequence[Places]) -> float | None:
    """Return where along the body an error of one of its materials begins, if that is seen."""
    pairs = [
        (place.along[:, 0], np.abs(own[:, 0]) > 0.5)
        for group, own, place in zip(fit.groups, slopes, places, strict=True)
        if group.kind == 'depth' and not group.is_rigid
    ]
    along, is_second = (np.concatenate(part) for part in zip(*pairs, strict=True))
    if is_second.all() or not is_second.any():
        return None
    first, second = along[~is_second], along[is_second]
    return float(0.5 * (np.quantile(first, _MOSTLY) + np.quantile(second, 1.0 - _MOSTLY)))


def _done_by(fit: Refit, nominal: Refit) -> list[FloatArray]:
    """Return how far a model moves each patch of each group beside what the nominal one did."""
    before: dict[FullName, float] = {}
    for group in nominal.groups:
        before.update(zip(full_names([group]), group.patches.values.tolist(), strict=True))
    found = []
    for group in fit.groups:
        names, after = full_names([group]), group.patches.values
        found.append(
            np.array([before.get(name, v) - v for name, v in zip(names, after, strict=True)])
        )
    return found
