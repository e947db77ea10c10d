# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam in several poses, as it was clamped in each."""

from dataclasses import replace
from functools import cache

from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.material import Material
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.scene.posing import world_positions
from diffcal_ros.tet_mesh import TetMesh
import numpy as np

from support.beams import beam_mesh, held_end
from support.scenes import (
    beam_scene,
    CAMERA,
    DENSITY,
    DEPTH_FROM_WORLD,
    GRAVITY,
    MODULUS,
    NU,
    SIZE,
)
from support.watched import several_frames

# All ways in which a clamp may sit elsewhere.
CLAMP = ('x', 'y', 'z', 'rx', 'ry', 'rz')
# How the beam is rolled, and how it sits in its clamp each time [m, rad], world frame.
_ROLLS = (0.0, 0.8, -1.3)
_SITS = (
    (0.0, 0.0018, 0.0, 0.03, 0.0, -0.067),
    (0.0, -0.0012, 0.0015, 0.0, 0.045, 0.03),
    (0.0015, 0.0006, -0.0022, -0.045, -0.03, 0.052),
)


def clamped_anew():
    """Return a scene of three poses that knows of no offset, and what was seen of them."""
    return rolled(_ROLLS, _SITS, (10, 3, 3))


@cache
def beam_in_two_poses(layers: int):
    """Return a scene of the beam as it is and rolled by 0.8, and what was seen of it, found once.

    Args:
        layers: of elements along the scene's mesh.
    """
    return rolled((0.0, 0.8), np.zeros((2, 6)), (layers, 2, 2))


def rolled(rolls, sits, counts):
    """Return a scene of several poses that knows of no offset, and what was seen of them.

    Args:
        rolls: how the beam is rolled in each [rad], shape (n,), or turned: rotation vectors,
            shape (n, 3).
        sits: how it sits in its clamp [m, rad], world frame, shape (n, 6).
        counts: elements of the scene's mesh.
    """
    scene = beam_scene(counts)
    setup = scene.observations[0]
    mesh, random = beam_mesh((14, 4, 4), SIZE), np.random.default_rng(5)
    setups, seen = [], []
    for number, (roll, offset) in enumerate(zip(rolls, sits, strict=True)):
        turn = np.array([roll, 0.0, 0.0]) if np.ndim(roll) == 0 else np.asarray(roll)
        turned = transform(rotation_matrix(turn), np.zeros(3))
        own = replace(
            setup, name=f'pose_{number}', world_from_object=setup.world_from_object @ turned
        )
        rest = world_positions(mesh, own)
        body = StaticBody(TetMesh(rest, mesh.tets), Element.QUADRATIC, held_end(mesh))
        ones = np.ones(mesh.tet_count)
        state = body.solve_equilibrium(
            Material(MODULUS * ones, NU * ones, DENSITY * ones),
            GRAVITY,
            conditions=Conditions(clamp_motion=np.array(offset)),
        )
        points = apply(DEPTH_FROM_WORLD, state.positions)
        tracer = DepthTracer(body.discretisation.surface_triangles, len(points), CAMERA)
        frames = several_frames(tracer.trace(points).full_depth(), random)
        seen.append(replace(frames, name=own.name, setup_index=number))
        setups.append(own)
    return replace(scene, observations=tuple(setups)), seen


def lifted(scene, lifts):
    """Return a scene whose poses are stated so much higher than they are [m], shape (n,)."""
    setups = [
        replace(
            own, world_from_object=own.world_from_object @ transform(np.eye(3), (0.0, 0.0, lift))
        )
        for own, lift in zip(scene.observations, lifts, strict=True)
    ]
    return replace(scene, observations=tuple(setups))
