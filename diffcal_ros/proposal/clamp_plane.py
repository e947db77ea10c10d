# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the clamp begins: where the measured body disappears behind something.

The body is drawn whole, the part in the clamp too. Towards its free end the camera sees it,
towards the clamp something nearer hides it, and the clamp begins in between.
"""

from dataclasses import dataclass

from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.rigid_transform import apply, inverse
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Along the body, pixels are counted in slices of so much [m].
_SLICE = 0.001
# The clamp is looked for in this share of the length, from the held end on.
_SHARE = 0.6
# Something nearer by at least this hides the body [m], or by so many gaps of the fit.
_NEARER, _GAPS = 0.0025, 3.0
# Slices with fewer pixels tell nothing.
_FEWEST = 5
# On either side, this share of the slices says clearly what it should.
_CLEAR = 0.8


@dataclass(frozen=True)
class ClampPlane:
    """Where a body disappears.

    Attributes:
        plane: coordinate along the hold's direction, object frame [m].
        doubt: how far it may be off [m].
        is_seen: something was seen to hide the body there.
        is_oblique: the camera stands behind the plane, so that the clamp may hide some of the
            free body as well.
    """

    plane: float
    doubt: float
    is_seen: bool
    is_oblique: bool


def find_clamp_plane(
    view: View,
    observation: Observation,
    world_from_object: FloatArray,
    hold: Hold,
    mesh: TetMesh,
    gap: float,
) -> ClampPlane:
    """Look where a fitted body disappears.

    Args:
        view: of the body.
        observation: what was measured.
        world_from_object: where the held part is, shape (4, 4).
        hold: which end is held, and from where in the fit.
        mesh: the body at rest.
        gap: median gap of the fit [m].
    """
    trace, depth = view.trace, observation.depth
    drawn = np.full(depth.shape, np.nan)
    drawn[trace.rows, trace.columns] = trace.depth
    object_from_depth = inverse(observation.depth_from_world @ world_from_object)
    rows, columns = np.nonzero(np.isfinite(drawn) & np.isfinite(depth))
    points = observation.camera.rays()[rows, columns] * drawn[rows, columns][:, None]
    direction = hold.direction
    along = apply(object_from_depth, points) @ direction
    nearer = drawn[rows, columns] - depth[rows, columns]
    reach = max(_NEARER, _GAPS * gap)
    # What is looked through is not in a clamp either.
    is_hidden, is_seen = nearer > reach, nearer <= reach
    rest = mesh.rest_positions @ direction
    low = float(rest.max() - _SHARE * np.ptp(rest))
    slices, hidden = _hidden_shares(along, is_hidden, is_seen, low, float(rest.max()))
    eye = float(object_from_depth[:3, 3] @ direction)
    return _split(slices, hidden, hold.plane, eye)


def _hidden_shares(
    along: FloatArray,
    is_hidden: NDArray[np.bool_],
    is_seen: NDArray[np.bool_],
    low: float,
    high: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the middles of slices [m], and which share of each is hidden, shape (S,) both."""
    edges = np.arange(low, high + _SLICE, _SLICE)
    hidden = np.histogram(along[is_hidden], edges)[0].astype(np.float64)
    seen = np.histogram(along[is_seen], edges)[0]
    told = hidden + seen >= _FEWEST
    middles = 0.5 * (edges[1:] + edges[:-1])
    return middles[told], hidden[told] / (hidden + seen)[told]


def _split(slices: FloatArray, hidden: FloatArray, before: float, eye: float) -> ClampPlane:
    """Choose the plane that leaves as little as it can hidden below it and seen above."""
    if not len(slices):
        return ClampPlane(before, np.inf, is_seen=False, is_oblique=eye > before)
    below = np.concatenate([[0.0], np.cumsum(hidden)])
    above = np.concatenate([np.cumsum((1.0 - hidden)[::-1])[::-1], [0.0]])
    cost = below + above
    best = int(np.argmin(cost))
    edges = np.concatenate([slices - 0.5 * _SLICE, [slices[-1] + 0.5 * _SLICE]])
    plane = float(edges[best])
    is_clear = bool(
        0 < best < len(slices)
        and np.mean(hidden[best:] > 0.5) >= _CLEAR
        and np.mean(hidden[:best] < 0.5) >= _CLEAR
    )
    # What is as likely but for two slices.
    likely = edges[cost <= cost[best] + 2.0]
    doubt = max(_SLICE, float(np.abs(likely - plane).max()))
    if not is_clear:
        return ClampPlane(before, max(doubt, abs(plane - before)), False, eye > before)
    return ClampPlane(plane, doubt, is_seen=True, is_oblique=eye > plane)
