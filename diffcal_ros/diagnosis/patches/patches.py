# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Residuals averaged over patches of the image, with their Jacobian: what a diagnosis looks at."""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.residuals.robust_residual import Residuals
from diffcal_ros.diagnosis.patches.noise_model import CommonError, NoiseModel
from diffcal_ros.median_spread import SPREAD_OVER_MEDIAN
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A body fills about so many patches of depth.
_WANTED = 60
# And so many at least in each of many frames.
_WANTED_OF_MANY = 16
_SMALLEST_CELL, _LARGEST_CELL = 8, 40
# A patch with less is noise [px].
_LEAST_PIXELS, _LEAST_OUTLINE = 12, 3.0
# A surface seen too flat beside the outline is no harm when it is thinner than this [px].
_HARMLESS = 0.25
# Pixels off their patch's median by more are not the body [spreads, m]; nor is an edge that is off
# by more than so many spreads and this, which is found to a pixel [px].
_OUTLIER_SPREADS, _OUTLIER_SLACK, _EDGE_SLACK = 4.0, 0.0004, 1.0


@dataclass(frozen=True)
class Patches:
    """Patches of one kind in one view.

    Attributes:
        values: mean residual, observed less modelled [m], shape (n,).
        jacobian: of the modelled side, shape (n, k).
        covariance: of the values [m^2], shape (n, n).
        centers: in the image [px], shape (n, 2).
        cells: number of the image cell of each, the same at other coordinates, shape (n,).
        weights: pixels, or length of outline, shape (n,).
        common: error that other frames of the recording have too; not in `covariance`.
        standing: error that all recordings have; in neither of them. None: there is none.
        uneven: what of the variance of each value its patch is uneven by [m^2], shape (n,); None:
            patches are even.
        left: what counts of each value where it is told whether a patch is far off [m], shape
            (n,); None: all of it.
    """

    values: FloatArray
    jacobian: FloatArray
    covariance: FloatArray
    centers: FloatArray
    cells: IntArray
    weights: FloatArray
    common: CommonError
    standing: CommonError | None = None
    uneven: FloatArray | None = None
    left: FloatArray | None = None

    @property
    def variances(self) -> FloatArray:
        """Variance of each value [m^2], shape (n,)."""
        found = np.diag(self.covariance) + self.common.spread**2
        return found if self.standing is None else found + self.standing.spread**2

    def doubted(self, spread: FloatArray) -> 'Patches':
        """Return the patches with a further smooth error of this size [m], shape (n,)."""
        if not spread.any():
            return self
        further = self.common.of(spread).covariance(self.centers)
        return replace(self, covariance=self.covariance + further)

    def chosen(self, indices: IntArray | NDArray[np.bool_]) -> 'Patches':
        """Return some of the patches."""
        own = np.arange(len(self.values))[indices]
        return Patches(
            values=self.values[own],
            jacobian=self.jacobian[own],
            covariance=self.covariance[np.ix_(own, own)],
            centers=self.centers[own],
            cells=self.cells[own],
            weights=self.weights[own],
            common=self.common.of(self.common.spread[own]),
            standing=None
            if self.standing is None
            else self.standing.of(self.standing.spread[own]),
            uneven=None if self.uneven is None else self.uneven[own],
            left=None if self.left is None else self.left[own],
        )


def cell_size(pixel_count: int, frame_count: int = 1) -> int:
    """Return the side of the image cells [px].

    Args:
        pixel_count: of the body in one view.
        frame_count: views of one recording; many need fewer patches each.
    """
    wanted = max(_WANTED / np.sqrt(frame_count), _WANTED_OF_MANY)
    side = int(np.sqrt(max(pixel_count, 1) / wanted))
    return int(np.clip(side, _SMALLEST_CELL, _LARGEST_CELL))


