# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a jump of depth lies that is too small to be seen in the residual as it stands.

Modulus and pose follow a jump of a few millimetres, and what they leave is bent. Scores take out
what they may have followed; they need a floor that was measured.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.detection.material_boundary import (
    BORDERS,
    LEAST_STEP,
    outstanding_boundary,
    seen_places,
)
from diffcal_ros.diagnosis.detection.sharp_limits import are_parts, placed_by_pixels
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.boundary_strip import knows_boundary
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_gap import tangent_slack
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import cells_of_depth, sums_by_cell
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.projection import Projection
from diffcal_ros.effects.registry import seen_boundary
from diffcal_ros.effects.surface_parts import SurfacePart
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A jump stands out when it explains so much chi-square, too.
LEAST_GAIN = 30.0
# A modulus that has followed a higher jump may be so far off that tangents there mislead; such a
# jump is seen as it stands, or pixel by pixel.
_HIGHEST = LEAST_STEP
# What comes up over as many places to either side instead has to leave more: else it is no jump,
# but the form of something smooth, such as a kink.
_SMOOTHED = 4
OF_SMOOTH = 0.7

# From where pixels see a body at rest (`BodyAxes.on_surface`, shape (M, 3)) to by how much each is
# beyond each jump, shape (M, s).
JumpsOf = Callable[[FloatArray], FloatArray]
# From there to a number of each that tells which jumps it is beyond, shape (M,).
NumbersOf = Callable[[FloatArray], NDArray[np.int64]]


def find_depth_discontinuity(evaluator: PatchEvaluator, nominal: Refit) -> float | None:
    """Return the share of the free length at which a jump of depth begins; None where none does.

    Args:
        evaluator: of the nominal model, or of one with an effect.
        nominal: its fit.
    """
    if knows_boundary(evaluator.model.scene) or not evaluator.is_measured:
        return None
    jumps = jumps_seen(with_jumps(evaluator, nominal, beyond(BORDERS)), nominal)
    gains, heights = jumps.gains(np.eye(len(BORDERS)))
    left = dict(zip(BORDERS, (jumps.whole - gains).tolist(), strict=True))
    at = outstanding_boundary(left, jumps.whole)
    best = int(gains.argmax())
    if at is None or gains[best] < LEAST_GAIN:
        return None
    sharp = np.array([[float(place == at) for place in BORDERS]])
    soft, _ = jumps.gains(softened(sharp, _SMOOTHED))
    left_by_soft = jumps.whole - float(soft[0])
    is_plain = left[at] < OF_SMOOTH * left_by_soft and abs(heights[best]) <= _HIGHEST
    if is_plain or (left[at] < left_by_soft and _is_seen(evaluator, nominal, at)):
        return at
    return None


def _is_seen(evaluator: PatchEvaluator, nominal: Refit, at: float) -> bool:
    """Tell whether pixels beside a border show a sharp jump there in all poses.

    They tell where what else is missing leaves more on the patches than a border does.
    """
    views = seen_places(evaluator, nominal.coordinates)
    beyond_it = placed_by_pixels(views, SurfacePart(at, 1.0))
    return are_parts(views, [beyond_it])


