# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A place of the body, fitted by the calibration itself: modulus, and a wide offset."""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.proposal.bent_shape import BentShape
from diffcal_ros.proposal.clamp_plane import ClampPlane, find_clamp_plane
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.proposal.place_search import Candidate
from diffcal_ros.rigid_transform import inverse
from diffcal_ros.scene.model import HeldPart, Quantity, RigidOffset, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

CLAMP = 'clamp'
# A place that was looked for is off by so much at most times: of shift [m] and turn [rad].
WIDE = RigidOffset(0.02, float(np.deg2rad(12.0)))
_QUICK_STEPS = 12


@dataclass(frozen=True)
class PlaceFit:
    """A body that was fitted where it may be.

    Attributes:
        hold: what of it is held.
        world_from_object: where it is, what was fitted of the offset included, shape (4, 4).
        youngs_modulus: fitted [Pa].
        points: vertices in the camera's frame [m], shape (V, 3).
        result: of the fit.
        clamp: where the body disappears behind something.
        calibration: at the end of the fit; None of a quick one, of which there are many.
    """

    hold: Hold
    world_from_object: FloatArray
    youngs_modulus: float
    points: FloatArray
    result: CalibrationResult
    clamp: ClampPlane
    calibration: Calibration | None

    def candidate(self, gravity: FloatArray) -> Candidate:
        """Return the same as a place that may be scored.

        Args:
            gravity: in the world frame [m/s^2], shape (3,).
        """
        down = self.world_from_object[:3, :3].T @ gravity
        shape = BentShape(self.hold, down, self.youngs_modulus, self.points)
        return Candidate(shape, np.eye(4), 0.0)


def placed_scene(scene: Scene, hold: Hold, world_from_object: FloatArray, modulus: float) -> Scene:
    """Return a scene with its body elsewhere, held otherwise, and of another modulus.

    Args:
        scene: with one observation, one held part and one region.
        hold: what is held.
        world_from_object: shape (4, 4).
        modulus: where a fit starts [Pa].
    """
    setup, region = scene.observations[0], scene.regions[0]
    held = HeldPart(CLAMP, hold.vertices(scene.mesh))
    usual = region.youngs_modulus
    start = Quantity(float(np.clip(modulus, usual.lower, usual.upper)), usual.lower, usual.upper)
    return replace(
        scene,
        observations=(replace(setup, world_from_object=world_from_object, held=(held,)),),
        regions=(replace(region, youngs_modulus=start),),
    )


def fit_place(
    scene: Scene,
    observation: Observation,
    hold: Hold,
    world_from_object: FloatArray,
    modulus: float,
    *,
    is_quick: bool,
    offset: RigidOffset,
) -> PlaceFit | None:
    """Fit modulus and offset; None where nothing can be simulated or seen from there.

    Args:
        scene: see `placed_scene`.
        observation: the depth image.
        hold: what is held.
        world_from_object: where the body seems to be, shape (4, 4).
        modulus: where the fit starts [Pa].
        is_quick: linear elements and few steps, which is enough to compare places.
        offset: prior of how far the body may be from there.
    """
    there = placed_scene(scene, hold, world_from_object, modulus)
    there = replace(there, rigid_offset=offset)
    if is_quick:
        there = _softened(replace(there, element=Element.LINEAR))
    settings = CalibrationSettings(
        with_mesh_error=False, search=False, max_iterations=_QUICK_STEPS if is_quick else None
    )
    try:
        calibration = Calibration(there, (observation,), settings)
        result = calibration.run()
    except InputError:
        return None
    pose = calibration.model.cameras.pose(0, calibration.coordinates)
    moved = inverse(observation.depth_from_world) @ pose @ world_from_object
    view = calibration.model.views(calibration.coordinates)[0]
    return PlaceFit(
        hold,
        moved,
        result['youngs_modulus'].value,
        view.points[: scene.mesh.vertex_count].copy(),
        result,
        find_clamp_plane(view, observation, moved, hold, scene.mesh, result.gap_end.median),
        None if is_quick else calibration,
    )


def _softened(scene: Scene) -> Scene:
    """Lower Poisson's ratio, near one half of which linear elements lock."""
    region = scene.regions[0]
    ratio = min(region.poissons_ratio.start, 0.4)
    return replace(
        scene,
        regions=(replace(region, poissons_ratio=replace(region.poissons_ratio, start=ratio)),),
    )
