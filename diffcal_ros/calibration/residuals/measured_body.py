# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The other direction of the gap: what of the measured body no simulated pixel covers.

Coverage asks whether the simulated body was measured. A body that has slid along itself passes
that, and leaves a piece of the measured one beside it. So the image beside the simulated body is
searched for surface that goes on from it: near in depth, reached without a step, about as thick as
the body, and ending by itself. A surface that goes on to the clamp's side, or farther than the
body can reach, is a fixture, a table or a hand, and says nothing.
"""

from dataclasses import dataclass

from diffcal_ros.camera import PinholeCamera
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# Images are thinned until the body is so many pixels long: enough for shares in per cent.
_SIDE = 100
# How far beside the simulated body its measured surface may go on [m].
_REACH = 0.06
# Of a surface that ends by itself, most lies there; a fixture's or a table's does not.
_OWN = 0.6
# What is left of a body is about as thick as the body; a cable or a halo is not.
_THICK = 0.3
# Of what lies around a hidden part, this share belongs to what hides it.
_GOES_ON = 0.25


@dataclass(frozen=True)
class MeasuredShares:
    """How measured pixels near the body relate to the simulated one.

    Attributes:
        unexplained: pixels of the measured body that no simulated pixel covers.
        hidden: simulated, unmasked pixels behind something that stands in front of the body.
        beside: the former in the image, thinned by `stride`.
        stride: of that image [px].
    """

    unexplained: float
    hidden: float
    beside: BoolArray
    stride: int


@dataclass(frozen=True)
class SimulatedView:
    """What is simulated in one image, shape (H, W) each.

    Attributes:
        depth: rendered z, as the sensor would read it [m], NaN beside the body.
        counted: rendered pixels that are not masked.
        left_out: pixels at which nobody looks.
    """

    depth: FloatArray
    counted: BoolArray
    left_out: BoolArray


def measured_fractions(
    observed: NDArray[np.float32],
    simulated: SimulatedView,
    camera: PinholeCamera,
    truncation: float,
    band: float,
    steepest: float,
) -> MeasuredShares:
    """Find what of the measured body is not simulated, and what of the simulated one is hidden.

    Args:
        observed: z [m], shape (H, W), NaN where invalid.
        simulated: the rendered body.
        camera: of both.
        truncation: depths that differ by more are not the same surface [m].
        band: width along outlines in which readings are not trusted [px].
        steepest: angle from its normal at which a surface may be seen [rad].
    """
    rows, columns, stride = _window(simulated.depth, camera)
    place = (slice(rows.start, rows.stop, stride), slice(columns.start, columns.stop, stride))
    seen = observed[place].astype(np.float64)
    depth, counted = simulated.depth[place], simulated.counted[place]
    covered = np.isfinite(depth)
    distance, (near_row, near_column) = ndimage.distance_transform_edt(
        ~covered, return_indices=True
    )
    there = depth[near_row, near_column]
    with np.errstate(invalid='ignore'):
        climb = np.tan(steepest) * stride * there / camera.fx
        is_level = _largest_step(seen) < climb
        alike = np.abs(seen - there) < truncation + 0.25 * climb * distance
        before = counted & (seen < depth - truncation)
    outside = np.isfinite(seen) & (distance > max(band / stride, 1.0))
    outside &= is_level & ~simulated.left_out[place]
    is_free = counted[near_row, near_column]
    own = outside & alike & is_free
    matched = counted & (np.abs(seen - depth) < truncation)
    beside = _ending_surfaces(
        outside, own, distance, matched[near_row, near_column], band / stride
    )
    if beside.any():  # Nothing is, where the fit is good.
        beside &= _thick(outside, _THICK * float(ndimage.distance_transform_edt(covered).max()))
    hidden = _hidden(before, seen, distance, near_row, near_column, truncation, band / stride)
    image = np.zeros(tuple(-(-side // stride) for side in observed.shape), dtype=bool)
    r, c = rows.start // stride, columns.start // stride
    image[r : r + beside.shape[0], c : c + beside.shape[1]] = beside
    square = float(stride**2)
    return MeasuredShares(
        square * float(beside.sum()), square * float(hidden.sum()), image, stride
    )


def _window(depth: FloatArray, camera: PinholeCamera) -> tuple[slice, slice, int]:
    """Return rows and columns about the body, and by how much to thin them."""
    high, wide = (
        np.flatnonzero(np.isfinite(depth).any(1)),
        np.flatnonzero(np.isfinite(depth).any(0)),
    )
    if len(high) == 0:
        return slice(0, 0), slice(0, 0), 1
    sides = (int(high[-1] - high[0]) + 1, int(wide[-1] - wide[0]) + 1)
    stride = max(1, max(sides) // _SIDE)
    margin = int(_REACH * camera.fx / float(np.nanmedian(depth)))
    first = [max(int(low[0]) - margin, 0) // stride * stride for low in (high, wide)]
    rows = slice(first[0], min(int(high[-1]) + margin + 1, depth.shape[0]))
    return rows, slice(first[1], min(int(wide[-1]) + margin + 1, depth.shape[1])), stride


def _largest_step(depth: FloatArray) -> FloatArray:
    """Return how far each pixel's depth is from any neighbour's [m]; inf beside invalid ones."""
    steps = np.zeros(depth.shape)
    for axis in (0, 1):
        jump = np.abs(np.diff(depth, axis=axis))
        jump = np.where(np.isfinite(jump), jump, 0.0)
        lower = [slice(None)] * 2
        upper = [slice(None)] * 2
        lower[axis], upper[axis] = slice(None, -1), slice(1, None)
        np.maximum(steps[tuple(lower)], jump, out=steps[tuple(lower)])
        np.maximum(steps[tuple(upper)], jump, out=steps[tuple(upper)])
    return steps


def _ending_surfaces(
    outside: BoolArray, own: BoolArray, distance: FloatArray, is_matched: BoolArray, band: float
) -> BoolArray:
    """Return surfaces that begin at the explained body and end by themselves."""
    names, count = ndimage.label(outside)
    if count == 0:
        return np.zeros(outside.shape, dtype=bool)
    numbers = np.arange(1, count + 1)
    sizes = ndimage.sum(outside, names, numbers)
    fractions = ndimage.sum(own, names, numbers) / np.maximum(sizes, 1.0)
    touching = own & is_matched & (distance <= band + 2.5)
    touches = ndimage.sum(touching, names, numbers) >= 2.0
    # A surface that leaves the window goes on beyond what the body can reach.
    border = np.zeros(count + 1, dtype=bool)
    for side in (names[0], names[-1], names[:, 0], names[:, -1]):
        border[side] = True
    kept = np.concatenate([[False], touches & (fractions > _OWN) & ~border[1:]])
    found: BoolArray = kept[names] & own
    return found


def _thick(surface: BoolArray, least: float) -> BoolArray:
    """Return the connected surfaces whose half thickness is at least that [px] somewhere."""
    names, count = ndimage.label(surface)
    if count == 0:
        return surface
    inner = ndimage.distance_transform_edt(surface)
    numbers = np.arange(1, count + 1)
    kept = np.concatenate([[False], ndimage.maximum(inner, names, numbers) >= least])
    found: BoolArray = kept[names]
    return found


def _hidden(
    before: BoolArray,
    seen: FloatArray,
    distance: FloatArray,
    near_row: IntArray,
    near_column: IntArray,
    truncation: float,
    band: float,
) -> BoolArray:
    """Return what stands behind something that goes on beside the body.

    A body that is read too near ends where the body ends; what hides it does not.
    """
    names, count = ndimage.label(before)
    if count == 0:
        return before
    ring = (distance > band) & (distance <= band + 3.0)
    owners = names[near_row, near_column] * ring
    goes_on = ring & (np.abs(seen - seen[near_row, near_column]) < truncation)
    numbers = np.arange(1, count + 1)
    around = ndimage.sum(owners > 0, owners, numbers)
    fractions = ndimage.sum(goes_on, owners, numbers) / np.maximum(around, 1.0)
    kept = np.concatenate([[False], fractions > _GOES_ON])
    found: BoolArray = kept[names] & before
    return found