@dataclass(frozen=True)
class Jumps:
    """What jumps of depth explain, once modulus, pose and a bias of the whole body followed.

    Attributes:
        products: of what each jump of one metre does with what each other one does [1/m^2], shape
            (s, s).
        pulls: of those with what is left [1/m], shape (s,).
        whole: chi-square of what is left.
    """

    products: FloatArray
    pulls: FloatArray
    whole: float

    def gains(self, signs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what sums of jumps explain of chi-square, and their heights [m], (m,) each.

        Args:
            signs: by how much each jump is in each sum, shape (m, s).
        """
        sizes = np.einsum('ms,ms->m', signs @ self.products, signs)
        return explained(signs @ self.pulls, sizes)

    def gains_of_each(self) -> FloatArray:
        """Return what each jump alone explains of chi-square, shape (s,)."""
        return explained(self.pulls, np.diag(self.products))[0]

    def beside(self, signs: FloatArray) -> 'Jumps':
        """Return what is seen once a sum of jumps has followed what it may.

        Args:
            signs: by how much each jump is in it, shape (s,).
        """
        done, pull = self.products @ signs, float(signs @ self.pulls)
        size = float(signs @ done) + 1.0 / _usual_height() ** 2
        return Jumps(
            self.products - np.outer(done, done) / size,
            self.pulls - done * pull / size,
            self.whole - pull**2 / size,
        )

    def heights(self) -> tuple[FloatArray, float]:
        """Return the heights of all jumps together [m], shape (s,), and what they leave."""
        known = np.eye(len(self.pulls)) / _usual_height() ** 2
        found = np.asarray(np.linalg.solve(self.products + known, self.pulls), dtype=np.float64)
        return found, self.whole - float(found @ self.pulls)


def explained(pulls: FloatArray, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return what jumps explain of chi-square, and their heights [m], (m,) each.

    Args:
        pulls: of each of one metre with what is left [1/m], shape (m,).
        sizes: of what each does, squared [1/m^2], shape (m,).
    """
    heights = pulls / (sizes + 1.0 / _usual_height() ** 2)
    return heights * pulls, heights


def _usual_height() -> float:
    (jump,) = seen_boundary().components
    return jump.scale


def softened(signs: FloatArray, reach: int) -> FloatArray:
    """Return jumps spread over neighbouring places, shape (m, s).

    Args:
        signs: by how much each jump is in each sum, shape (m, s).
        reach: over so many places to either side.
    """
    count = signs.shape[1]
    soft = np.zeros_like(signs)
    for shift in range(-reach, reach + 1):
        places = np.clip(np.arange(count) + shift, 0, count - 1)
        np.add.at(soft.T, places, signs.T / (2 * reach + 1))
    return soft


def jumps_seen(groups: Sequence[PatchGroup], nominal: Refit) -> Jumps:
    """Return what is seen of jumps.

    Args:
        groups: with the columns of `with_jumps`.
        nominal: fit, whose parameters have the columns before those.
    """
    count = len(nominal.coordinates)
    seen = whiten(groups, Part.FIT, tangent_slack(groups))
    _, precision = regularised_prior(nominal.parameters)
    # Of a bias of the whole body nothing is known beforehand.
    project = Projection(seen.jacobian[:, : count + 1], np.pad(precision, (0, 1)))
    residual, columns = project(seen.values), project(seen.jacobian[:, count + 1 :])
    return Jumps(columns.T @ columns, columns.T @ residual, float(residual @ residual))


def beyond(borders: Sequence[float]) -> JumpsOf:
    """Return the jumps that begin at shares of the free length."""

    def jumps_of(places: FloatArray) -> FloatArray:
        return (places[:, :1] > np.array(borders)).astype(np.float64)

    return jumps_of


def with_jumps(
    evaluator: PatchEvaluator,
    nominal: Refit,
    jumps_of: JumpsOf,
    numbers_of: NumbersOf | None = None,
) -> list[PatchGroup]:
    """Return a fit's patches with more columns: of the whole body's bias, then of each jump's.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.
        jumps_of: tells which jumps each pixel is beyond.
        numbers_of: tells pixels that are not beyond the same ones apart: of very many jumps, those
            of one patch that are alike are taken together.

    Raises:
        NotSimulatedError: where a view sees nothing of the body any more.
    """
    views = evaluator.model.views(nominal.coordinates)
    compared = evaluator.comparisons(nominal.coordinates)

    def on_part(places: FloatArray) -> FloatArray:
        return np.hstack([np.ones((len(places), 1)), jumps_of(places)])

    count = on_part(np.zeros((1, 3))).shape[1]
    groups = []
    for group in nominal.groups:
        fractions = np.zeros((len(group.patches.values), count))
        if group.kind == 'depth' and not group.is_rigid and len(fractions):
            depth = compared[group.view].depth
            if not len(depth.indices):
                raise NotSimulatedError('the state that was fitted is not found again from rest')
            comparer = evaluator.comparers[group.view]
            places = comparer.places(views[group.view].trace, depth.indices)
            # Of a cell across a border its average has the side with more pixels.
            pixels = _Pixels(places, *cells_of_depth(depth, evaluator.cell))
            pixels = pixels if numbers_of is None else pixels.taken_together(numbers_of)
            fractions = pixels.means(on_part, group.patches.cells)
        wide = np.hstack([group.patches.jacobian, fractions])
        groups.append(replace(group, patches=replace(group.patches, jacobian=wide)))
    return groups


@dataclass(frozen=True)
class _Pixels:
    """Pixels of one view.

    Attributes:
        places: that they see, shape (M, 3).
        cells: that they are in, shape (M,).
        weights: how much each counts there, shape (M,).
    """

    places: FloatArray
    cells: NDArray[np.int64]
    weights: FloatArray

    def taken_together(self, numbers_of: NumbersOf) -> '_Pixels':
        """Return one in place of all that are in one cell and have one number."""
        numbers = numbers_of(self.places)
        keys = self.cells * (int(numbers.max(initial=0)) + 1) + numbers
        _, firsts, own = np.unique(keys, return_index=True, return_inverse=True)
        weights = np.bincount(own, self.weights).astype(np.float64)
        return _Pixels(self.places[firsts], self.cells[firsts], weights)

    def means(self, jumps_of: JumpsOf, cells: NDArray[np.int64]) -> FloatArray:
        """Return which share of cells, shape (m,), is beyond each jump, shape (m, s).

        A state that is found again may show a patch less at the outline: of that there is nothing.
        """
        own, sums, totals = sums_by_cell(jumps_of(self.places), self.cells, self.weights)
        is_seen = np.isin(cells, own[totals > 0.0])
        rows = np.searchsorted(own, cells[is_seen])
        found = np.zeros((len(cells), sums.shape[1]))
        found[is_seen] = sums[rows] / totals[rows, None]
        return found
