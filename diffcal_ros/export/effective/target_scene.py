# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit as a simulator sees it: its elements and law, the camera where the fit found it."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.effects.camera_offset import CameraOffset
from diffcal_ros.export.exported_body import constants_at_rest
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import find_law
from diffcal_ros.material import LameConvention, Material
from diffcal_ros.scene.model import Quantity, Region, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Locking takes moduli far below a material's own bounds.
_REACH = 1000.0


def target_scene(fitted: Scene, law: str) -> Scene:
    """Return a fitted scene with linear elements and the law nearest to a simulator's.

    Moduli become what a small stretch measures, free of the bounds and priors of the material.

    Args:
        fitted: with fitted values as start values.
        law: name of it, see `fem.laws`.
    """
    regions = tuple(_at_rest(region, fitted) for region in fitted.regions)
    own = {key: value for key, value in fitted.effects.items() if key != CameraOffset.identifier}
    return replace(
        fitted,
        element=Element.LINEAR,
        law=law,
        convention=LameConvention.CONSISTENT,
        regions=regions,
        effects=own,
    )


def _at_rest(region: Region, scene: Scene) -> Region:
    material = Material(
        youngs_modulus=np.array([region.youngs_modulus.start]),
        poissons_ratio=np.array([region.poissons_ratio.start]),
        density=np.array([region.density.start]),
        convention=scene.convention,
        conversion=find_law(scene.law).CONVERSION,
    )
    modulus, ratio = (float(column[0]) for column in constants_at_rest(material))
    return replace(
        region,
        youngs_modulus=_unbounded(modulus),
        poissons_ratio=Quantity(ratio, min(ratio, 0.0), 0.4999),
        damping=None if region.damping is None else _unbounded(region.damping.start),
    )


def _unbounded(value: float) -> Quantity:
    return Quantity(value, value / _REACH, value * _REACH)


def placed_observations(
    calibration: Calibration, coordinates: FloatArray
) -> tuple[Observation, ...]:
    """Return a fit's observations with their cameras where the fit found them, for good.

    The camera is not the simulator's to move: an offset that was free again would take up what
    the simulator's elements get wrong.

    Args:
        calibration: that was run.
        coordinates: of its parameters, shape (k,).
    """
    cameras = calibration.model.cameras
    return tuple(
        replace(
            seen,
            depth_from_world=cameras.pose(number, coordinates),
            pose_covariance=None,
            pose_pivot=None,
            mirrored=None,
        )
        for number, seen in enumerate(calibration.model.observations)
    )