def depth_patches(
    residuals: Residuals, jacobian: FloatArray, noise: NoiseModel, cell: int
) -> Patches:
    """Average residuals of depth over cells of the image.

    Where they differ within a cell by more than their noise the average depends on which pixels
    the cell happens to hold, and is known as well as that of so many draws.
    """
    numbers, weights = cells_of_depth(residuals, cell)
    values, slopes, centers, cells, totals = averaged_by_cell(
        residuals, jacobian, numbers, weights, _LEAST_PIXELS
    )
    further = _unevenness(residuals.values, weights, numbers, cells, noise.pixel)
    covariance = noise.depth_covariance(centers, totals) + np.diag(further)
    common = noise.depth_common(len(values))
    standing = noise.depth_standing(len(values)) if noise.standing else None
    return Patches(values, slopes, covariance, centers, cells, totals, common, standing, further)


def cells_of_depth(residuals: Residuals, cell: int) -> tuple[IntArray, FloatArray]:
    """Return the cell of each residual of depth, and how much it counts there, shape (M,) each.

    Args:
        residuals: of depth.
        cell: side of the cells [px].
    """
    numbers = cell_numbers(residuals.pixels, cell)
    return numbers, residuals.weights * _trust(residuals.values, numbers, _OUTLIER_SLACK)


def edge_patches(
    residuals: Residuals,
    jacobian: FloatArray,
    pixel_sizes: FloatArray,
    doubt: FloatArray,
    noise: NoiseModel,
    cell: int,
) -> Patches:
    """Average distances of the outline over cells of the image, each side of the body by itself.

    Args:
        residuals: of the outline.
        jacobian: shape (M, k).
        pixel_sizes: of a pixel at the body for each residual [m], shape (M,).
        doubt: how far each segment may seem to lie inside [px], shape (M,).
        noise: of the observation.
        cell: side of the cells [px].
    """
    numbers = cell_numbers(residuals.pixels, cell)
    wide = np.hstack([jacobian, pixel_sizes[:, None], doubt[:, None]])
    # Pieces in doubt say little beside others of the same cell.
    weights = residuals.weights / (1.0 + (doubt / _HARMLESS) ** 2)
    slack = _EDGE_SLACK * float(np.median(pixel_sizes)) if len(pixel_sizes) else 0.0
    weights *= _trust(residuals.values, numbers, slack)
    values, slopes, centers, cells, totals = averaged_by_cell(
        residuals, wide, numbers, weights, _LEAST_OUTLINE
    )
    sizes, doubts = slopes[:, -2], slopes[:, -1]
    known = noise.edge_pixels * sizes
    further = _unevenness(residuals.values, weights, numbers, cells, known)
    own = (doubts * sizes) ** 2 + further
    covariance = noise.edge_covariance(centers, totals, sizes) + np.diag(own)
    common = noise.edge_common(sizes)
    return Patches(values, slopes[:, :-2], covariance, centers, cells, totals, common, uneven=own)


# Numbers of cells count these in a row: no image is as wide.
_IN_A_ROW = 100_000


def cell_places(numbers: IntArray) -> tuple[IntArray, IntArray]:
    """Return in which rows and columns of cells those of some numbers are, shape (n,) each."""
    rows, columns = np.divmod(numbers, _IN_A_ROW)
    return rows, columns


