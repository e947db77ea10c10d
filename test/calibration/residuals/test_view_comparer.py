# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A view is compared once, as long as nothing that it is compared by has changed."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.robust_residual import make_comparers, Reach
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth

REACH = Reach(depth=0.06, edge_depth=0.09, edge_pixels=60)


@pytest.fixture(scope='module')
def model():
    scene = replace(beam_scene((8, 2, 2)), effects={'depth_affine': {'bias': 0.002}})
    return ForwardModel(
        scene, [observation(true_depth())], make_parameters(scene, ('youngs_modulus',))
    )


def test_a_view_is_compared_once(model):
    (comparer,), start = make_comparers(model), model.parameters.start()
    (view,) = model.views(start)
    once = comparer.compare(view, REACH)
    assert comparer.compare(view, replace(REACH)) is once
    (anew,) = make_comparers(model)
    np.testing.assert_array_equal(anew.compare(view, REACH).depth.values, once.depth.values)


def test_another_image_view_reach_or_sensor_is_compared_anew(model):
    (comparer,), start = make_comparers(model), model.parameters.start()
    (view,) = model.views(start)
    before = comparer.compare(view, REACH)
    (other,) = model.views(start + 0.1)
    assert np.abs(comparer.compare(other, REACH).depth.values).mean() > 1e-4
    near = comparer.compare(view, replace(REACH, depth=1e-5))
    assert len(near.depth.values) < len(before.depth.values)
    shifted = comparer.compare(view, REACH, model.sensor(start, 0)).depth.values
    np.testing.assert_allclose(shifted, before.depth.values - 0.002, atol=1e-9)
    np.testing.assert_array_equal(comparer.compare(view, REACH).depth.values, before.depth.values)
    comparer.show((true_depth() + 0.003).astype(np.float32))
    np.testing.assert_allclose(
        comparer.compare(view, REACH).depth.values, before.depth.values + 0.003, atol=1e-6
    )
