# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far pixels of depth scatter over frames of a scene at rest, and how much neighbours share.

A scanning camera measures each pixel for itself. A stereo pair matches windows, so that pixels
next to each other scatter together: an average over many of them is known far less well than
their number says. How well, repeated frames tell: averages over blocks scatter over time as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.depth_frame import DepthFrame
import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

FloatArray = NDArray[np.float64]

# Repeated frames from which the noise of a pixel counts as measured: thousands of pixels tell it.
MEASURED_FRAMES = 3
# Side of the blocks whose averages are looked at [px], about that of a patch; blocks that show
# less of a surface tell nothing, and fewer blocks neither.
_SIDE = 8
_LEAST_SHARE = 0.5
_FEWEST_BLOCKS = 12
# Pixels that scatter by so much more than is usual flicker between two surfaces.
_FLICKERS = 3.0


@dataclass(frozen=True)
class FrameNoise:
    """Noise of the frames of a scene at rest.

    Attributes:
        pixel: standard deviation of one pixel of one frame over time [m]; NaN: not known.
        grain: of how many pixels an average scatters as one pixel does, white noise having 1. An
            average over n pixels, no fewer than that, has a variance of pixel^2 * grain / n.
    """

    pixel: float = float('nan')
    grain: float = 1.0


def noise_at_rest(frames: Sequence[DepthFrame]) -> FrameNoise:
    """Return the noise of frames of a body at rest.

    It is not known where fewer than `MEASURED_FRAMES` are given, or no pixel is valid in all.
    """
    if len(frames) < MEASURED_FRAMES:
        return FrameNoise()
    return frame_noise(np.stack([frame.depth for frame in frames]))


def frame_noise(images: NDArray[np.float32]) -> FrameNoise:
    """Return the noise of frames of a scene at rest.

    Args:
        images: depth [m], shape (frames, H, W), NaN where nothing is seen; two frames or more.
    """
    is_seen = np.asarray(np.isfinite(images).all(axis=0))
    pixel = _usual_noise(images[:, is_seen])
    if len(images) < MEASURED_FRAMES or not np.isfinite(pixel):
        return FrameNoise(pixel)
    return FrameNoise(pixel, _grain(images, is_seen))


def _usual_noise(samples: NDArray[np.float32]) -> float:
    """Return the usual standard deviation over frames [m], from shape (frames, pixels).

    The median over pixels of what few frames show is less than what it is, by 17 % of three: it is
    that of a chi distribution. NaN without pixels.
    """
    count, freedom = samples.shape[1], len(samples) - 1
    if count == 0:
        return float('nan')
    usual = np.sqrt(2.0 * gammaincinv(0.5 * freedom, 0.5) / freedom)
    return float(np.median(np.std(samples, axis=0, ddof=1)) / usual)


def _grain(images: NDArray[np.float32], is_seen: NDArray[np.bool_]) -> float:
    """Return of how many pixels an average scatters as one, by blocks of about a patch's size."""
    apart = np.where(is_seen, images - images.mean(axis=0), 0.0).astype(np.float64)
    spread = apart.std(axis=0)
    if not spread.any():
        return 1.0  # What does not scatter at all shares nothing either.
    is_seen = is_seen & (spread <= _FLICKERS * np.median(spread[is_seen]))
    count = _by_block(is_seen[None].astype(float))[0]
    sums = _by_block(np.where(is_seen, apart, 0.0))
    squares = _by_block(np.where(is_seen, spread**2, 0.0)[None])[0]
    tells = (count >= _LEAST_SHARE * _SIDE**2) & (squares > 0.0)
    if tells.sum() < _FEWEST_BLOCKS:
        return 1.0
    # Depth is noisier far away: each block is held against its own pixels.
    ratios = np.square(sums).mean(axis=0)[tells] / squares[tells]
    return float(np.clip(ratios.mean(), 1.0, _SIDE**2))


def _by_block(images: FloatArray) -> FloatArray:
    """Return sums over blocks of pixels, shape (frames, rows, columns) of whole blocks."""
    rows, columns = (side // _SIDE for side in images.shape[1:])
    whole = images[:, : rows * _SIDE, : columns * _SIDE]
    return np.asarray(whole.reshape(len(images), rows, _SIDE, columns, _SIDE).sum(axis=(2, 4)))
