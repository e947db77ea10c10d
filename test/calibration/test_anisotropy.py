# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fibres along one direction, found from depth; and what one load alone cannot say."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.rigid_transform import apply
from diffcal_ros.synthetic.posed_body import pose_body
import numpy as np
import pytest
from support.scenes import beam_scene, CAMERA, DEPTH_FROM_WORLD, noisy, observation

RATIO = 1.8


@pytest.fixture(scope='module')
def seen():
    """A hanging beam with fibres along it, from another mesh, with noise."""
    scene = beam_scene((10, 3, 3))
    fibres = {'anisotropy': {'ratio': RATIO}}
    body = pose_body(scene, scene.observations[0], effects=fibres)
    points = apply(DEPTH_FROM_WORLD, body.positions)
    depth = DepthTracer(body.triangles, len(points), CAMERA).trace(points).full_depth()
    return observation(noisy(depth, np.random.default_rng(7)))


def test_ratio_is_found_where_the_modulus_is_known(seen) -> None:
    # Without the prior that holds effects near zero in a diagnosis the data alone must tell.
    found = calibrate(beam_scene(), [seen], CalibrationSettings(fit=('anisotropy',)))
    ratio = found['anisotropy.ratio']
    assert abs(ratio.value - RATIO) <= max(1.96 * ratio.std_error, 0.1 * RATIO)
    assert found.gap_end.median < 0.25e-3


def test_fibres_across_do_not_explain_it(seen) -> None:
    """Fibres the other way hardly stiffen a bend: a gap is left, or the bound is reached."""
    across = replace(beam_scene(), effects={'anisotropy': {'ratio': 0.5, 'y': 1.0}})
    settings = CalibrationSettings(fit=('anisotropy',), with_mesh_error=False)
    wrong = calibrate(across, [seen], settings)
    right = calibrate(beam_scene(), [seen], settings)
    assert wrong.gap_end.rms > 3.0 * right.gap_end.rms


@pytest.mark.slow
def test_one_bend_cannot_tell_fibres_from_a_stiffer_material(seen) -> None:
    both = calibrate(
        beam_scene(),
        [seen],
        CalibrationSettings(fit=('anisotropy', 'youngs_modulus'), with_mesh_error=False),
    )
    alone = calibrate(
        beam_scene(), [seen], CalibrationSettings(fit=('anisotropy',), with_mesh_error=False)
    )
    errors = [result['anisotropy.ratio'].std_error for result in (alone, both)]
    assert errors[1] > 5.0 * errors[0]