def cell_numbers(pixels: NDArray[np.int32], cell: int) -> IntArray:
    """Return the number of the image cell in which each pixel lies, shape (M,).

    Args:
        pixels: column and row, shape (M, 2).
        cell: side of the cells [px].
    """
    columns, rows = (pixels // cell).T.astype(np.int64)
    return rows * _IN_A_ROW + columns


def _trust(values: FloatArray, numbers: IntArray, slack: float) -> FloatArray:
    """Return how far each residual is trusted beside the others of its cell, shape (M,).

    Wholly up to half way to an outlier, from there down to nothing: a pixel that becomes one as
    the model moves makes no step (Hampel et al., *Robust Statistics*, 1986, on such weights).

    Args:
        values: [m], shape (M,).
        numbers: cell of each, shape (M,).
        slack: beyond the spreads [m].
    """
    if not len(values):
        return np.ones(0)
    _, groups = np.unique(numbers, return_inverse=True)
    off = np.abs(values - _medians(values, groups)[groups])
    most = _OUTLIER_SPREADS * SPREAD_OVER_MEDIAN * _medians(off, groups) + slack
    beyond = np.clip(2.0 * off / most[groups] - 1.0, 0.0, 1.0)
    return np.asarray(1.0 - beyond**2 * (3.0 - 2.0 * beyond))


def _medians(values: FloatArray, groups: IntArray) -> FloatArray:
    """Return the median of each group, shape (g,), all of them at once.

    Args:
        values: shape (M,).
        groups: number of the group of each, from 0 on, none of which is empty, shape (M,).
    """
    ordered = values[np.lexsort((values, groups))]
    counts = np.bincount(groups)
    starts = np.cumsum(counts) - counts
    return np.asarray(0.5 * (ordered[starts + (counts - 1) // 2] + ordered[starts + counts // 2]))


def _unevenness(
    values: FloatArray,
    weights: FloatArray,
    numbers: IntArray,
    cells: IntArray,
    known: FloatArray | float,
) -> FloatArray:
    """Return the variance of averages where residuals differ by more than noise [m^2], shape (n,).

    Args:
        values: residuals [m], shape (M,).
        weights: of each, shape (M,).
        numbers: cell of each, shape (M,).
        cells: those that were averaged, ascending, shape (n,).
        known: standard deviation of the noise of one residual in each [m].
    """
    own = np.isin(numbers, cells)
    places = np.searchsorted(cells, numbers[own])
    chosen, shares = values[own], weights[own]
    totals, sums, squares = (
        np.bincount(places, shares * chosen**power, minlength=len(cells)) for power in range(3)
    )
    spread = squares / totals - (sums / totals) ** 2
    return np.asarray(np.maximum(spread - known**2, 0.0) / totals)


def averaged_by_cell(
    residuals: Residuals,
    jacobian: FloatArray,
    numbers: IntArray,
    weights: FloatArray,
    least: float,
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray, FloatArray]:
    """Average over cells; return values, slopes, centers, cells and weights of those with enough.

    Args:
        residuals: with the pixels of each.
        jacobian: whatever else is averaged, shape (M, k).
        numbers: cell of each residual, shape (M,).
        weights: of each, shape (M,).
        least: weight that a cell must hold.

    Returns:
        Values (n,), slopes (n, k), centers (n, 2) [px], cells (n,), ascending, and weights (n,).
    """
    if len(numbers) == 0:
        nothing = np.zeros(0)
        empty = np.zeros((0, jacobian.shape[1]))
        return nothing, empty, np.zeros((0, 2)), np.zeros(0, dtype=np.int64), nothing
    # Of many cameras' parameters most move nothing here.
    moving = np.flatnonzero(jacobian.any(axis=0))
    columns = np.hstack([residuals.values[:, None], residuals.pixels, jacobian[:, moving]])
    cells, sums, totals = sums_by_cell(columns, numbers, weights)
    enough = totals >= least
    means = sums[enough] / totals[enough, None]
    slopes = np.zeros((len(means), jacobian.shape[1]))
    slopes[:, moving] = means[:, 3:]
    return means[:, 0], slopes, means[:, 1:3], cells[enough], totals[enough]


def sums_by_cell(
    columns: FloatArray, numbers: IntArray, weights: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return all cells, ascending, shape (n,), weighted sums over each, (n, k), and weights, (n,).

    Args:
        columns: what is summed, shape (M, k).
        numbers: cell of each row, shape (M,).
        weights: of each row, shape (M,).
    """
    cells, indices, counts = np.unique(numbers, return_inverse=True, return_counts=True)
    totals: FloatArray = np.bincount(indices, weights).astype(np.float64)
    order = np.argsort(indices, kind='stable')
    ends = np.concatenate([[0], np.cumsum(counts)])
    sums = csr_array((weights[order], order, ends), shape=(len(cells), len(numbers))) @ columns
    return cells, np.asarray(sums), totals
