# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Springs between nodes and places that go with the rig, as energies in the object frame."""

import numpy as np

from benchmarks.blind.body import IntArray
from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.shapes import FloatArray

# Jaws that are lined: by which share that is softer at the mouth than at the bolt.
LININGS = {'lined': 0.6, 'boot': 0.0, 'putty': 0.0, 'gel': 0.0, 'bracket': 0.0}
_REACH = 0.05  # Half the share of the free length over which a hose or a thread is fixed.


def springs(places: FloatArray, stiffness: FloatArray) -> PotentialLaw:
    """Return springs that draw nodes to places, in whatever direction they are off.

    Args:
        places: of all nodes [m], shape (N, 3).
        stiffness: of each node's spring [N/m], shape (N,).
    """
    diagonal = stiffness[:, None, None] * np.eye(3)

    def energy(positions: FloatArray) -> Potential:
        away = positions - places
        pull = stiffness[:, None] * away
        return Potential(0.5 * float((pull * away).sum()), pull, diagonal)

    return energy


def putty(places: FloatArray, stiffness: FloatArray, give: float) -> PotentialLaw:
    """Return what draws nodes to places as springs do at first, and ever less the farther.

    Args:
        places: of all nodes [m], shape (N, 3).
        stiffness: of each node at first [N/m], shape (N,).
        give: how far a spring would be drawn out by the most that holds a node [m].
    """

    def energy(positions: FloatArray) -> Potential:
        away = (positions - places) / give
        root = np.sqrt(1.0 + (away**2).sum(axis=1))
        outer = away[:, :, None] * away[:, None, :] / root[:, None, None] ** 2
        return Potential(
            energy=float(give**2 * (stiffness @ (root - 1.0))),
            gradient=(give * stiffness / root)[:, None] * away,
            diagonal=(stiffness / root)[:, None, None] * (np.eye(3) - outer),
        )

    return energy


def foam_stiffness(
    nodes: FloatArray,
    areas: FloatArray,
    held: IntArray,
    clamp: float,
    compliance: float,
    softer: float = LININGS['lined'],
) -> FloatArray:
    """Return how stiff the foam of a jaw is at each node, 0 outside [N/m], shape (N,).

    Args:
        nodes: of the body before it is loaded, object frame [m], shape (N, 3).
        areas: surface that belongs to each [m^2], shape (N,).
        held: nodes in the jaw.
        clamp: where its mouth is [m]; its bolt is at 0.
        compliance: turn of a rigid body in it by its moment, mean of y and z [rad/(N m)].
        softer: share by which it is softer at the mouth.
    """
    found = np.zeros(len(nodes))
    found[held] = areas[held] * (1.0 - softer * nodes[held, 0] / clamp)
    arms = nodes - found @ nodes / found.sum()
    squares = found @ arms**2
    # About y and about z, both have the arms along x.
    found *= 1.0 / (compliance * (squares[0] + 0.5 * (squares[1] + squares[2])))
    return found


def around(amount: float, at: float, masses: FloatArray, shares: FloatArray) -> FloatArray:
    """Share a stiffness or a force among the nodes around a place, shape (N,).

    Args:
        amount: in all.
        at: share of the free length where it acts.
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
    """
    weights = nearby(at, _REACH, masses, shares)
    return np.asarray(amount * weights / weights.sum())


def nearby(at: float, reach: float, masses: FloatArray, shares: FloatArray) -> FloatArray:
    """Return the masses of nodes around a place, the less the farther they are, shape (N,).

    Args:
        at: share of the free length.
        reach: beyond which there is nothing; at least the nearest nodes count.
        masses: of nodes, shape (N,).
        shares: of the free length at which they lie, shape (N,).
    """
    away = np.abs(shares - at)
    near = np.maximum(1.0 - away / max(reach, 1.01 * float(away.min())), 0.0)
    return np.asarray(masses * near * (shares > 0.0))
