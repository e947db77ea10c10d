# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A calibrated beam, and a simulator that a test knows through and through."""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
from diffcal_ros.scene.model import Scene
import numpy as np
import pytest
from support.scenes import beam_scene, noisy, observation, true_depth


@dataclass(frozen=True)
class Calibrated:
    """A fit that has been run, and its scene with fitted start values."""

    calibration: Calibration
    result: CalibrationResult
    fitted: Scene


def calibrated(scene, depth):
    """Run a fit without the parts that a test of what follows does not need."""
    settings = CalibrationSettings(search=False)
    calibration = Calibration(scene, [observation(depth)], settings)
    result = calibration.run()
    regions = tuple(
        replace(
            region,
            youngs_modulus=replace(
                region.youngs_modulus,
                start=result.values().get(
                    f'youngs_modulus.{region.name}', result.values().get('youngs_modulus')
                ),
            ),
        )
        for region in scene.regions
    )
    return Calibrated(calibration, result, replace(scene, regions=regions))


@pytest.fixture(scope='session')
def beam():
    """A beam of quadratic elements at nu = 0.45, fitted with a rigid offset that is not zero."""
    depth = noisy(true_depth(), np.random.default_rng(7))
    scene = beam_scene(fit=('youngs_modulus', 'rigid_offset'), modulus=75e3)
    return calibrated(scene, depth)


def settle_linear(body, law, start=None):
    """Return where this package's linear elements come to rest [m], shape (V, 3)."""
    own = find_law(law)
    simulated = StaticBody(body.mesh, Element.LINEAR, body.held, law=own)
    material = Material(
        body.youngs_modulus, body.poissons_ratio, body.density, conversion=own.CONVERSION
    )
    simulated.solve_equilibrium(material, body.gravity)
    return simulated.state.positions.copy()
