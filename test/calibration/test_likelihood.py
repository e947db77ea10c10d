# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Every loss tells its gap and what it sees; only a likelihood tells errors."""

from collections.abc import Callable

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.expected_information import known_after
from diffcal_ros.calibration.field.layout import FieldKind
from diffcal_ros.calibration.field.search import FieldSearch
from diffcal_ros.calibration.joint import JointCalibration
from diffcal_ros.calibration.profile_search import profile
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.tracking.tracker import Tracker
from diffcal_ros.errors import InputError
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth


def _calibration(loss: str) -> Calibration:
    scene = beam_scene((4, 2, 2), modulus=70e3)
    return Calibration(scene, [observation(true_depth())], CalibrationSettings(loss=loss))


@pytest.mark.parametrize(
    'use',
    [
        known_after,
        lambda fit: profile(fit, 'youngs_modulus'),
        lambda fit: FieldSearch(fit, FieldKind()),
        lambda fit: JointCalibration({'one': fit}, {}),
        lambda fit: Tracker(fit, ()),
    ],
)
@pytest.mark.parametrize('loss', ['paper', 'l1'])
def test_what_needs_a_likelihood_refuses_a_whole_image_loss(
    use: Callable[[Calibration], object], loss: str
) -> None:
    with pytest.raises(InputError, match=f"needs the robust loss, not '{loss}'"):
        use(_calibration(loss))


@pytest.mark.parametrize('loss', ['paper', 'l1'])
def test_all_losses_see_the_same_body(loss: str) -> None:
    robust, image = _calibration('robust').objective, _calibration(loss).objective
    there = _calibration(loss).coordinates
    alone = np.append(there, np.zeros(len(robust.model.parameters) - len(there)))
    (view,), (other,) = robust.model.views(alone), image.model.views(there)
    counted = robust.counted(0, view)
    assert 1000 < counted.sum() < counted.size
    np.testing.assert_array_equal(image.counted(0, other), counted)
    read = robust.read_depth(0, view, alone)
    np.testing.assert_array_equal(image.read_depth(0, other, there), read)
    np.testing.assert_array_equal(np.isfinite(read), view.trace.faces >= 0)
    assert image.gap(there).median == robust.gap(alone).median
    assert image.standing(there)[0].rms == image.gap(there).rms
