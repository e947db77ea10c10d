# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the blind generator's bodies lie on: how deep they dent it, and how it pushes."""

import numpy as np

from benchmarks.blind.contact import contact_laws, highest_tops
from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import Specimen
from support.blind_derivatives import check_derivatives
from support.blind_rests import lying, rest_of


def dents_of(laid: Setup, faults: Faults, positions: np.ndarray, pose: int = 0) -> np.ndarray:
    """Return how deep nodes dent what is below them, negative above it [m], shape (N,).

    Args:
        laid: with its poses.
        faults: say what it is and how high.
        positions: of the nodes, object frame [m], shape (N, 3).
        pose: number.
    """
    assert faults.contact_height is not None
    world = laid.observations[pose].world_from_object
    tops = highest_tops(positions @ world[:3, :3].T + world[:3, 3], faults)
    return np.asarray(faults.contact_height - tops)


def moves_and_dents(
    laid: Setup, plain: Specimen, faults: Faults
) -> tuple[list[float], list[float]]:
    """Return how far what is level below a body lifts it, and how deep its lowest node dents that.

    Args:
        laid: whose body lies on it in the first pose.
        plain: the body.
        faults: say what it is and how high.

    Returns:
        Moves and dents in four poses, dents negative above it [m].
    """
    assert faults.contact_height is not None
    moves, dents = [], []
    for pose in range(4):
        found, move = lying(laid, plain, faults, pose)
        world = laid.observations[pose].world_from_object
        moves.append(move)
        dents.append(faults.contact_height - float((found @ world[1, :3] + world[1, 3]).min()))
    return moves, dents


def moves_and_outer_dents(
    laid: Setup, plain: Specimen, faults: Faults, beyond: float
) -> tuple[list[float], list[float]]:
    """Return the same of what is not level, and below the outer part alone.

    Args:
        laid: see `moves_and_dents`.
        plain: see there.
        faults: see there.
        beyond: share of the free length where the outer part begins.
    """
    moves, dents = [], []
    for pose in range(4):
        found, move = lying(laid, plain, faults, pose)
        moves.append(move)
        dents.append(float(dents_of(laid, faults, found, pose)[plain.shares > beyond].max()))
    return moves, dents


def _together(laws: tuple[PotentialLaw, ...]) -> PotentialLaw:
    """Return the law of all that a body lies on."""

    def whole(positions: np.ndarray) -> Potential:
        found = [law(positions) for law in laws]
        return Potential(
            energy=sum(each.energy for each in found),
            gradient=np.sum([each.gradient for each in found], axis=0),
            diagonal=np.sum([each.diagonal for each in found], axis=0),
        )

    return whole


def check_pushes(laid: Setup, plain: Specimen, faults: Faults, step: float) -> None:
    """Fail where what a body lies on does not push by its energy, some 2 mm below its rest.

    Args:
        laid: whose body lies on it in the first pose.
        plain: the body.
        faults: say what it is.
        step: by which nodes are moved to either side, by standard normal draws [m].
    """
    law = _together(contact_laws(plain.areas, plain.shares, laid.observations[0], faults))
    up = laid.observations[0].world_from_object[1, :3]
    dented = rest_of(laid, faults) - 0.002 * up
    # But for nodes that just come to it: there a push begins.
    away = np.abs(dents_of(laid, faults, dented)) > 1e-4
    assert away.mean() > 0.9
    stiff = check_derivatives(law, dented, step=step, is_smooth=away, share=1e-4)
    assert np.abs(stiff[away]).max() > 0.0
