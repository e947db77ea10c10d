# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A camera whose picture is another one than its intrinsics say.

A picture that is distorted shows a point where an undistorted one would show another: by how much
that is elsewhere is a polynomial of the place in the picture. Up to the second degree all of them
but shifts and the turn, which the camera's pose is; of the third what a lens adds (Brown,
Photogrammetric Engineering 32, 1966).
"""

from diffcal_ros.effects.camera_offset import LENS_MODES
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Exponents of both coordinates.
_POWERS = np.array([(1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)])
# Moves in both directions by these powers, of each mode.
_MOVES = {
    'focal': {(0, 0): 1.0, (1, 1): 1.0},
    'aspect': {(0, 0): 1.0, (1, 1): -1.0},
    'skew': {(0, 1): 1.0, (1, 0): 1.0},
    'x_xx': {(0, 2): 1.0},
    'x_xy': {(0, 3): 1.0},
    'x_yy': {(0, 4): 1.0},
    'y_xx': {(1, 2): 1.0},
    'y_xy': {(1, 3): 1.0},
    'y_yy': {(1, 4): 1.0},
    'radial': {(0, 5): 1.0, (0, 7): 1.0, (1, 6): 1.0, (1, 8): 1.0},
}


def _coefficients() -> FloatArray:
    found = np.zeros((len(LENS_MODES), 2, len(_POWERS)))
    for number, name in enumerate(LENS_MODES):
        for place, value in _MOVES[name].items():
            found[number][place] = value
    return found


_COEFFICIENTS = _coefficients()


def through_lens(points: FloatArray, amounts: FloatArray) -> FloatArray:
    """Return the points that an undistorted camera would show where a distorted one shows these.

    Args:
        points: camera frame [m], shape (N, 3).
        amounts: of each mode, shape (m,).
    """
    return points + lens_moves(points, amounts)


def lens_moves(points: FloatArray, amounts: FloatArray) -> FloatArray:
    """Return how far a lens moves points [m], shape (N, 3); it is linear in the amounts, (m,)."""
    moves = _monomials(points, _POWERS) @ _polynomials(amounts).T
    return np.column_stack([points[:, 2:] * moves, np.zeros(len(points))])


def lens_slopes(points: FloatArray, amounts: FloatArray) -> FloatArray:
    """Return the derivative of `through_lens` by the points, shape (N, 3, 3)."""
    polynomials = _polynomials(amounts)
    place = points[:, :2] / points[:, 2:]
    lower = [_POWERS - np.eye(2, dtype=int)[axis] for axis in range(2)]
    slopes = np.stack(
        [
            _monomials(points, np.maximum(powers, 0)) * _POWERS[:, axis] @ polynomials.T
            for axis, powers in enumerate(lower)
        ],
        axis=-1,
    )
    found = np.tile(np.eye(3), (len(points), 1, 1))
    found[:, :2, :2] += slopes
    moved = _monomials(points, _POWERS) @ polynomials.T
    # What is moved in the picture moves a point by its depth times that.
    found[:, :2, 2] += moved - np.einsum('nij,nj->ni', slopes, place)
    return found


def _polynomials(amounts: FloatArray) -> FloatArray:
    """Return by which powers the picture moves in both directions, shape (2, p)."""
    return np.asarray(np.einsum('m,mdp->dp', amounts, _COEFFICIENTS))


def _monomials(points: FloatArray, powers: NDArray[np.int64]) -> FloatArray:
    """Return products of powers of the place in the picture, shape (N, p)."""
    x, y = (points[:, :2] / points[:, 2:]).T
    # Raising to powers that are not known beforehand takes thirty times as long.
    of_x, of_y = (np.stack([np.ones_like(one), one, one**2, one**3]) for one in (x, y))
    return np.asarray((of_x[powers[:, 0]] * of_y[powers[:, 1]]).T)
