# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A gap in one place of the body, which says nothing about the rest of it.

Whatever a model of the body lacks, a load, a clamp, a law, moves a large part of its surface. What
is far off on a few patches that lie together, and nowhere else, is something before the body, an
edge of the fixture, a fault of the surface or of the sensor there. It is left out and told, and
the rest is judged without it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.diagnosis.model_comparison.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import Block, of_the_body, PatchName
from diffcal_ros.diagnosis.patches.residual_location import (
    nearest_nodes,
    PART_NAMES,
    parts_of_nodes,
)
from diffcal_ros.diagnosis.patches.whitened import precision_of
from diffcal_ros.diagnosis.screening.regularised_prior import full_prior
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A place is what lies so near one patch, as a share of the body's diagonal, and few patches.
_REACH = 0.15
_FEW = 0.15
# What is left of chi-square above its expectation once a place is left out and the rest fitted
# again; and how far above its expectation what it takes along must be, in standard deviations.
_HARDLY_ANY = 0.25
_FAR_OFF = 9.0


@dataclass(frozen=True)
class LocalOutlier:
    """Patches in one place that hold most of the gap.

    Attributes:
        patches: their names.
        size: root mean square of their residuals [m].
        where: part of the body, in words.
    """

    patches: frozenset[PatchName]
    size: float
    where: str

    @property
    def sentence(self) -> str:
        """Tell what was left out."""
        return (
            f'{len(self.patches)} patches in one place {self.where} are off by '
            f'{1e3 * self.size:.1f} mm while the rest of the body is not: something before it, or '
            'its edge there; they were left out'
        )


def find_local_outlier(model: ForwardModel, fit: Refit) -> LocalOutlier | None:
    """Return the place without which hardly any gap is left; None where no one place does that.

    A fit follows what is off in one place, and spreads it: so each place is left out and the rest
    fitted again, to first order.

    Args:
        model: of the fit.
        fit: with all patches.
    """
    blocks = [block for block in of_the_body(fit.blocks) if len(block.patches.values)]
    if not blocks:
        return None
    nodes = _nodes(model, fit, blocks)
    _, precision = full_prior(fit.parameters)
    columns = np.concatenate(
        [np.column_stack([b.patches.values, b.patches.jacobian]) for b in blocks]
    )
    weights = precision_of(blocks)
    pulls = weights @ columns
    whole = columns.T @ pulls
    chi_square = float(whole[0, 0])
    limit = _HARDLY_ANY * (chi_square - len(columns))
    best: tuple[float, IntArray] = (limit, np.zeros(0, dtype=np.int64))
    for place in _places(model, nodes):
        # What the place adds given the rest goes, by the inverse of a matrix in blocks.
        rest = whole - pulls[place].T @ np.linalg.solve(
            weights[np.ix_(place, place)], pulls[place]
        )
        # At the minimum the priors' pull is that of all patches.
        pull = rest[1:, 0] - whole[1:, 0]
        left = float(rest[0, 0] - pull @ np.linalg.pinv(rest[1:, 1:] + precision) @ pull)
        count = len(place)
        if chi_square - left > count + _FAR_OFF * np.sqrt(2.0 * count):
            best = min(best, (left - len(columns) + count, place), key=lambda own: own[0])
    place = best[1]
    if not len(place):
        return None
    names = [(b.view, b.kind, int(cell)) for b in blocks for cell in b.patches.cells]
    values = np.concatenate([block.patches.values for block in blocks])
    part = parts_of_nodes(model, blocks[0].view)[nodes[place]]
    return LocalOutlier(
        patches=frozenset(names[number] for number in place),
        size=float(np.sqrt(np.mean(values[place] ** 2))),
        where=PART_NAMES[int(np.median(part))],
    )


def _nodes(model: ForwardModel, fit: Refit, blocks: Sequence[Block]) -> IntArray:
    """Return the node that is seen nearest to each patch, shape (n,)."""
    views, seen = model.views(fit.coordinates), model.observations
    return np.concatenate(
        [nearest_nodes(own, views[own.view].points, seen[own.view].camera) for own in blocks]
    )


def _places(model: ForwardModel, nodes: IntArray) -> list[IntArray]:
    """Return the patches of the place around each patch.

    Args:
        model: of the body.
        nodes: which is nearest to each patch, shape (n,).
    """
    # In every posture the same nodes lie in one place.
    rest = model.body(model.observations[0]).discretisation.rest_nodes
    reach = _REACH * float(np.linalg.norm(np.ptp(rest, axis=0)))
    most = max(int(_FEW * len(nodes)), 1)
    found = []
    for middle in np.unique(nodes):
        apart = np.linalg.norm(rest[nodes] - rest[middle], axis=1)
        order = np.argsort(apart, kind='stable')[:most]
        found.append(order[apart[order] <= reach])
    return found
