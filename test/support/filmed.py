# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A released beam as a depth camera films it: another mesh and integrator, noise, smooth error."""

from dataclasses import replace
from typing import Any

from diffcal_ros.calibration.observations.observation import Instant, Observation
from diffcal_ros.scene.model import Quantity, QUASI_STATIC, Scene
import numpy as np
from scipy.ndimage import gaussian_filter

from support.moving_beams import DAMPING, instants, moving_scene, true_depths
from support.scenes import noisy

# The release is clocked.
RELEASE = Quantity(0.05, 0.0, 0.2)
# Damping of the material is known from elsewhere, or drag would pass for it within a swing.
KNOWN_DAMPING = Quantity(1.2 * DAMPING, 0.1, 1e4, DAMPING, 0.1 * DAMPING)
FIT = ('youngs_modulus', 'damping')
STIFF, SAGGING = 150e3, 80e3
# A body of which a whole diagnosis takes seconds.
SMALL: dict[str, Any] = {'counts': (4, 1, 1)}
_RATE, _COUNT, _HOLD_OUT = 30.0, 14, 5
_NOISE = 0.00014


def filmed_scene(modulus: float = STIFF, *, is_small: bool = False) -> Scene:
    """Return the scene that a diagnosis starts from: all of its numbers are somewhat off."""
    body = SMALL if is_small else {'counts': (8, 2, 2)}
    scene = moving_scene(modulus=1.15 * modulus, fit=FIT, **body)
    regions = tuple(replace(region, damping=KNOWN_DAMPING) for region in scene.regions)
    (setup,) = scene.observations
    assert setup.motion is not None
    motion = replace(setup.motion, release_time=RELEASE)
    return replace(scene, regions=regions, observations=(replace(setup, motion=motion),))


def filmed(
    *,
    seed: int,
    late: float | np.ndarray = 0.0,
    area: float = 0.0,
    compliance: float = 0.0,
    modulus: float = STIFF,
    is_small: bool = False,
) -> list[Observation]:
    """Film the beam for half a second.

    Args:
        seed: of noise and of the sensor's smooth error.
        late: by which stamps are late [s]; of each frame, shape (14,), or of all.
        area: of the air's drag [m^2].
        compliance: of the clamp [rad/(N m)].
        modulus: Young's modulus [Pa].
        is_small: of the small scene's own mesh.
    """
    random = np.random.default_rng(seed)
    body = SMALL if is_small else {'counts': (10, 3, 3)}
    scene = moving_scene(modulus=modulus, time_step=1.0 / 600.0, **body)
    if area:
        scene = replace(scene, effects={'air_drag': {'area': area}})
    if compliance:
        scene = replace(scene, effects={'compliant_clamp': {'compliance': compliance}})
    stamps = np.arange(_COUNT) / _RATE
    depths = true_depths(scene, [float(t) for t in np.maximum(stamps - late, 0.0)])
    return _frames(stamps, depths, random)


def held_scene() -> Scene:
    """Return the scene of a load that is held for twenty seconds."""
    scene = filmed_scene(SAGGING)
    (setup,) = scene.observations
    assert setup.motion is not None
    motion = replace(setup.motion, integrator=QUASI_STATIC, release_time=Quantity(9.0, 0.0, 60.0))
    return replace(scene, observations=(replace(setup, motion=motion),), fit=('youngs_modulus',))


def filmed_hold(
    *, seed: int, share: float = 0.0, tau: float = 4.0, compliance: float = 0.0
) -> list[Observation]:
    """Film a beam under a load that is held, from another mesh; see `held_scene`.

    Args:
        seed: of noise and of the sensor's smooth error.
        share: of the stresses that relax.
        tau: by this time [s].
        compliance: of the clamp [rad/(N m)].
    """
    scene = moving_scene((10, 3, 3), modulus=SAGGING, release_time=9.0, integrator=QUASI_STATIC)
    if share:
        scene = replace(scene, effects={'creep': {'share': share, 'tau': tau}})
    if compliance:
        scene = replace(scene, effects={'compliant_clamp': {'compliance': compliance}})
    stamps = 1.8 * np.arange(_COUNT)
    depths = true_depths(scene, [float(t) for t in stamps])
    return _frames(stamps, depths, np.random.default_rng(seed))


def _frames(
    stamps: np.ndarray, depths: list[np.ndarray], random: np.random.Generator
) -> list[Observation]:
    smooth = gaussian_filter(random.normal(size=depths[0].shape), 40.0)
    pattern = 0.00012 * smooth / smooth.std()
    frames = instants(stamps, [noisy(depth + pattern, random) for depth in depths])
    return [
        replace(
            frame,
            noise=_NOISE,
            instant=Instant(float(stamp), 0, number % _HOLD_OUT == _HOLD_OUT // 2),
        )
        for number, (frame, stamp) in enumerate(zip(frames, stamps, strict=True))
    ]
