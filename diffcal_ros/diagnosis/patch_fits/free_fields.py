# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Smooth fields that could move the picture of a body, one family for each class of causes.

None of them is a cause: they are what a cause of that class, whatever it is, would do. What
tells them apart is where they stay the same from pose to pose: in the camera's frame, in the
world's, in the body's own, in its stiffness or in how its clamp holds it.
"""

from collections.abc import Callable
from itertools import product

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import Conditions
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Middles of the hat functions along the body, and their half width.
_PLACES, _HALF_WIDTH = (1.0 / 3.0, 2.0 / 3.0, 1.0), 1.0 / 3.0
_IMAGE_DEGREE = 3
# Of one less the cosine at which a surface is met.
_SLANTS = (1, 2)
_BINS = 8
# Of the places along the body that a bend at rest moves as.
_DEGREES = (1, 2, 3, 4)


def free_fields(model: ForwardModel, coordinates: FloatArray) -> dict[str, list[FloatArray]]:
    """Return the fields of every class at a fit.

    Args:
        model: of the nominal scene.
        coordinates: of its fit, shape (c,).

    Returns:
        By class, for each view, how its points move [m], camera frame, shape (k, N, 3); each
        field moves the points of all views by 1 mm root mean square.
    """
    fields = {
        'load': model.tangents_of(_forces(model), coordinates),
        'material': model.tangents_of(_moduli(model, coordinates), coordinates),
        'boundary': model.tangents_of(_clamp_motions, coordinates),
        'sensor': [_image_fields(view) for view in model.views(coordinates)],
        'shape': [
            _shape_fields(model, number, view.points)
            for number, view in enumerate(model.views(coordinates))
        ],
    }
    return {name: _of_one_size(own) for name, own in fields.items()}


def _of_one_size(fields: list[FloatArray]) -> list[FloatArray]:
    squares = np.mean([np.mean((field**2).sum(axis=-1), axis=-1) for field in fields], axis=0)
    sizes = np.sqrt(squares)
    kept = sizes > 1e-9 * sizes.max()
    return [1e-3 * field[kept] / sizes[kept, None, None] for field in fields]


def _hats(fraction: FloatArray) -> FloatArray:
    """Return hat functions along the body, shape (h, ...)."""
    return np.stack(
        [np.clip(1.0 - np.abs(fraction - index) / _HALF_WIDTH, 0.0, 1.0) for index in _PLACES]
    )


def _forces(model: ForwardModel) -> Callable[[int, StaticBody], list[Change]]:
    """Return forces that are the same in the world, whatever the pose."""

    def changes(index: int, body: StaticBody) -> list[Change]:
        fraction = model.effects.axes(index).fraction(body.discretisation.rest_nodes)
        return [
            Change(conditions=Conditions(forces=hat[:, None] * axis))
            for hat, axis in product(_hats(fraction), np.eye(3))
        ]

    return changes


def _moduli(
    model: ForwardModel, coordinates: FloatArray
) -> Callable[[int, StaticBody], list[Change]]:
    """Return stiffer and softer parts: along the body, and across and from skin to core."""
    modulus = model.material(coordinates).youngs_modulus
    mesh = model.scene.mesh
    middles = mesh.rest_positions[mesh.tets].mean(axis=1)

    def changes(index: int, body: StaticBody) -> list[Change]:
        axes = model.effects.object_axes(index)
        across = axes.across(middles, middles).T
        modes = [np.ones(len(middles)), across[0], across[1], *(across**2)]
        return [
            Change(youngs_modulus=modulus * hat * mode)
            for hat, mode in product(_hats(axes.fraction(middles)), modes)
        ]

    return changes


def _clamp_motions(index: int, body: StaticBody) -> list[Change]:
    motions = [Change(conditions=Conditions(clamp_motion=row)) for row in np.eye(6)]
    # Alike in all directions: per force, and per moment.
    ways = (np.diag(np.repeat(way, 3)) for way in np.eye(2))
    return [*motions, *(Change(conditions=Conditions(clamp_compliance=way)) for way in ways)]


def _image_fields(view: View) -> FloatArray:
    """Return what is fixed to the camera, shape (k, N, 3).

    Polynomials of the picture, and depths that are read wrong by the angle at which it meets a
    surface.
    """
    points = view.points
    across, down = (points[:, :2] / points[:, 2:]).T
    powers = [
        across**i * down**j
        for i, j in product(range(_IMAGE_DEGREE + 1), repeat=2)
        if i + j <= _IMAGE_DEGREE
    ]
    moved = [power[:, None] * axis for power, axis in product(powers, np.eye(3))]
    aslant = 1.0 - _facing(view)
    read = [(aslant**degree)[:, None] * points for degree in _SLANTS]
    return np.stack([*moved, *read])


def _facing(view: View) -> FloatArray:
    """Return the cosine at which what is seen around each node is met, shape (N,); 1 elsewhere."""
    is_met = view.trace.facing > 0.0
    corners, count = view.tracer.triangles[is_met].ravel(), len(view.points)
    met = np.bincount(corners, minlength=count)
    total = np.bincount(corners, np.repeat(view.trace.facing[is_met], 3), minlength=count)
    return np.where(met > 0, total / np.maximum(met, 1), 1.0)


def _shape_fields(model: ForwardModel, number: int, points: FloatArray) -> FloatArray:
    """Return changes of the shape at rest that go along with the body, shape (k, N, 3)."""
    observation = model.observations[number]
    rest = model.body(observation).discretisation.rest_nodes
    axes = model.effects.axes(observation.setup_index)
    fraction = axes.fraction(rest)
    bends = [fraction[:, None] ** degree * axis for degree in (1, 2, 3) for axis in axes.axes]
    across = axes.across(rest, rest).T
    sections = [
        (hat * index)[:, None] * axis
        for hat in _hats(fraction)
        for index, axis in zip(across, axes.axes[1:], strict=True)
    ]
    return _going_along(np.stack([*bends, *sections]), rest, points, fraction)


def bend_fields(model: ForwardModel, coordinates: FloatArray) -> list[FloatArray]:
    """Return how points move if the body is bent at rest otherwise than as an arc.

    From a kink at the clamp to a bend at the tip, about both axes across it, and a twist.

    Args:
        model: of the body.
        coordinates: of a fit, shape (c,).

    Returns:
        For each view shape (k, N, 3), camera frame, in units of the free length.
    """
    found = []
    for number, view in enumerate(model.views(coordinates)):
        observation = model.observations[number]
        rest = model.body(observation).discretisation.rest_nodes
        axes = model.effects.axes(observation.setup_index)
        fraction = axes.fraction(rest)
        bends = [fraction[:, None] ** n * axis for n in _DEGREES for axis in axes.axes[1:]]
        beside = rest - axes.root
        beside -= np.outer(beside @ axes.axes[0], axes.axes[0])
        twist = fraction[:, None] * np.cross(axes.axes[0], beside) / np.abs(beside).max()
        found.append(_going_along(np.stack([*bends, twist]), rest, view.points, fraction))
    return found


def _going_along(
    fields: FloatArray, rest: FloatArray, points: FloatArray, fraction: FloatArray
) -> FloatArray:
    """Turn fields on the body at rest as the body has turned, shape (k, N, 3)."""
    turned = _local_rotations(rest, points, fraction)
    return np.einsum('nij,knj->kni', turned, fields)


def _local_rotations(rest: FloatArray, points: FloatArray, fraction: FloatArray) -> FloatArray:
    """Return how the body has turned along its length, rest to camera, shape (N, 3, 3)."""
    bins = np.minimum((fraction * _BINS).astype(int), _BINS - 1)
    turned = np.tile(_rotation(rest, points), (len(rest), 1, 1))
    for number in range(_BINS):
        own = bins == number
        if own.sum() > 3:
            turned[own] = _rotation(rest[own], points[own])
    return turned


def _rotation(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return the rotation that fits best (Kabsch)."""
    spread = (after - after.mean(axis=0)).T @ (before - before.mean(axis=0))
    left, _, right = np.linalg.svd(spread)
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return np.asarray(left @ flip @ right)
