# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body whose place the CAD of its clamp gives: which end is held, from where, and how soft."""

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.proposal.find_body import FoundBody
from diffcal_ros.proposal.hold import Hold, possible_holds
from diffcal_ros.proposal.place_fit import fit_place, PlaceFit
from diffcal_ros.scene.model import Fixture, Scene
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from scipy.spatial import cKDTree

# Moduli from where quick fits start [Pa].
_MODULI = (1.5e4, 6e4, 2.5e5, 1e6)
# The clamp begins where the fixture ends, unless it is seen to begin farther off than this [m].
_AS_DRAWN = 0.003
# Parts of the fixture so far beside the body, of the body's width, do not hold it.
_BESIDE = 1.0
_FEWEST_HELD = 3


def body_in_fixture(scene: Scene, observation: Observation) -> FoundBody | None:
    """Fit a body where mesh and fixture have it; None where it cannot be simulated there.

    Args:
        scene: with a fixture and gravity; its clamp is not used.
        observation: the depth image, with the camera's pose from the fixture.
    """
    assert scene.fixture is not None
    hold = fixture_hold(scene.mesh, scene.fixture)
    quick = [
        fit
        for modulus in _MODULI
        if (fit := _fit(scene, observation, hold, modulus, is_quick=True)) is not None
    ]
    if not quick:
        return None
    best = max(quick, key=_merit)
    fit = _fit(scene, observation, hold, best.youngs_modulus, is_quick=False) or best
    plane = fit.clamp.plane
    if fit.clamp.is_seen and abs(plane - hold.plane) > max(_AS_DRAWN, fit.clamp.doubt):
        moved = hold.moved(plane)
        if len(moved.vertices(scene.mesh)) >= _FEWEST_HELD:
            fit = _fit(scene, observation, moved, fit.youngs_modulus, is_quick=False) or fit
    return FoundBody(fit, _merit(fit), (), ())


def fixture_hold(mesh: TetMesh, fixture: Fixture) -> Hold:
    """Return the end of the body that lies in the fixture, held from where that ends.

    Args:
        mesh: the body.
        fixture: in the same frame.
    """
    tree = cKDTree(fixture.positions[fixture.triangles].mean(axis=1))
    low, high = fixture.positions.min(axis=0), fixture.positions.max(axis=0)

    def away(hold: Hold) -> tuple[float, float]:
        held = mesh.rest_positions[hold.vertices(mesh)]
        outside = np.linalg.norm(np.clip(held, low, high) - held, axis=1).mean()
        return float(outside), float(tree.query(held)[0].mean())

    hold = min(possible_holds(mesh), key=away)
    # Only what is beside the body holds it: a foot of the clamp may reach farther.
    held = mesh.rest_positions[hold.vertices(mesh)]
    axis = hold.direction
    across = fixture.positions - np.outer(fixture.positions @ axis, axis)
    middle = held.mean(axis=0) - (held.mean(axis=0) @ axis) * axis
    width = np.linalg.norm(held - np.outer(held @ axis, axis) - middle, axis=1).max()
    near = np.linalg.norm(across - middle, axis=1) <= (1.0 + _BESIDE) * width
    corners = fixture.positions[near] if near.any() else fixture.positions
    plane = float((corners @ axis).min())
    along = mesh.rest_positions @ axis
    moved = hold.moved(float(np.clip(plane, along.min(), along.max())))
    return moved if _FEWEST_HELD <= len(moved.vertices(mesh)) < len(along) else hold


def _fit(
    scene: Scene, observation: Observation, hold: Hold, modulus: float, *, is_quick: bool
) -> PlaceFit | None:
    return fit_place(
        scene,
        observation,
        hold,
        np.eye(4),
        modulus,
        is_quick=is_quick,
        offset=scene.rigid_offset,
    )


def _merit(fit: PlaceFit) -> float:
    """Return how much of the body is covered, and of what is measured explained, 1 at best."""
    gap = fit.result.gap_end
    merit = float(gap.coverage_in_sight * gap.explained)
    return merit if np.isfinite(merit) else 0.0
