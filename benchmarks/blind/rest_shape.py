# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The true shape of a body without stress, object frame."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.bent_parts import bent_parts, Part
from benchmarks.blind.faults import Faults
from benchmarks.blind.rotations import rotation
from benchmarks.blind.shapes import bend, FloatArray, Shape


def true_shape(shape: Shape, faults: Faults) -> Shape:
    """Return the shape that a body has in place of the stated one, bending aside."""
    x, y, z = shape.breaks
    # A body that slid out, or whose jaws gape, is held by so much less, and keeps its shape.
    held = x[1] - 1e-3 * faults.clamp_slid - 1e-3 * faults.clamp_gape
    end = x[-1] - 1e-3 * faults.trimmed
    one, other = shape.taper
    longer = [place + faults.drawn * (place - held) for place in (*x[2:-1], end)]
    return replace(
        shape,
        breaks=((x[0], held, *longer), y, tuple(p * (1.0 + faults.parted) for p in z)),
        waist=shape.waist - faults.bulge,
        taper=(one + faults.cone, other + faults.cone),
        trimmed=1e-3 * faults.trimmed,
        rack=faults.racked,
        drawn=faults.drawn,
        neck=faults.necked,
        neck_at=faults.necked_at,
        dish=faults.dished,
        flat=faults.flattened,
        slope=faults.unlevel,
        draft=faults.drafted,
        ribs=(faults.ribbed, faults.ribbed_waves, faults.ribbed_phase),
        rounds=faults.rounded,
        mitre=1e-3 * faults.mitred * faults.mitred_side,
        jog=(1e-3 * faults.joggled, faults.joggled_at, faults.joggled_way),
        club=faults.clubbed,
        lack=faults.underfilled,
        dome=1e-3 * faults.domed,
        keel=1e-3 * faults.keeled,
        bevel=1e-3 * faults.bevelled,
    )


def stress_free_nodes(nodes: FloatArray, shape: Shape, faults: Faults) -> FloatArray:
    """Return the nodes of a body when nothing pulls on it, shape (N, 3).

    Args:
        nodes: of the body as it is stated [m], shape (N, 3).
        shape: of it.
        faults: say how it is bent.
    """
    curvature = np.array([0.0, *faults.rest_curvature])
    if faults.curvature_form == 'tip':
        return bend(nodes, 0.5 * (shape.clamp + shape.length), 2.0 * curvature)
    if faults.curvature_form == 'root':
        straight_on = bend(nodes, 0.5 * (shape.clamp + shape.length), -2.0 * curvature)
        return bend(straight_on, shape.clamp, 2.0 * curvature)
    parts = bent_parts(curvature, faults)
    if parts is not None:
        return _bent_in_parts(nodes, shape, parts)
    if faults.curvature_form == 'twist':
        rate = float(np.linalg.norm(curvature)) * np.sign(curvature[1] or 1.0)
        angles = rate * np.maximum(nodes[:, 0] - shape.clamp, 0.0)
        y, z = nodes[:, 1], nodes[:, 2]
        turned = [y * np.cos(angles) - z * np.sin(angles), y * np.sin(angles) + z * np.cos(angles)]
        return np.stack([nodes[:, 0], *turned], axis=-1)
    return bend(nodes, shape.clamp, curvature)


def _bent_in_parts(nodes: FloatArray, shape: Shape, parts: list[Part]) -> FloatArray:
    """Bend parts of a body to arcs, the outer one first; what lies beyond is carried along."""
    bent = nodes
    for begin, end, rate in parts:
        first, last = shape.clamp + (shape.length - shape.clamp) * np.array([begin, end])
        joint = np.array([last, 0.0, 0.0])
        beyond = bend(joint, first, rate) + (bent - joint) @ rotation((last - first) * rate).T
        bent = np.where(nodes[:, :1] > last, beyond, bend(bent, first, rate))
    return bent
