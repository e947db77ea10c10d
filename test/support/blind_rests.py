# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the blind generator's bodies come to rest, in coarse cells."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.blind.faults import Faults
from benchmarks.blind.hexahedra import integrate, mesh_hexahedra
from benchmarks.blind.laying import softer
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, settle, Specimen
from support.blind_draws import draw_faults, draw_sealed

COARSE = 0.5


def rest_of(setup: Setup, faults: Faults, pose: int = 0) -> np.ndarray:
    """Return node positions in a pose, object frame [m], shape (N, 3)."""
    return settle(make_specimen(setup, faults, COARSE), setup, setup.observations[pose], faults)


def tip_moves(setup: Setup, plain: Specimen, faults: Faults, at_tip: np.ndarray) -> list[float]:
    """Return how far the tip is from where it would be without faults, in each pose [m].

    Args:
        setup: of four poses.
        plain: the body without faults.
        faults: of the other one.
        at_tip: which of its nodes are the tip, shape (N,).
    """
    moves = []
    for pose in range(4):
        found, clean = rest_of(setup, faults, pose), rest_of(setup, Faults(), pose)
        tip = clean[plain.shares > 0.99].mean(axis=0)
        moves.append(float(np.linalg.norm(found[at_tip].mean(axis=0) - tip)))
    return moves


def lying(setup: Setup, plain: Specimen, faults: Faults, pose: int) -> tuple[np.ndarray, float]:
    """Return where a body rests on what is below it, and how far its tip is from hanging [m].

    Args:
        setup: with what is below.
        plain: the body without faults.
        faults: which say what is below; others hang the same.
        pose: number.
    """
    found = rest_of(setup, faults, pose)
    hanging = rest_of(setup, replace(faults, contact_height=None), pose)
    return found, float(np.linalg.norm((found - hanging)[plain.shares > 0.99].mean(axis=0)))


def rubber_volumes(setup: Setup, faults: Faults) -> tuple[float, float]:
    """Return how much rubber is in a true body and in the stated one [m^3].

    Fails where a part of either is turned inside out.

    Args:
        setup: with the stated one.
        faults: of the true one.
    """
    volumes = []
    for each in (faults, Faults()):
        mesh = mesh_hexahedra(true_shape(setup.shape, each))
        parts = integrate(mesh.nodes, mesh.cells).volumes
        assert parts.min() > 0.0
        volumes.append(float(parts.sum()))
    return volumes[0], volumes[1]


def tip_rises(setup: Setup, listed: Iterable[Faults]) -> list[float]:
    """Return how much higher each fault leaves the tip than none does, object frame [m]."""
    tip = make_specimen(setup, Faults(), COARSE).shares > 0.99
    hanging = rest_of(setup, Faults())
    return [float((rest_of(setup, own) - hanging)[tip, 2].mean()) for own in listed]


def check_rests_where_borne(
    setup: Setup, plain: Specimen, faults: Faults, pose: int, compliance: np.ndarray
) -> None:
    """Check that a clamp moved by what its compliance makes of what its body bears on it.

    Args:
        setup: see `clamp_motion_and_load`.
        plain: likewise.
        faults: likewise.
        pose: likewise.
        compliance: shift and turn per force and moment, shape (6, 6).
    """
    motion, load = clamp_motion_and_load(setup, plain, faults, pose)
    assert motion == pytest.approx(compliance @ load, abs=2e-5)
    assert np.linalg.norm(motion[3:]) > 0.01


def clamp_motion_and_load(
    setup: Setup, plain: Specimen, faults: Faults, pose: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return how a clamp moved and what its body bears on it, about its center, object frame.

    Args:
        setup: with the pose.
        plain: the body without faults.
        faults: by which the clamp gives way.
        pose: number.

    Returns:
        Shift [m] and turn [rad], and force [N] and moment [N m], shapes (6,).
    """
    held, center = plain.mesh.held, plain.center
    rest = rest_of(setup, faults, pose)
    turn = turn_of(plain.mesh.nodes[held], rest[held])
    around = Rotation.from_rotvec(turn).apply(plain.mesh.nodes[held] - center)
    shift = (rest[held] - around - center).mean(axis=0)
    down = -setup.observations[pose].world_from_object[1, :3]
    weight = GRAVITY * plain.body.masses[:, None] * down
    moment = np.cross(rest - center - shift, weight).sum(axis=0)
    return np.concatenate([shift, turn]), np.concatenate([weight.sum(axis=0), moment])


def turn_of(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return the rotation vector by which points turned as a whole [rad]."""
    left, _, right = np.linalg.svd((before - before.mean(axis=0)).T @ (after - after.mean(axis=0)))
    turn = (left @ right).T
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine = 0.5 * np.linalg.norm(axis)
    return np.asarray(0.5 * axis * np.arcsin(sine) / max(sine, 1e-30))


def moved_by_what_stiffens(name: str, family: str) -> list[float]:
    """Return how far two sizes of what stiffens one side hold a soft body's tip back [m].

    It holds where that side is strained, and as good as not upside down.

    Args:
        name: of a form of `strain_stiffening`.
        family: of the body.
    """
    drawn = draw_sealed(family)
    soft, moves = softer(drawn, 0.3), []
    tip = make_specimen(soft, Faults(), COARSE).shares > 0.99
    bare = [rest_of(soft, Faults(), pose)[tip].mean(axis=0) for pose in (0, 3)]
    for size in (1, 2):
        faults = draw_faults(name, drawn, size)
        held = [rest_of(soft, faults, pose)[tip].mean(axis=0) for pose in (0, 3)]
        level, over = np.linalg.norm(np.subtract(held, bare), axis=1)
        assert over < 0.1 * level
        moves.append(float(level))
    return moves
